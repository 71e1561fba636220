"""The wall and processor time of a trial."""

from __future__ import annotations

from typing import Any

import pandas as pd

from bench import analysis
from bench.analysis.cells import CONTENTION, HIDDEN_THREADS
from bench.report.parts import Section, Table
from bench.report.wording import interval, listing, seconds, usual_decimals
from bench.topics.findings import Findings
from bench.topics.time.figures import timing_figure

TITLE = "Time"


def section(findings: Findings) -> Section:
    """Return the wall and processor time of a trial, the objective's share, and signs of a disturbed measurement."""
    timing = analysis.timing(findings.trials.whole)
    finished = timing[timing["trials"] > 0].sort_values("wall_mean", kind="stable")
    if len(finished) and finished["wall_mean"].isna().all():
        return Section(TITLE, ("The times of these trials are unknown, as of imported results.",))
    unknown = list(finished.loc[finished["wall_mean"].isna(), "optimizer"])
    finished, timing = (table[~table["optimizer"].isin(unknown)] for table in (finished, timing))
    if finished.empty:
        return Section(TITLE, ("No trial finished, so there are no times.",))
    warnings = [f"The times of {listing(unknown)} are unknown, as of imported results."] if unknown else []
    if len(waited := finished.loc[finished["contention"], "optimizer"]):
        warnings.append(
            f"Trials of {listing(list(waited))} waited for their core (wall time more than {CONTENTION:g} times CPU "
            "time): the machine was busy, so trust CPU times rather than wall times."
        )
    if len(threaded := finished.loc[finished["hidden_threads"], "optimizer"]):
        warnings.append(
            f"Trials of {listing(list(threaded))} used more than one core (CPU time more than {HIDDEN_THREADS:g} "
            "times wall time): wall times flatter these optimizers."
        )
    return Section(TITLE, (_summary(findings, finished),), (timing_figure(timing), _table(timing)), tuple(warnings))


def _summary(findings: Findings, finished: pd.DataFrame) -> str:
    fastest, slowest = finished.iloc[0], finished.iloc[-1]
    text = f"The mean wall time of a trial is {seconds(fastest['wall_mean'])} with {fastest['optimizer']}"
    if len(finished) > 1:
        text += f", the fastest optimizer, and {seconds(slowest['wall_mean'])} with {slowest['optimizer']}, the slowest"
    processors = list(
        dict.fromkeys(filter(None, (record.get("processor") for record in findings.results.environments)))
    )
    machine = "on the machine named below" if len(processors) < 2 else "on the machines named below"
    if processors:
        machine += f" ({listing(processors)})"
    spent = finished["evaluations_median"]
    unequal = (
        " The optimizers did not spend the same number of evaluations." if spent.max() > 1.01 * spent.min() else ""
    )
    return f"{text}, {machine}.{unequal}{_crowded(findings)}"


def _crowded(findings: Findings) -> str:
    """Return a sentence on whether more trials ran at a time than there were cores, "" where that was not recorded."""
    runs: dict[tuple[Any, ...], dict[Any, tuple[Any, Any]]] = {}  # jobs and cores of each machine of a run
    for record in findings.results.environments:
        run = tuple(record.get(key) for key in ("folder", "started", "command", "shard"))
        runs.setdefault(run, {})[record.get("host")] = record.get("jobs"), record.get("cores")
    noted = [list(machines.values()) for machines in runs.values()]
    if not noted or not all(isinstance(number, int) for run in noted for machine in run for number in machine):
        return ""
    if all(max(jobs for jobs, _ in run) <= sum(cores for _, cores in run) for run in noted):
        return " No more trials ran at a time than there were cores."
    return " More trials ran at a time than there were cores, so wall times are too long."


def _table(timing: pd.DataFrame) -> Table:
    shown = pd.DataFrame(
        {
            "trials": timing["trials"],
            "evaluations": timing["evaluations_median"],
            "evals/call": timing["per_call_median"],
            "wall s": timing["wall_median"],
            "wall IQR": _interval(timing, "wall"),
            "CPU s": timing["cpu_median"],
            "CPU IQR": _interval(timing, "cpu"),
            "objective": timing["objective_share"].map("{:.0%}".format, na_action="ignore"),
            "evals/s": timing["speed_median"],
            "wall/CPU": timing["wall_per_cpu"],
        }
    ).set_index(pd.Index(timing["optimizer"], name="optimizer"))
    batches = "; evaluations a call of the objective show how many of them could be made at the same time"
    if timing["per_call_median"].isna().all():  # of imported trials
        batches, shown, timing = "", shown.drop(columns="evals/call"), timing.drop(columns="per_call_median")
    return Table(
        "timing",
        "Median evaluations and times of one trial, the quartiles of the times (IQR), the share of the wall time spent "
        f"in the objective function, and evaluations a second{batches}.",
        shown,
        decimals={"evaluations": 0, "evals/call": 1, "wall/CPU": 2, "evals/s": 0},
        data=timing,
    )


def _interval(timing: pd.DataFrame, name: str) -> list[str]:
    quartiles = zip(timing[f"{name}_q1"], timing[f"{name}_q3"], strict=True)
    return [interval(q1, q3, 0 if q3 >= 1000 else usual_decimals([q3])) for q1, q3 in quartiles]
