"""Say in sentences what of a study is not compared, and why."""

from __future__ import annotations

from bench.analysis.comparable import Comparable
from bench.report.wording import count, listing

NAMED = 6  # problems, or optimizers, that a sentence names


def left_out(found: Comparable) -> tuple[str, ...]:
    """Return a sentence for each reason for which something is not compared."""
    return tuple(filter(None, (_failed(found), *_instances(found), *_unknown(found))))


def _failed(found: Comparable) -> str:
    """Return whose own code raised, which says nothing about an optimizer."""
    named = [
        f"{problem} (in {raised:,} of {count(trials, 'trial')})" for problem, (raised, trials) in found.failed.items()
    ]
    one = len(named) == 1
    which, whose = ("problem that failed is", "its") if one else (f"{len(named)} problems that failed are", "their")
    return (
        f"The {which} not compared, as {whose} own code raised, not an optimizer’s: {listing(named, NAMED)}."
        if named
        else ""
    )


def _instances(found: Comparable) -> list[str]:
    """Return on which problems the optimizers share some instances, and on which none."""
    some = [f"{shared} of {every} on {problem}" for problem, (shared, every) in found.instances.items() if shared]
    none = [problem for problem, (shared, _) in found.instances.items() if not shared]
    sentences = []
    if some:
        sentences.append(
            f"Final values are compared on the instances that all optimizers share ({listing(some, NAMED)}); running "
            "times to targets count all instances."
        )
    if none:
        sentences.append(f"The optimizers share no instance of {listing(none, NAMED)}, so they are not compared there.")
    return sentences


def _unknown(found: Comparable) -> list[str]:
    """Return a sentence on optimizers that spent more than the common budget without a trace, by problem."""
    problems: dict[str, list[str]] = {}
    for problem, optimizer in found.unknown:
        problems.setdefault(optimizer, []).append(problem)
    together: dict[tuple[str, ...], list[str]] = {}
    for optimizer, labels in problems.items():
        together.setdefault(tuple(labels), []).append(optimizer)
    return [
        f"{listing(owners, NAMED)} spent more evaluations than others had on {listing(labels, NAMED)}, and what was "
        f"found by then is not known, so {'it is' if len(owners) == 1 else 'they are'} not compared there."
        for labels, owners in together.items()
    ]
