"""The matrix of medians, problems by optimizers, and their regret."""

from __future__ import annotations

import pandas as pd

from bench.analysis import regret
from bench.analysis.cells import NEAR
from bench.analysis.compare import table
from bench.analysis.instances import SOLVED
from bench.report.parts import File, Section, Table
from bench.report.wording import count, leaders, listing, row_texts
from bench.topics.comparison import feasibility
from bench.topics.findings import CROWD, Findings, Trials
from bench.topics.ranks.tables import turned

TITLE = "Comparison"
OTHER = "lowest by"  # the column of those that are best by the median or the mean
OTHER_NOTE = (
    " Lowest by: the optimizer with the lowest median or mean of the row, where that is another one than the first."
)
NOTE = (
    "Bold: the first of the row, with the highest chance that a run of it ends lower than a run of a rival; "
    "none where half of the optimizers or more share the first place. Italics: the first one is not "
    "separably lower. {marks} –: no trial; ∞: the median trial failed; in red with ✗: a cell with failed trials. "
    "Values have four significant digits, or up to six to distinguish those of a row."
)
VALUES = ("mean", "median", "median_low", "median_high", "q1", "q3", "best", "worst")


def section(findings: Findings) -> Section:
    """Return the matrix of medians, its best values, those not distinguishable from them."""
    matrix = findings.final.matrix
    best, alike = table(matrix, "best").astype(bool), table(matrix, "alike").astype(bool)
    odd = findings.final.disagreements
    if not best.to_numpy().any():
        text = ["No problem has two optimizers with a finite value, so no best optimizer is marked."]
    else:
        unclear, subject = int(alike.any(axis=1).sum()), findings.final.subject
        test = (
            f"On {unclear} of these problems a first optimizer is not separably lower than another one."
            if unclear
            else "The first optimizers are separably lower than all others on each of these problems."
        )
        text = [
            f"{leaders(best, 'the first rank')}. {'' if subject else test}".rstrip(),
            *filter(None, (_odd(odd), _gaps(findings.trials))),
        ]
    items = _medians(findings)
    regrets = regret(findings.final.measured_summary, findings.trials.unbeaten, VALUES)
    if len(regrets):
        text.append(_at_optimum(findings.trials, table(regrets, "median")))
        above = regrets[~regrets["problem"].isin(findings.trials.precisions)]  # their values are regrets already
        items += [_regret(findings, above)] if len(above) else []
    feasible = feasibility.sections(findings)
    if findings.trials.many:
        by_problem = Section("Each problem", items=tuple(items), folded=True)
        return Section(TITLE, tuple(text), sections=(by_problem, *feasible))
    return Section(TITLE, tuple(text), tuple(items), sections=feasible)


def _medians(findings: Findings) -> list[Table]:
    """Return the matrix of medians: a table of objective values, and one of the precisions of pooled instances."""
    subject = findings.final.subject
    signs = f"+: {subject} is separably lower than this one; −: higher; =: neither; other pairs are not tested."
    notes = NOTE.format(marks=signs if subject else "")
    precise = findings.final.matrix["problem"].isin(findings.trials.precisions)
    caption = "over the trials of each cell (lower is better), and who has the highest chance to end lower."
    tables = []
    if not precise.all():
        values = findings.final.matrix[~precise]
        tables.append(_matrix(findings, "comparison", f"Median of the best objective value {caption}", values, notes))
    if precise.any():
        name = "comparison-precisions" if tables else "comparison"
        what = f"Median precision, the best objective value less the optimum of the instance, {caption}"
        made = listing([cells.words() for cells in findings.trials.replications if cells.instances > 1])
        marked = "Marked as the comparison of objective values." if tables else notes
        how = f" A cell holds the trials of all instances, {made}; a precision of at most {SOLVED:g} counts as 0."
        tables.append(_matrix(findings, name, what, findings.final.matrix[precise], marked + how))
    return tables


