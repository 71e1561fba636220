"""Report the gain of tuning: parameters, training problems, cost, and results on the problems of the study."""

from __future__ import annotations

import re
from typing import Any

import pandas as pd

from bench.helpers.text import option
from bench.optimizer import CONDITIONS
from bench.plots import style
from bench.plots.tuning import sensitivity
from bench.report.parts import Figure, Part, Section, Table
from bench.report.wording import MISSING, cell_text, count, listing, p_text, seconds
from bench.study.tuned import AUTOMATIC, Tuned, Tuning
from bench.topics.findings import Final, Findings, Trials
from bench.topics.topic import Topic

TITLE = "What tuning gained"
PANELS = 12  # of the figure
OBJECTIVES = {
    "aocc": "one less the area over the convergence curve",
    "regret": "the logarithm of the median regret",
}
INSTANCE = re.compile(r"-i[0-9]+$")


def section(findings: Findings) -> Section | None:
    """Return the section on the gain of tuning; None where the optimizers were not tuned by this harness."""
    tuning = findings.study.tuning
    tuned = [record for record in tuning.optimizers if record.default in findings.trials.optimizers] if tuning else []
    if tuning is None or not tuned:
        return None
    gains = {
        record.name: _gain(findings.final, record) for record in tuned if record.tuned in findings.trials.optimizers
    }
    text = [
        _what(findings, tuning, tuned),
        _cost(tuned),
        *(_gained(findings.trials, record, gains.get(record.name)) for record in tuned),
    ]
    items: list[Part] = [_results(tuned, gains), _parameters(tuned)]
    if panels := _panels(tuned):
        items.append(_figure(panels))
    return Section(TITLE, tuple(text), tuple(items), tuple(_warnings(findings, tuning, tuned)))


def _what(findings: Findings, tuning: Tuning, tuned: list[Tuned]) -> str:
    apart = f", all but the group {tuning.left_out!r}" if tuning.left_out else ""
    score = OBJECTIVES.get(tuning.objective, tuning.objective)
    tested = tuning.is_apart(entry.name for entry in findings.results.study.problems)
    return (
        f"{listing([one.name for one in tuned])} {'was' if len(tuned) == 1 else 'were'} tuned by {tuning.method}: "
        f"{count(tuning.trials, 'configuration')}{' each' if len(tuned) > 1 else ''}, the defaults first, with "
        f"{count(tuning.runs, 'run')} of {tuning.budget.words} on each of "
        f"{count(len(tuning.train), 'training problem')}{apart}. The score is {score}, the mean over the training "
        f"problems; lower is better.{' No problem of this report was tuned on.' if tested else ''}"
    )


def _cost(tuned: list[Tuned]) -> str:
    spent, time = sum(record.evaluations for record in tuned), sum(record.seconds for record in tuned)
    stopped = sum(record.whole.count(False) for record in tuned)
    tried = sum(len(record.scores) for record in tuned)
    failed = sum(record.failed for record in tuned)
    lost = f" {count(failed, 'run')} failed and scored worst." if failed else ""
    return (
        f"The tuning cost {count(spent, 'evaluation')} and {seconds(time)} of runs; {stopped:,} of "
        f"{count(tried, 'configuration')} were stopped early.{lost}"
    )


def _gain(final: Final, entry: Tuned) -> dict[str, Any]:
    """Return how the tuned parameters compare with the defaults, over the problems on which both have trials."""
    pairs = final.pairs.dropna(subset="a12")  # it is missing where a cell has no trial
    tests = _between(pairs, entry)
    chance = tests["a12"].where(tests["first"].astype(object) == entry.tuned, 1 - tests["a12"])
    clear = tests[tests["lower"] != ""]
    across = _between(final.overall, entry)
    return {
        "problems": len(tests), "chance": float(chance.mean()) if len(tests) else float("nan"),
        "lower": int((clear["lower"] == entry.tuned).sum()), "higher": int((clear["lower"] == entry.default).sum()),
        "testable": bool(tests["testable"].any()), "across": next(iter(across.to_dict("records")), None),
    }  # fmt: skip


