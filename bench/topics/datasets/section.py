"""One section a problem: its trials, their statistics and the tests of every pair."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from bench.analysis import effect_size
from bench.analysis.instances import SOLVED
from bench.analysis.kolmogorov_smirnov import TIED
from bench.analysis.pairwise import CUTOFFS
from bench.report.parts import MOST_ROWS, Part, Section, Table
from bench.report.wording import count, interval, listing, usual_decimals
from bench.topics.datasets.figures import distribution_figure
from bench.topics.findings import BEST, CROWD, MANY_OPTIMIZERS, Final, Findings

TITLE = "Problem by problem"
SHOWN = 20  # of many optimizers, in the figure of a problem; of a crowd, in its tables


def section(findings: Findings) -> Section:
    """Return a section for each problem of the study: all its trials, their statistics and the tests of every pair."""
    every = [entry.label for entry in findings.study.problems]
    rates = findings.anytime.success if findings.trials.traces else pd.DataFrame()
    words, bounds = zip(*reversed(CUTOFFS.items()), strict=True)  # from small to large
    above, below = (listing([f"{bound:.2f}" for bound in side]) for side in (bounds, [1 - bound for bound in bounds]))
    how_to_read = (
        "Boxes span the quartiles, whiskers reach the furthest point within 1.5 box lengths, and every trial is a "
        "point. A12 is the probability that a trial of the first optimizer ends below a trial of the second, ties "
        f"counted half. A12 = 0.5 means no tendency; an effect with A12 of at least {above} (or at most {below}) is "
        f"called {listing(words)}. KS D is the largest distance between the two empirical "
        f"distribution functions, and KS p its exact p-value (given the ties, where more than {TIED:.0%} of the values "
        "are tied)."
    )
    subsections = tuple(_problem(findings, problem, rates) for problem in every)
    return Section(TITLE, (how_to_read,), sections=subsections, on_demand=True)


def _problem(findings: Findings, problem: str, rates: pd.DataFrame) -> Section:
    if problem not in findings.trials.problems:
        missing = ("No optimizer has a trial on this problem yet.",)
        return Section(problem, warnings=missing, folded=True, problem=problem)
    coverage = findings.trials.coverage[findings.trials.coverage["problem"] == problem]
    empty = list(coverage.loc[coverage["stored"] == 0, "optimizer"])
    warnings = [f"No trial of {listing(empty)} on this problem."] if empty else []
    items: list[Part] = [
        distribution_figure(
            findings.trials.frame,
            problem,
            findings.trials.optima.get(problem),
            findings.trials.known[problem].expected,
            SOLVED if problem in findings.trials.precisions else None,
            _best(findings, problem),
        ),
        _abridged(findings, problem, _cells(findings, problem, rates)),
    ]
    if len(table := findings.anytime.running_times) and (table["problem"] == problem).any():
        items.append(_abridged(findings, problem, _running_times(findings, problem)))
    pairs = findings.final.tested_pairs[findings.final.tested_pairs["problem"] == problem]
    text = []
    if problem in findings.trials.precisions:
        instances = len(findings.trials.pooled.members[problem])
        text.append(
            f"A cell holds the trials of {instances} instances, and a value is a precision, the best objective value "
            "less the optimum of the instance."
        )
    if len(pairs):
        items.append(_pairs(findings, problem, pairs))
        text.append(
            f"One optimizer is separably lower in {int((pairs['lower'] != '').sum())} of {count(len(pairs), 'pair')}."
        )
        if few := int((~pairs["testable"].astype(bool)).sum()):
            text.append(
                f"{few} of {count(len(pairs), 'pair')} cannot be significant beside all other tests, whatever the "
                f"values, because there are too few trials; from {findings.final.enough} a cell on one can."
            )
    return Section(problem, tuple(text), tuple(items), tuple(warnings), folded=True, problem=problem)


def _best(findings: Findings, problem: str) -> list[str] | None:
    """Return the best of many optimizers on a problem, in their order; None where there are few."""
    return _by_rank(findings.final, problem)[:SHOWN] if len(findings.trials.optimizers) > MANY_OPTIMIZERS else None


def _by_rank(final: Final, problem: str) -> list[str]:
    ranked = final.standings[final.standings["problem"] == problem]
    return list(ranked.sort_values("rank", kind="stable")["optimizer"])


def _abridged(findings: Findings, problem: str, table: Table) -> Table:
    """Return a table with a row an optimizer; of a crowd, the page shows the best ones of the problem."""
    if not findings.display.crowd:
        return table
    order = [label for label in _by_rank(findings.final, problem) if label in table.frame.index]
    order += [label for label in table.frame.index if label not in order]  # a row beside the optimizers
    frames = {name: getattr(table, name) for name in ("frame", "bold", "lost")}
    moved = {name: frame.reindex(order) for name, frame in frames.items() if frame is not None}
    return replace(table, **moved, most_rows=SHOWN, note=f"{table.note} In the order of their ranks.")


def _cells(findings: Findings, problem: str, rates: pd.DataFrame) -> Table:
    summary, matrix, chosen = findings.final.summary, findings.final.matrix, findings.anytime.target_set
    cells = summary[summary["problem"] == problem].set_index("optimizer").drop(columns="problem")
    shown = cells[["n", "failed", "median", "mean", "sd", "best", "worst"]].rename(columns={"sd": "SD"})
    decimals = usual_decimals(cells["median"])
    shown.insert(3, "median 95%", _intervals(cells["median_low"], cells["median_high"], decimals))
    subject = findings.final.subject
    if marked := "sign" in matrix:
        shown[f"against {subject}"] = matrix[matrix["problem"] == problem].set_index("optimizer")["sign"]
    if len(rates):
        reached = (
            rates[(rates["problem"] == problem) & (rates["tau"] == chosen.level)]
            .set_index("optimizer")
            .reindex(cells.index)
        )
        shown["success %"] = 100 * reached["rate"]
        shown["success 95%"] = _intervals(100 * reached["low"], 100 * reached["high"], 0)
    value = "precision" if problem in findings.trials.precisions else "best objective value"
    return Table(
        f"cells-{problem}",
        f"{problem}: trials, failures, and the {value} over trials.",
        shown,
        lost=shown[["failed"]] > 0,
        decimals={"success %": 0},
        note="The interval of the median is distribution-free; "
        + ("signs as in the comparison; " if marked else "")
        + f"success: trials that reached {chosen.at(chosen.level)}, with a 95% Wilson interval. –: too few trials.",
        data=cells.reset_index(),
    )


def _running_times(findings: Findings, problem: str) -> Table:
    chosen, table = findings.anytime.target_set, findings.anytime.running_times
    rows = table[table["problem"] == problem]
    shown = rows.pivot(index="optimizer", columns=chosen.unit, values="ert").reindex(findings.trials.optimizers)
    shown = shown.rename(columns=chosen.level_text).rename_axis(index="optimizer", columns=None)
    shown = shown.astype(float).iloc[:, ::-1]
    lowest = shown.eq(shown.min()) & np.isfinite(shown)
    last = rows[rows[chosen.unit] == rows[chosen.unit].min()].set_index("optimizer").reindex(shown.index)
    never = [
        f"∞ ({spent:,.0f})" if np.isinf(ert) else ""
        for ert, spent in zip(last["ert"], last["unsuccessful"], strict=True)
    ]
    texts = pd.DataFrame({shown.columns[-1]: never}, index=shown.index) if len(shown.columns) else None
    level = _level(rows, chosen.unit)
    of = rows[rows[chosen.unit] == level]
    hardest = rows[chosen.unit].min()
    note = (
        "Bold: the lowest of a column; ∞: no trial succeeded, in brackets the median evaluations of the trials; "
        f"successes: trials that reached {chosen.level_text(hardest)}."
    )
    if len(of):
        of = of.set_index("optimizer").reindex(findings.trials.optimizers)
        ert = of["ert"].astype(float)
        seconds = of["ert_s"].astype(float)
        shown["95%"] = _intervals(of["low"], of["high"], usual_decimals(ert))
        shown["ERT / d"], shown["seconds"] = of["ert_per_d"].astype(float), seconds
        for column in ("ERT / d", "seconds"):
            lowest[column] = shown[column].eq(shown[column].min()) & np.isfinite(shown[column])
        note += (
            f" At {chosen.at(level)}, the hardest target that the most optimizers reached: a 95% interval of the "
            "ERT, in which a failure may cost the whole budget, and the ERT in evaluations / d and in seconds of wall "
            "time, at the pace of each trial. The CSV file has percentiles of simulated restarts."
        )
    shown["successes"] = [
        "" if pd.isna(trials) else f"{reached:.0f}/{trials:.0f}"
        for reached, trials in zip(last["successes"], last["trials"], strict=True)
    ]
    if precisions := findings.anytime.precisions_at(chosen.tabled).get(problem):
        texts_of = [
            f"{precision:.2g} ({chosen.level_text(tau)})"
            for tau, precision in zip(chosen.tabled, precisions, strict=True)
        ]
        note += f" The targets are the precisions {listing(texts_of)}."
    best = findings.anytime.best_times
    own_best = best[(best["problem"] == problem) & best["ert"].notna()].set_index("tau")["ert"]
    if len(own_best):
        shown.loc[BEST] = own_best.rename(index=chosen.level_text).reindex(shown.columns)
        shown = shown.fillna({name: "" for name in ("95%", "successes") if name in shown})
        lowest = lowest.reindex(shown.index, fill_value=False)
        note += " The best of 2009: the lowest ERT of any algorithm of BBOB 2009 to each target, as cocopp has it."
    return Table(
        f"running-times-{problem}",
        f"{problem}: expected running time (ERT) in evaluations to each target, by {chosen.unit}.",
        shown,
        bold=lowest,
        texts=None if texts is None else texts.reindex(shown.index, fill_value=""),
        note=note,
        data=chosen.in_unit(rows, chosen.unit),
    )


def _level(rows: pd.DataFrame, unit: str) -> float:
    """Return the hardest target that the most optimizers reached; missing where no trial reached any."""
    reached = (rows["successes"] > 0).groupby(rows[unit]).sum()
    return float(reached.index[reached == reached.max()].min()) if reached.max() > 0 else np.nan


def _pairs(findings: Findings, problem: str, every: pd.DataFrame) -> Table:
    """Return the tests of every pair, of many optimizers those of the first one alone; the file has all."""
    pairs, which, crowd = every, findings.final.pairs_words, findings.display.crowd
    if len(findings.trials.optimizers) > MANY_OPTIMIZERS:
        ranked = findings.final.standings[findings.final.standings["problem"] == problem].dropna(subset="rank")
        best = ranked.sort_values("rank", kind="stable")["optimizer"].iloc[0]
        pairs = every[(every["first"] == best) | (every["second"] == best)].sort_values("p_holm", kind="stable")
        which = f"{best}, the first in rank, and every other optimizer; "
        which += (
            f"tables/tests.csv has the pairs of the {CROWD} best, bench.analysis.pairwise_tests makes all"
            if crowd
            else f"the file has all {len(every):,} pairs"
        )
    chance = pairs["a12"]
    shown = pd.DataFrame(
        {
            "A12": chance,
            "A12 95%": _intervals(pairs["a12_low"], pairs["a12_high"], 2),
            "jointly": _intervals(pairs["joint_low"], pairs["joint_high"], 2),
            "effect": [effect_size(value) for value in chance],
            "p": pairs["p"],
            "p (Holm)": pairs["p_holm"],
            "lower": pairs["lower"],
            "KS D": pairs["ks_distance"],
            "KS p": pairs["ks_p"],
            "note": ["complete separation" if apart else "" for apart in pairs["separated"]],
        }
    )
    shown.index = pd.Index(pairs["first"].astype(str) + " / " + pairs["second"].astype(str), name="pair")
    if not shown["note"].any():
        shown = shown.drop(columns="note")
    final = findings.final
    return Table(
        f"tests-{problem}",
        f"{problem}: {which}.",
        shown,
        bold=pd.DataFrame({"p (Holm)": pairs["significant"].to_numpy(dtype=bool)}, index=shown.index),
        decimals={"KS D": 3, "A12": 3},
        note="p: of the hypothesis A12 = 0.5; Holm’s adjustment is over the "
        f"{len(final.tested_pairs):,} pairs of all problems. "
        + (
            f"Bold: significant, at {final.levels.problems:g}; lower: then, the one that is separably lower. "
            if final.levels.problems
            else f"Their level is {final.level_on_problems:g}, which no p (Holm) reaches below {final.enough} trials a "
            "cell. "
        )
        + "Jointly: intervals of which all together hold. KS: the exact Kolmogorov-Smirnov test "
        "of one distribution, raw, which differences in spread reject, too.",
        data=(pairs if crowd else every).assign(level=final.level_on_problems),
        most_rows=SHOWN if crowd else MOST_ROWS,
    )


def _intervals(low: pd.Series[float], high: pd.Series[float], decimals: int | None) -> list[str]:
    return [interval(one, other, decimals) for one, other in zip(low, high, strict=True)]
