"""bench audit: refuse or accept an optimizer that nobody trusts, for people and for programs."""

from __future__ import annotations

import json
import sys
from typing import Annotated, Any

import typer

from bench.cli.console import Jobs, Parameters
from bench.helpers.console import pairs, print_line


def command(
    name: Annotated[
        str,
        typer.Argument(help="An optimizer, such as path/to/file.py:Class."),
    ],
    option: Parameters = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the record as JSON, for programs.")] = False,
    problem: Annotated[
        list[str] | None,
        typer.Option(
            help="A problem to compare on, in place of six classical ones that the seed draws; repeatable.",
        ),
    ] = None,
    baseline: Annotated[
        list[str] | None,
        typer.Option(
            help="An optimizer to compare with, in place of random-search and cma-es; repeatable. What is worse than "
            "the first one is refused.",
        ),
    ] = None,
    trials: Annotated[int, typer.Option(help="Trials of each optimizer on each problem.")] = 10,
    budget: Annotated[str, typer.Option(help="Evaluations of a trial: a number, or such as '1e4 * d'.")] = "500 * d",
    timeout: Annotated[float, typer.Option(metavar="SECONDS", help="Wall-clock limit of a trial.")] = 20.0,
    seed: Annotated[int, typer.Option(help="Seed of the trials, and of the problems drawn.")] = 0,
    jobs: Jobs = -1,
) -> None:
    """Refuse or accept an optimizer that nobody trusts, such as a generated one, in a sandbox.

    It is checked against the contract, one of its trials is made twice, and it is compared with two baselines on
    problems that it has not seen. It is refused where it cannot be loaded, breaks the contract, does not repeat a
    trial, loses a trial, or is worse than random search. The exit code is 0 where it is accepted, 1 where it is refused
    and 2 for bad input.
    """
    from bench.check.audit import BASELINES, audit

    record = audit(
        name, problems=problem or (), baselines=baseline or BASELINES, trials=trials, budget=budget, timeout=timeout,
        seed=seed, jobs=jobs, **pairs(option),
    )  # fmt: skip
    if as_json:
        print(json.dumps(record, indent=1, allow_nan=False))
    else:
        _show(record)
    if not record["accepted"]:
        sys.exit(1)


def _show(record: dict[str, Any]) -> None:
    for verdict in record["check"]:
        print_line(f"{'passed' if verdict['passed'] else 'FAILED'}: {verdict['check']}: {verdict['finding']}")
    if repetition := record["repetition"]:
        said = repetition["difference"] or "the same bit by bit"
        print_line(f"one trial on {repetition['problem']} made twice: {said}")
    if comparison := record["comparison"]:
        where = f"{len(comparison['problems'])} problems, {comparison['trials']} trials of each"
        for about in comparison["baselines"]:
            interval = f"95% interval {about['low']:.0%} to {about['high']:.0%}, p = {about['p_holm']:.2g} (Holm)"
            print_line(f"{about['outcome']}: wins {about['a12']:.0%} against {about['name']} ({interval}; {where})")
    for reason in record["reasons"]:
        print_line(f"refused, {reason['code']}: {reason['text']}", "red")
    print_line(f"{record['optimizer']} is {'accepted' if record['accepted'] else 'refused'} ({record['seconds']} s)")