def _between(tests: pd.DataFrame, entry: Tuned) -> pd.DataFrame:
    """Return the tests of the tuned parameters against the defaults."""
    both = [entry.default, entry.tuned]
    return tests[tests["first"].isin(both) & tests["second"].isin(both)]


def _gained(trials: Trials, entry: Tuned, gain: dict[str, Any] | None) -> str:
    """Return a sentence on the gain of one optimizer's tuning, as far as trials and problems allow a statement."""
    if entry.tuned == entry.default:
        return f"{entry.name}: no configuration scored better than the defaults, so nothing was gained."
    if gain is None or not gain["problems"]:
        return f"{entry.name}: no problem has trials of both the defaults and the tuned parameters."
    problems = count(gain["problems"], "problem")
    mean = "" if gain["problems"] == 1 else f", in the mean over {problems}"
    sentence = (
        f"{entry.name}: the chance that a trial with the tuned parameters ends lower than one with the defaults is "
        f"{gain['chance']:.2f}{mean} (0.5: no gain). "
    )
    sentence += (
        f"The tuned parameters are separably lower on {gain['lower']:,} and separably higher on {gain['higher']:,} of "
        f"{problems}."
        if gain["testable"]
        else f"{trials.per_cell[1]:,} trials are too few to show a difference on a problem."
    )
    across = gain["across"]
    if gain["problems"] == 1 or across is None:
        return f"{sentence} One problem says nothing of others."
    shown = across["significant"]
    better = "the tuned parameters are lower" if across["lower"] == entry.tuned else "the defaults are lower"
    verdict = better if shown else "no difference is shown"
    return f"{sentence} Over these problems, {verdict} ({p_text(across['p_holm'])}, adjusted)."


def _warnings(findings: Findings, tuning: Tuning, tuned: list[Tuned]) -> list[str]:
    warnings = [tuning.doubt] if tuning.doubt else []
    if conditions := [name for name in CONDITIONS if any(name in record.parameters for record in tuned)]:
        warnings.append(
            f"{listing(conditions).capitalize()} {'was' if len(conditions) == 1 else 'were'} tuned: tuned parameters "
            "meet the other optimizers under conditions of their own."
        )
    named = {label for record in tuned for label in (record.default, record.tuned)}
    others = [label for label in findings.trials.optimizers if label not in named]
    if others:
        plural = len(others) > 1
        warnings.append(
            f"{listing(others)} {'were' if plural else 'was'} not tuned. A tuned optimizer that ends lower than "
            f"{'these' if plural else 'this one'} may owe it to the tuning; compare defaults with defaults."
        )
    study = findings.results.study
    if study.budget != tuning.budget:
        warnings.append(
            f"The trials here had {study.budget_words}, the tuning {tuning.budget.words}; the best "
            "parameters depend on the budget."
        )
    names = {entry.name for entry in study.problems}
    if both := names & set(tuning.train):  # of another folder in the same report
        warnings.append(f"{count(len(both), 'problem')} of this report, such as {min(both)}, were trained on.")
    tested = {INSTANCE.sub("", name) for name in names - set(tuning.train)}
    if shared := tested & {INSTANCE.sub("", name) for name in tuning.train}:
        warnings.append(
            f"Training and test problems are different instances of {count(len(shared), 'common function')}: a gain "
            "there holds for other instances, and not for other functions."
        )
    return warnings


