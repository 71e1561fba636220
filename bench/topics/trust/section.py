"""What may limit the answer: conditions, checks, changes after the results, few trials, and other measures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import pandas as pd

from bench.analysis.comparison import shared_by
from bench.contract.objective import ON_TARGET, OUT_OF_TIME
from bench.helpers.parsing import Json, JsonObject
from bench.report.parts import Card, File, Line, Section, Table, Typography, warning
from bench.report.wording import count, listing, unfinished_trials
from bench.topics.answer.changes import changes
from bench.topics.answer.facts import facts
from bench.topics.answer.section import nothing_to_compare
from bench.topics.findings import Findings, Trials
from bench.topics.methods.environment import Environments
from bench.topics.trust import words
from bench.topics.trust.checks import checks
from bench.topics.trust.design import smallest
from bench.topics.trust.left_out import left_out

TITLE = "Can you trust it?"
TROUBLE = ("error", "warning")


def section(findings: Findings) -> Section | None:
    """Return one card with what limits the answer, and tables of failed and missing trials; None without a trial."""
    if findings.trials.whole.empty:
        return None
    made = findings.of(checks)
    verdicts = made["verdict"]
    troubles = made[verdicts.isin(TROUBLE)]
    passed = made.loc[verdicts == "pass", "check"]
    headline = words.checked(len(passed), len(troubles), int((verdicts == "not checked").sum()))
    compared = not nothing_to_compare(findings)
    skipped = (*findings.results.differences, *left_out(findings.trials.comparable))
    lines = [
        *(_conditions(findings) if compared else ()),
        *(warning("not compared", text) for text in skipped),
        *(warning(str(row.check), first_sentences(str(row.finding))) for row in troubles.itertuples()),
        *_data(findings),
        *([Line("passed", words.passed(list(passed)))] if len(passed) else []),
        *(_claims(findings) if compared else ()),
    ]
    card = Card(headline, "open" if len(troubles) else "limit")
    table = File("tables/integrity.csv", "The checks of the results, and what each found.", made)
    lost = unfinished_trials(findings.trials.comparable.working)
    return Section(
        TITLE, items=tuple(_incomplete(findings.trials)), cards=(card,), lines=tuple(lines), lost=lost, files=(table,)
    )


def first_sentences(finding: str) -> str:
    """Return the first sentence of each line of a finding; the file has all of it."""
    return " ".join(f"{line.partition('. ')[0].rstrip('.')}." for line in finding.splitlines())


def _conditions(findings: Findings) -> Iterator[Line]:
    """Yield what differs between the optimizers besides their algorithms."""
    unlike = findings.of(facts).unlike
    if unlike.clause:
        yield warning("unlike conditions", words.alike(unlike.clause, unlike.names))
    if unlike.left:
        yield warning("unlike conditions", words.unused(unlike.left))
    if findings.trials.common:
        yield warning("budgets differ", words.budgets(findings.trials.common_words))


def _claims(findings: Findings) -> Iterator[Line]:
    """Yield what limits the claims: changes after the results, seeds, trials, problems and other measures."""
    found, known = findings.of(changes), findings.of(facts)
    if found.made or found.known:
        text = words.changed(found.made, findings.study.seed + 1) if found.made else words.unchanged()
        yield warning("changed after the results", text)
    else:
        yield warning("history not known", words.not_known())
    if same := shared_by(findings.trials.frame):
        yield warning("shared seeds", words.shared(same))
    if findings.trials.frame["seed"].isna().any():
        yield warning("no seeds", words.without_seeds())
    yield warning("enough runs", smallest(findings.results.study))  # whose instances are not pooled yet
    yield warning("which problems", words.scope(len(known.problems)))
    yield warning("other measures", words.measures(_measures(findings), len(known.problems)))


def _measures(findings: Findings) -> dict[str, int]:
    """Return on how many problems the lowest median, or mean, is not that of a first optimizer."""
    keys, problems = ["problem", "optimizer"], list(findings.of(facts).problems)
    plain = dict.fromkeys(keys, object)
    wide = findings.final.chances.astype(plain).pivot(index=keys[0], columns=keys[1], values="chance")
    first = wide.loc[problems].pipe(lambda chances: chances.eq(chances.max(axis=1), axis=0))
    summary, found = findings.final.summary.astype(plain), {}
    for name in ("median", "mean"):
        values = summary.pivot(index=keys[0], columns=keys[1], values=name).loc[problems, first.columns]
        agree = (values.eq(values.min(axis=1), axis=0) & first).any(axis=1)
        found[name] = int((~agree).sum())
    return found


def _data(findings: Findings) -> Iterator[Line]:
    """Yield what limits the data: runs that are missing, infeasible or ended early, problems, machines and times."""
    trials = findings.trials
    empty = trials.coverage[trials.coverage["stored"] == 0]
    if gaps := empty.loc[empty["problem"].isin(trials.problems), "problem"].nunique():
        yield warning("gaps", words.gaps(gaps))
    cells = trials.feasible
    if len(cells) and (lost := int((cells["trials"] - cells["feasible"]).sum())):
        runs, constraints = int(cells["trials"].sum()), findings.study.rules.constraints
        yield warning("no feasible point", words.infeasible(lost, runs, constraints))
    yield from handled(trials.whole)
    reasons = {label: known.reason for label, known in trials.known.items() if known.reason}
    if reasons:
        why = next(iter(reasons.values())).partition(";")[0]
        yield warning("problem cannot be loaded", words.not_loaded(list(reasons), why))
    yield from Environments(findings.results).warnings()
    if crowded(findings.results.environments):
        yield warning("crowded", words.crowded())


def crowded(records: Sequence[JsonObject]) -> bool:
    """Return whether more trials ran at a time than there were cores; False where that was not recorded."""
    runs: dict[tuple[Json, ...], dict[Json, tuple[Json, Json]]] = {}  # jobs and cores of each machine of a run
    for record in records:
        run = tuple(record.get(key) for key in ("folder", "started", "command", "shard"))
        runs.setdefault(run, {})[record.get("host")] = record.get("jobs"), record.get("cores")
    noted = [list(machines.values()) for machines in runs.values()]
    if not all(isinstance(number, int) for run in noted for machine in run for number in machine):
        return False
    return any(max(jobs for jobs, _ in run) > sum(cores for _, cores in run) for run in noted)


def handled(frame: pd.DataFrame) -> Iterator[Line]:
    """Yield lines on evaluations that failed, and on trials that a limit or a good value ended."""
    sums = frame[["failures", "nfev"]].astype(float).groupby(frame["problem"].astype(object), sort=False).sum()
    shares = (sums["failures"] / sums["nfev"])[sums["failures"] > 0]
    if len(shares):
        named = listing([f"{share:.2g} of those on {problem}" for problem, share in shares.items()], at_most=8)
        text = f"Evaluations failed, and count with the value +inf: a share of {named}."
        yield warning("failed evaluations", text)
    if late := int((frame["stop"] == OUT_OF_TIME).sum()):
        text = (
            f"A limit of time has ended {late:,} of {count(len(frame), 'trial')} before the budget: their results "
            "depend on the machine and cannot be repeated bit by bit."
        )
        yield warning("ended by time", text)
    if good := int((frame["stop"] == ON_TARGET).sum()):
        text = f"{good:,} of {count(len(frame), 'trial')} ended before the budget, as their value was good enough."
        yield warning("ended by a good value", text)


def _incomplete(trials: Trials) -> list[Table]:
    coverage, frame = trials.coverage, trials.whole
    short = coverage[(coverage["missing"] > 0) | (coverage["failed"] > 0)]
    lost = Typography(lost=short[["failed"]] > 0)
    tables = [Table("incomplete-cells", "Cells with missing or failed trials.", short, lost)] if len(short) else []
    failed = frame[frame["status"] != "ok"]
    return [*tables, _failures(failed)] if len(failed) else tables


def _failures(failed: pd.DataFrame) -> Table:
    first_line = failed["error"].astype(object).where(failed["error"].notna(), "").str.split("\n").str[0]
    errors = failed.assign(optimizer=failed["optimizer"].astype(str), error=first_line)
    reasons = (
        errors.groupby(["optimizer", "status", "error"], sort=False)
        .agg(trials=("trial", "size"), problems=("problem", "nunique"))
        .reset_index()[["optimizer", "status", "trials", "problems", "error"]]
    )
    lost = Typography(lost=reasons[["trials"]] > 0)
    return Table("failures", "Failed trials by optimizer and reason.", reasons, lost)
