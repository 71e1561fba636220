"""The gate of an optimizer's author: whether a new version is worse than the stored results of an old one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from os import PathLike

import pandas as pd

from bench.analysis.cells import labels
from bench.analysis.direction import ALPHA
from bench.analysis.dominance import ordered_trials
from bench.analysis.noninferiority import MARGIN, Noninferiority, noninferiority
from bench.helpers.errors import BenchError, nearest
from bench.helpers.markdown import table
from bench.helpers.text import short_hash
from bench.report.wording import count, listing, p_text
from bench.results.results import StoredResults
from bench.storage.folder import Folder
from bench.study import Study
from bench.topics.answer.changes import extended
from bench.topics.findings import Findings, Trials

AnyPath = str | PathLike[str]

SHOWN = 12  # problems of a table, the worst first
NAMED = 4  # problems of a sentence
HEADS = ("problem", "trials", "old better", "95% interval", "p (Holm)", "")


@dataclass(frozen=True)
class Gate:
    """The comparison of a new version with an old one, and the words for it.

    Attributes:
        found: the test; its outcome is "not worse" also where every trial is identical.
        title: which versions were compared, and the outcome.
        sentence: the verdict.
        notes: sentences on the conditions and on what the reader must know.
        rows: cells of a table with the heads :data:`HEADS`, at most :data:`SHOWN`, the worst problems first.
    """

    found: Noninferiority
    title: str
    sentence: str
    notes: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def markdown(self) -> str:
        """Return the verdict as Markdown, for a pull request."""
        sign = {"worse": "❌", "undecided": "⚠️"}.get(self.found.outcome, "✅")
        notes = [f"- {note}" for note in self.notes]
        return "\n".join([f"## {sign} {self.title}", "", self.sentence, "", table(HEADS, self.rows), "", *notes, ""])


def gate(
    old: AnyPath,
    new: AnyPath | None = None,
    *,
    margin: float = MARGIN,
    alpha: float = ALPHA,
    optimizer: str | None = None,
    target: float | None = None,
    common: bool = False,
    every: bool = False,
) -> Gate:
    """Compare one optimizer of the folder ``new`` with one of the folder ``old``.

    The folder of the new version notes the comparison and its outcome, for the sake of later ones.

    Args:
        old: the folder of the old version.
        new: the folder of the new version; None where ``old`` holds both: then the version that its study selects is
            compared with the one before, or with version 2 where ``optimizer`` is such as ``"mine@2"``.
        margin: by which the chance that a trial of the old version ends lower may exceed 0.5.
        alpha: the chance of a false alarm, at most.
        optimizer: the label of the optimizer in both folders; not needed where each holds one only.
        target: a precision: trials that reach it are compared by the evaluations that they took.
        common: whether to leave out problems that one folder lacks; they are refused otherwise.
        every: whether a pass needs every problem to be shown to be not worse, and not their average alone.

    Raises:
        BenchError: where a folder holds no such optimizer, the folders differ in problems, budget or data, or there is
            too little to compare.
    """
    findings, chosen = _of_one(old, optimizer) if new is None else _of_two(old, new, optimizer)
    frame = findings.trials.frame[findings.trials.frame["optimizer"].isin(chosen)]
    missing = _missing(frame, chosen)
    if len(missing) == len(labels(frame, "problem")):
        raise BenchError(f"{' and '.join(chosen)} have no problem in common on which both have trials")
    if missing and not common:
        where = listing([f"{problem} of {chosen[place]}" for problem, place in missing.items()], at_most=4)
        raise BenchError(f"there are no trials on {where}; run them, or compare the other problems with --common")
    frame = frame[~frame["problem"].isin(list(missing))]
    compared = _of_first_trials(frame)
    if target is not None:
        frame = _by_speed(findings.trials, frame, target)
    test = noninferiority(frame, *chosen, margin=margin, alpha=alpha, every=every)
    left_out = [instance for label in missing for instance in findings.trials.pooled.members[label]]
    same = _identical(findings.results.frame, chosen, left_out)
    made = _worded(test, findings, frame, chosen, missing, same, target)
    return replace(made, notes=(*made.notes, *_looked(Folder(new or old), made.found, compared, len(frame))))


def _of_two(old: AnyPath, new: AnyPath, optimizer: str | None) -> tuple[Findings, tuple[str, str]]:
    """Return the findings in two folders, and the labels of the old and the new version."""
    studies = [Folder(path).study() for path in (old, new)]
    places = [_place(study, optimizer, path) for study, path in zip(studies, (old, new), strict=True)]
    findings = Findings(StoredResults(old, new))
    entries = findings.results.study.optimizers  # those of the old folder first
    return findings, (entries[places[0]].label, entries[len(studies[0].optimizers) + places[1]].label)


def _of_one(path: AnyPath, optimizer: str | None) -> tuple[Findings, tuple[str, str]]:
    """Return likewise what was found of two versions of one optimizer in one folder."""
    study = Folder(path).study()
    label, _, number = (optimizer or "").rpartition("@")
    if not number.isdigit() or any(entry.label == optimizer for entry in study.optimizers):
        label, number = study.optimizers[_place(study, optimizer, path)].label, ""
    results = StoredResults(path, versions=[label])
    shown = {
        entry.label.rpartition("@")[2]: entry.label
        for entry in results.study.optimizers
        if entry.label.rpartition("@")[0] == label
    }
    new = next(name for name in shown.values() if results.planned[name])  # only the selected one follows a plan
    earlier = [name for name in shown.values() if name != new]
    if number and shown.get(number) not in earlier:
        what = "is the one that is selected" if shown.get(number) == new else "is not here"
        raise BenchError(f"version {number} of {label!r} {what}: {path} has {listing(earlier)} to compare it with")
    return Findings(results), (shown[number] if number else earlier[-1], new)


def _place(study: Study, optimizer: str | None, path: AnyPath) -> int:
    """Return the place of the optimizer in the study."""
    held = [entry.label for entry in study.optimizers]
    if optimizer is None and len(held) > 1:
        raise BenchError(f"{path} holds {len(held)} optimizers ({listing(held)}); choose one with --optimizer")
    if optimizer is not None and optimizer not in held:
        raise BenchError(f"{path} holds no optimizer {optimizer!r}{nearest(optimizer, held)}")
    return held.index(optimizer) if optimizer is not None else 0


def _missing(frame: pd.DataFrame, chosen: tuple[str, str]) -> dict[str, int]:
    """Return the problems on which one of two optimizers has no trial, and which one it is."""
    first, second = (set(frame.loc[frame["optimizer"] == label, "problem"]) for label in chosen)
    return {
        problem: 0 if problem not in first else 1
        for problem in labels(frame, "problem")
        if problem not in first & second
    }


def _by_speed(trials: Trials, frame: pd.DataFrame, target: float) -> pd.DataFrame:
    """Return the trials with their rank by trial-based dominance in place of their value."""
    if not target > 0:
        raise BenchError(f"the target is {target!r}, but must be a positive precision, such as 1e-8")
    problems = [label for label in trials.problems if (frame["problem"] == label).any()]
    unknown = [label for label in problems if label not in trials.unbeaten]
    if unknown:
        raise BenchError(
            f"no target can be set on {listing(unknown, at_most=3)}, whose optimum is unknown or beaten; leave out "
            "--target"
        )
    measured = trials.measured_final.loc[frame.index]
    return ordered_trials(
        measured,
        trials.measured_traces,
        {label: trials.unbeaten[label] for label in problems},
        target,
    )


def _identical(frame: pd.DataFrame, chosen: tuple[str, str], missing: list[str]) -> tuple[int, int]:
    """Return how many trials of both versions are identical in value and evaluations, and the trials in all."""
    rows = frame[~frame["problem"].isin(missing)]
    names = ["problem", "trial", "seed", "status", "fun", "nfev"]
    first, second = (rows.loc[rows["optimizer"] == label, names] for label in chosen)
    same = len(first.merge(second, on=names))  # failed trials have no value, and equal each other
    return same, max(len(first), len(second))


def _worded(
    test: Noninferiority,
    findings: Findings,
    frame: pd.DataFrame,
    chosen: tuple[str, str],
    missing: Mapping[str, int],
    same: tuple[int, int],
    target: float | None,
) -> Gate:
    """Return the gate with its sentences and table."""
    problems, (alike, trials) = test.problems, same
    identical = alike == trials
    if identical:
        test = replace(test, outcome="not worse")
    low, high = problems[["n_old", "n_new"]].to_numpy().min(), problems[["n_old", "n_new"]].to_numpy().max()
    measure = "final values" if target is None else f"evaluations to the precision {target:g}, else final values"
    sizes = f"{count(int(low), 'trial') if low == high else f'{low:,} to {high:,} trials'} of each on each"
    conditions = f"{count(len(problems), 'problem')}, {sizes}, {findings.study.budget_words}, by {measure}"
    meaning = "Old better: the chance that a trial of the old version ends better, ties counted half (A12)"
    allowed = f"the margin allows {test.bound:.1%}. A false alarm has a chance of at most {test.alpha:g}"
    notes = [f"{chosen[1]} against {chosen[0]}: {conditions}.", f"{meaning}; {allowed}, over all problems."]
    adjusted = ", by Holm’s method over the problems," if len(problems) > 1 else ""
    notes.append(f"A problem is worse where its one-sided p{adjusted} is at most {test.alpha / 2:g}.")
    if test.every:
        notes.append(
            f"A pass needs every problem, each tested at {test.alpha / 2:g} without adjustment: the chance of a pass "
            "where the new version is worse on any is no more than that (intersection-union test)."
        )
    if test.outcome == "undecided":
        most = f"{test.needed:,}" if test.needed < 100_000 else "more than 100,000"
        notes.append(
            f"If the versions are equal, about {most} trials a problem would pass with a chance of 80%; plan them with "
            "a new seed, as another look at more trials of this one errs more often."
        )
    notes += [
        f"{name} was extended from {grown[0]:,} to {grown[1]:,} trials: after an undecided look, a false alarm has a "
        f"chance above {test.alpha:g}. Plan all trials at once, with a new seed."
        for name, history in zip(findings.results.names, findings.results.histories, strict=True)
        if (grown := extended(history))
    ]
    if 0 < alike < trials:
        notes.append(f"{alike:,} of {count(trials, 'trial')} are identical, as their seeds are.")
    if missing:
        notes.append(f"Left out, as one version has no trial: {listing(list(missing))}.")
    for label in chosen:
        trials_of = frame[frame["optimizer"] == label]
        if lost := int((trials_of["status"] != "ok").sum()):
            notes.append(f"{lost:,} of {count(len(trials_of), 'trial')} of {label} failed, and count as the worst.")
    ordered = problems.sort_values(["worse", "low", "a12"], ascending=False, kind="stable")
    shown = _shown(test.worse_overall, test.high <= test.bound or identical)
    rows = [("all problems", "", *_measured(test.a12, test.low, test.high), "", shown)]
    rows += [
        (
            row["problem"], " / ".join(dict.fromkeys(f"{row[size]:,}" for size in ("n_old", "n_new"))),
            *_measured(row["a12"], row["low"], row["high"]), p_text(row["p_holm"])[2:].removeprefix("= "),
            _shown(row["worse"], row["not_worse"] or identical),
        )
        for row in ordered.iloc[:SHOWN].to_dict("records")
    ]  # fmt: skip
    if len(ordered) > SHOWN:
        notes.append(f"The table shows {SHOWN} of {len(ordered):,} problems, those with the largest lower ends first.")
    title = f"{chosen[1]} against {chosen[0]}: {test.outcome}"
    return Gate(test, title, _sentence(test, identical), tuple(notes), tuple(rows))


def _of_first_trials(frame: pd.DataFrame) -> list[str]:
    """Return a hash a problem of the first trials of both versions, which stay the same when trials are added."""
    first = frame[frame["trial"] == frame.groupby(["problem", "optimizer"], observed=True)["trial"].transform("min")]
    return [
        short_hash(rows[["seed", "fun"]].to_json(orient="values"))
        for _, rows in first.groupby("problem", observed=True)
    ]


def _looked(folder: Folder, test: Noninferiority, compared: list[str], trials: int) -> Iterator[str]:
    """Note this look at a comparison; yield a sentence on an earlier one at fewer of its trials that was undecided."""
    looks = [each for each in folder.looks() if set(compared) & {*each["compared"]} and each["trials"] < trials]
    undecided = [each["trials"] for each in looks if each["outcome"] == "undecided"]
    if undecided:
        yield (
            f"An earlier look at this comparison, at {max(undecided):,} of these {trials:,} trials, was undecided: the "
            f"level of {test.alpha:g} does not hold any more. Plan {test.needed:,} trials a problem with a new seed, "
            "which restores it."
        )
    try:
        folder.note_look({"compared": compared, "trials": trials, "outcome": test.outcome})
    except BenchError as error:
        yield f"This look is not noted for later ones: {error}"


def _sentence(test: Noninferiority, identical: bool) -> str:
    """Return the verdict in one sentence."""
    if identical:
        return "The new version is not worse: every trial is identical with that of the old version."
    worse = [str(label) for label in test.problems.loc[test.problems["worse"], "problem"]]
    several, allowed = len(test.problems) > 1, f"and {test.bound:.1%} are allowed"
    seen = f"the old version ends better in {test.a12:.1%} of the pairs of trials ({test.low:.1%} to {test.high:.1%})"
    average = " on average" * several
    if test.passed and test.every and several:
        most, better = test.problems["high"].max(), f" It is better{average}: {seen}." * (test.outcome == "better")
        return (
            "The new version is not worse by more than the margin on any problem: the old version ends better in at "
            f"most {most:.1%} of the pairs of trials on each, {allowed}.{better}"
        )
    if test.outcome == "better":
        return f"The new version is better{average}: {seen}.{_not_shown(test)}"
    if test.passed:
        return f"The new version is not worse{average} by more than the margin: {seen}, {allowed}.{_not_shown(test)}"
    if test.outcome == "undecided":
        missing = _not_shown(test) if test.every else ""
        return f"Undecided: {seen}, {allowed}, which shows {'too little' if missing else 'neither'}.{missing}"
    where = f" on {listing(worse, at_most=NAMED)}" if worse else ""
    if test.worse_overall:
        also = f", and so it is{where} alone" if worse else ""
        return f"The new version is worse by more than the margin over all problems: {seen}{also}."
    return f"The new version is worse by more than the margin{where}, though not shown so over all problems: {seen}."


def _not_shown(test: Noninferiority) -> str:
    """Return a sentence on the problems on which the new version may still be worse, the worst first; "" for none."""
    missing = test.problems[~test.problems["not_worse"]].sort_values(["high", "a12"], ascending=False, kind="stable")
    named = [f"{row['problem']} (up to {row['high']:.1%})" for row in missing.to_dict("records")]
    if not named:
        return ""
    if len(named) > NAMED:
        where = f"{len(named):,} of {len(test.problems):,} problems, the worst of them {named[0]}"
    else:
        where = listing(named)
    return f" It is not shown to be not worse on {where}."


def _measured(a12: float, low: float, high: float) -> tuple[str, str]:
    return f"{a12:.1%}", f"{low:.1%} to {high:.1%}"


def _shown(worse: bool, not_worse: bool) -> str:
    return "worse" if worse else "not worse" if not_worse else "not shown"
