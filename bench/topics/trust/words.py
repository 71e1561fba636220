"""The sentences on what limits the answer, at most 30 words each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bench.report.wording import count, listing, percent

NAMED = 5  # labels of a list


def alike(clause: str, names: Sequence[str]) -> str:
    """Return what differs besides the algorithms, and what to set alike."""
    return f"{clause}: set {listing(names)} alike in the study to compare the algorithms alone."


def unused(shares: Mapping[str, float]) -> str:
    """Return who left budget unused, and what would use it."""
    named = listing([f"{label} left {percent(share)}" for label, share in shares.items()], NAMED)
    return f"{named} of the budget unused; restarts would use {'it' if len(shares) == 1 else 'theirs'}."


def budgets(common: str) -> str:
    """Return at which budget optimizers of different budgets are compared."""
    return f"Budgets differ: values are compared {common}; running times count all evaluations."


def checked(passed: int, troubles: int, unchecked: int) -> str:
    """Return how many checks of the results passed."""
    parts = [f"{count(passed, 'check')} passed", f"{troubles} did not" if troubles else ""]
    parts.append(f"{unchecked} need 'bench check' or 'bench verify'" if unchecked else "")
    return f"{', '.join(filter(None, parts))}."


def passed(names: Sequence[str]) -> str:
    """Return the names of the checks that passed."""
    return f"{listing(names, len(names))}."


def changed(made: Sequence[str], seed: int) -> str:
    """Return what was changed after the results, and what restores the level of the tests."""
    return (
        f"After the first results: {listing(made, NAMED)}. The 5% no longer holds; run again with another seed: "
        f"bench run … --seed {seed}."
    )


def unchanged() -> str:
    """Return that the page shows what its first run planned."""
    return "Nothing: the page shows what the first run planned."


def not_known() -> str:
    """Return what is known of a folder without a history."""
    return "Not known: the folder has no record of what its first run planned."


def shared(optimizers: Sequence[str]) -> str:
    """Return that runs of one seed count as one."""
    who = listing(optimizers, NAMED)
    return f"Runs of {who} share seeds across problems: over all problems, runs of one seed count as one."


def without_seeds() -> str:
    """Return what a table without seeds may hide."""
    return "Some runs have no seed on record; runs that share seeds across problems make tests err in more than 5%."


def scope(problems: int) -> str:
    """Return the fixed sentence on the problems that are meant."""
    meant = "this problem is" if problems == 1 else f"these {problems} problems are"
    return f"Only {meant} meant; nothing is claimed of others."


def measures(others: Mapping[str, int], problems: int) -> str:
    """Return on how many problems another measure names another optimizer than the chance to end lower does."""
    parts = [f"the lowest {name} on {number}" for name, number in others.items() if number]
    if not parts:
        return f"The lowest median and mean name the same first optimizer on {count(problems, 'problem')}."
    return f"Another first optimizer is named by {listing(parts)} of {count(problems, 'problem')}."


def not_loaded(labels: Sequence[str], why: str) -> str:
    """Return which problems cannot be loaded here."""
    which = f"{count(len(labels), 'problem')} cannot be loaded here"
    return f"{which}, so optimum and bounds are unknown: {listing(labels, NAMED)} ({why})."


def gaps(problems: int) -> str:
    """Return a sentence on problems on which an optimizer has no run."""
    return f"On {count(problems, 'problem')} at least one optimizer has no run; nothing is compared with it there."


def infeasible(lost: int, runs: int, handling: str) -> str:
    """Return a sentence on runs that found no feasible point."""
    return (
        f"{lost:,} of {count(runs, 'run')} under constraints (handled by {handling}) found no feasible point and rank "
        "below all others."
    )


def crowded() -> str:
    """Say that the machine was crowded."""
    return "More trials ran at a time than there were cores, so wall times are too long."