def _results(tuned: list[Tuned], gains: dict[str, dict[str, Any]]) -> Table:
    rows = []
    for record in tuned:
        gain = gains.get(record.name, {})
        rows.append(
            {
                "optimizer": record.name, "tried": len(record.scores), "stopped early": record.whole.count(False),
                "failed runs": record.failed, "evaluations": record.evaluations, "seconds": record.seconds,
                "score of the defaults": record.scores[0], "best score": record.best,
                "chance to end lower": gain.get("chance", float("nan")),
                "lower on": gain.get("lower", MISSING), "higher on": gain.get("higher", MISSING),
            }
        )  # fmt: skip
    return Table(
        "tuning",
        "What the tuning cost, what it gained on the training problems, and what on the problems of this report.",
        pd.DataFrame(rows),
        decimals={"chance to end lower": 2, "seconds": 1},
        note="Scores are of training problems, where the best of many is too good by chance; the last three "
        f"columns are of the problems of this report. Chance: {MISSING} where the defaults were best.",
    )


def _parameters(tuned: list[Tuned]) -> Table:
    rows = []
    for record in tuned:
        best = record.scores.index(record.best) if record.tuned != record.default else 0
        for name, tried in record.parameters.items():
            choices = tried.get("choices")
            span = " | ".join(map(_value, choices)) if choices else f"{tried['low']:g} to {tried['high']:g}"
            rows.append(
                {
                    "optimizer": record.name, "parameter": name, "tried": span + (" (log)" if tried.get("log") else ""),
                    "default": _value(record.values[name][0]), "tuned": _value(record.values[name][best]),
                    "importance": record.importance.get(name, float("nan")),
                }
            )  # fmt: skip
    return Table(
        "tuned-parameters",
        "The parameters that were tuned: what was tried, the default, and the value of the best configuration.",
        pd.DataFrame(rows),
        decimals={"importance": 2},
        note="Importance: the share of a parameter in what separates the better configurations from the others "
        f"(PED-ANOVA), from ten whole configurations on; {MISSING}: not known.",
    )


def _value(value: Any) -> str:
    return "automatic" if value == AUTOMATIC else cell_text(value) if isinstance(value, float) else option(value)


def _panels(tuned: list[Tuned]) -> list[tuple[Tuned, str, pd.DataFrame]]:
    """Return optimizer, parameter and the whole configurations of each panel, the important parameters first."""
    panels = []
    for record in tuned:
        table = pd.DataFrame({"score": record.scores, "kind": ""})
        table.loc[record.scores.index(record.best), "kind"] = "best"
        table.loc[0, "kind"] = "default"
        for name in sorted(record.parameters, key=lambda name: -record.importance.get(name, 0.0)):
            configurations = table.assign(value=pd.Series(record.values[name], dtype=object))[record.whole]
            if len(configurations) > 2:
                panels.append((record, name, configurations))
    return panels


def _figure(panels: list[tuple[Tuned, str, pd.DataFrame]]) -> Figure:
    shown = panels[:PANELS]
    width = min(0.7 + 2.4 * len(shown), style.page_width())
    figure, axes = style.grid(
        len(shown), width=width, height=1.4, left=0.6, across=0.45, down=0.55, top=0.25, bottom=0.35
    )
    for number, (ax, (entry, name, table)) in enumerate(zip(axes, shown, strict=True)):
        tried = entry.parameters[name]
        sensitivity(table, tried.get("choices", ()), bool(tried.get("log")), ax=ax)
        style.title(ax, f"{entry.name}: {name}")
        if number % 3 == 0:
            ax.set_ylabel("score")
    more = f" The first {PANELS} of {len(panels)} parameters." if len(panels) > PANELS else ""
    caption = (
        "The score of each configuration that ran on all training problems, over the values of each parameter; lower "
        f"is better. Square: the defaults, where they have a value; diamond: the best.{more}"
    )
    parts = [table.assign(optimizer=entry.name, parameter=name) for entry, name, table in panels]
    data = pd.concat(parts, ignore_index=True)[["optimizer", "parameter", "value", "score", "kind"]]
    return Figure("tuning-sensitivity", caption, figure, data)


TOPIC = Topic(TITLE, section, place=600)
