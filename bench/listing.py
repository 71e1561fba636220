"""What the commands list, status and solve print."""

from __future__ import annotations

import dataclasses
import inspect
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from bench import plugins
from bench.errors import BenchError, nearest
from bench.optimizer import Optimizer
from bench.problem import Problem

if TYPE_CHECKING:
    from bench.diagnosis import Diagnosis
    from bench.results import Results
    from bench.trial import Result

KINDS = ("optimizers", "problems", "studies", "commands")


def show(kind: str, console: Console) -> None:
    """Print the plug-ins of a kind, or of all; one that fails to load is shown with its error."""
    if kind not in (*KINDS, "all"):
        raise BenchError(f"unknown kind {kind!r}{nearest(kind, (*KINDS, 'all'))}")
    for each in KINDS if kind == "all" else (kind,):
        table = Table("name", "what it is", "package", title=each, title_justify="left", box=None, pad_edge=False)
        for name, entry in sorted(plugins.entries(each).items()):
            package = f"{entry.dist.name} {entry.dist.version}" if entry.dist is not None else ""
            try:
                about, style = _about(name, plugins.load(each, name)), ""
            except BenchError as error:
                about, style = str(error), "red"
            except Exception as error:  # a stranger's plug-in may raise anything
                about, style = f"failed to load: {error}", "red"
            table.add_row(Text(name), Text(about, style=style), Text(package))
        console.print(table, "")


def _about(name: str, plugin: Any) -> str:
    """Return a line on what a plug-in is, and an optimizer's parameters."""
    if isinstance(plugin, plugins.Family) and not isinstance(plugin, type):
        names = plugin.names()
        return f"{names[0]} … {names[-1]}" if names else f"{name}:<name>"
    if isinstance(plugin, type) and issubclass(plugin, Optimizer):
        if not dataclasses.is_dataclass(plugin):
            raise TypeError("it is no dataclass")
        fields = dataclasses.fields(plugin)
        parameters = ", ".join(f"{field.name}={field.default!r}" for field in fields)
        return f"{_first_line(plugin)}\n{parameters}" if parameters else _first_line(plugin)
    if hasattr(plugin, "read_text"):
        from bench.study import Study

        return Study.load(name).title
    return _first_line(plugin)


def _first_line(thing: Any) -> str:
    return (inspect.getdoc(thing) or "").partition("\n")[0]


def show_status(results: Results, console: Console) -> None:
    """Print trials done and failed per optimizer, each failure's reason, and the machines that ran."""
    study, frame = results.study, results.frame
    planned = len(study.problems) * study.trials
    console.print(f"study {study.name}: {study.title}", markup=False, highlight=False, soft_wrap=True)
    table = Table("optimizer", "done", "failed", "of", box=None, pad_edge=False)
    for entry in study.optimizers:
        mine = frame[frame["optimizer"] == entry.label]["status"]
        table.add_row(Text(entry.label), str((mine == "ok").sum()), str((mine != "ok").sum()), str(planned))
    console.print(table)
    for row in frame[frame["status"] != "ok"].itertuples():
        reason = str(row.error).partition("\n")[0]
        line = f"{row.status}: {row.optimizer} on {row.problem}, trial {row.trial}: {reason}"
        console.print(line, style="red", markup=False, highlight=False, soft_wrap=True)
    for record in results.environments:
        git = record.get("git") or {}
        commit = f", commit {git['commit'][:10]}{' with changes' if git['dirty'] else ''}" if git else ""
        console.print(
            f"ran {record['started']} with {record['jobs']} jobs on {record['processor']}, {record['system']}, "
            f"Python {record['python']}{commit}",
            markup=False, highlight=False, soft_wrap=True,
        )  # fmt: skip


def show_checks(checks: dict[str, list[Diagnosis]], console: Console) -> None:
    """Print every check of every optimizer, failed ones in red."""
    for label, diagnoses in checks.items():
        for each in diagnoses:
            outcome = "passed" if each.passed else "FAILED"
            console.print(
                f"{outcome}: {label}, {each.check}: {each.finding}",
                style=None if each.passed else "red", markup=False, highlight=False, soft_wrap=True,
            )  # fmt: skip


def show_result(result: Result, problem: Problem, console: Console) -> None:
    """Print one run's best value, point, domain figures and times."""
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_row("best value", repr(result.fun))
    for name, value in zip(problem.variables, result.x, strict=True):
        table.add_row(Text(f"  {name}"), f"{value:.10g}")
    for name, value in result.figures.items():
        table.add_row(Text(name), f"{value:.6g}")
    table.add_row("evaluations", f"{result.nfev} (stopped by: {result.stop})")
    table.add_row(
        "time", f"{result.objective_time:.3f} s in the objective and {result.overhead_time:.3f} s in the optimizer"
    )
    console.print(table)