def _matrix(findings: Findings, name: str, caption: str, matrix: pd.DataFrame, note: str) -> Table:
    """Return the medians of some problems by optimizers, with the first of each row."""
    values, odd = table(matrix, "value"), findings.final.disagreements
    odd = odd[odd["problem"].isin(values.index)]
    other = _other_best(odd).reindex(values.index, fill_value="")
    shown = Table(
        name,
        caption,
        values.assign(**{OTHER: other}) if len(odd) else values,
        texts=_texts(values),
        bold=table(matrix, "best").astype(bool),
        italic=table(matrix, "alike").astype(bool),
        marks=table(matrix, "sign") if "sign" in matrix else None,
        lost=_lost(findings.trials, values),
        note=note + (OTHER_NOTE if len(odd) and not findings.display.upright else ""),
        data=matrix,
    )
    return turned(shown, findings)


def _texts(values: pd.DataFrame) -> pd.DataFrame:
    """Return the values as texts that distinguish those of a row, which are compared with each other."""
    rows = [row_texts(row) for row in values.to_numpy(dtype=float)]
    return pd.DataFrame(rows, values.index, values.columns, dtype=object)


def _lost(trials: Trials, shown: pd.DataFrame) -> pd.DataFrame:
    """Return flags of the cells with failed trials, problems by optimizers."""
    return (table(trials.coverage, "failed") > 0).reindex_like(shown)


def _at_optimum(trials: Trials, medians: pd.DataFrame) -> str:
    """Return on how many problems the median trial of each optimizer reached the known optimum."""
    reached = [f"on {number} with {label}" for label, number in medians.eq(0).sum().items() if number]
    outcome = f"The median trial reached it {listing(reached)}" if reached else "No optimizer’s median trial reached it"
    within = f" (on pooled instances, to {SOLVED:g})" if trials.precisions and reached else ""
    return f"The optimum is known on {count(len(medians), 'problem')}. {outcome}{within}."


def _regret(findings: Findings, regrets: pd.DataFrame) -> Table:
    medians = table(regrets, "median")
    data = regrets.drop(columns="sd").assign(optimum=regrets["problem"].map(findings.trials.unbeaten))
    shown = Table(
        "regret",
        "Median regret: the median of the best objective value minus the optimum of the problem.",
        medians,
        texts=_texts(medians),
        lost=_lost(findings.trials, medians),
        note=f"0: at the optimum within a relative {NEAR:g}; –: no trial; ∞: the median trial failed; in red with ✗: a "
        "cell with failed trials. Problems without a known optimum, or with a trial below it, are left out.",
        data=data,
    )
    return turned(shown, findings)


def _gaps(trials: Trials) -> str:
    """Return a caveat where the optimizers were not run on the same problems, else ""."""
    empty = trials.coverage[trials.coverage["stored"] == 0]
    gaps = empty.loc[empty["problem"].isin(trials.problems), "problem"].nunique()
    if not gaps:
        return ""
    return (
        f"On {count(gaps, 'problem')} at least one optimizer has no trial. The marks there compare the others only, "
        "and the summaries over evaluations and times below cover different problems for different optimizers."
    )


def _odd(odd: pd.DataFrame) -> str:
    """Return on which problems median, mean and rank name different optimizers; "" where they agree."""
    if odd.empty:
        return ""
    return (
        f"On {count(len(odd), 'problem')} ({listing(list(map(str, odd['problem'])), at_most=5)}) the median or "
        "the mean names another best optimizer than the ranks: the trials there end in several basins, so look at "
        "the distributions."
    )


def _other_best(odd: pd.DataFrame) -> pd.Series[str]:
    """Return by problem the optimizers that are best by median or mean without being ranked first."""
    texts = {
        row["problem"]: "; ".join(
            f"{name} {listing([*map(str, row[name])], at_most=3)}"
            for name in ("median", "mean")
            if row[name] and not {*row[name]} & {*row["standing"]}
        )
        for row in odd.to_dict("records")
    }
    return pd.Series(texts, dtype=object)


def tables(findings: Findings) -> list[File]:
    """Return all trials, cells and tests of the study."""
    precisions = ", precisions where instances are pooled" if findings.trials.precisions else ""
    return [
        File("tables/trials.csv", "All trials, one row a trial.", findings.results.frame),
        File(
            "tables/cells.csv",
            f"All cells: trials, failures and statistics of the objective value{precisions}.",
            findings.final.summary,
        ),
        File(
            "tables/tests.csv",
            f"The tests of {findings.final.pairs_words}, at most of the {CROWD} best, on every problem, with their "
            "level.",
            findings.display.written_pairs.assign(level=findings.final.level_on_problems),
        ),
    ]
