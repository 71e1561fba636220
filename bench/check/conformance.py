"""What the contract asks of every optimizer: one check a rule.

A check is a function of a :class:`~bench.check.subject.Subject` that returns one sentence on what it saw, or raises
:class:`~bench.check.fault.FaultError`. It looks at one rule alone: an optimizer that breaks another one passes it
wherever it can.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from bench.check import manners, parameters, searching
from bench.check.fault import FaultError, UnmadeError
from bench.check.searching import START
from bench.check.subject import Subject
from bench.check.verdict import Verdict
from bench.sandbox.messages import describe_error

PATIENCE = 30.0  # seconds without a sign of life that are allowed once everything is imported and compiled


@dataclass(frozen=True)
class Check:
    """One rule of the contract.

    Attributes:
        name: what verdicts call it.
        examine: returns what it saw, or raises FaultError.
        mend: how to mend an exception of the optimizer in this check.
        needs: the checks without whose success this one tells nothing.
        patience: seconds without a sign of life that are allowed.
    """

    name: str
    examine: Callable[[Subject], str]
    mend: str
    needs: tuple[str, ...] = ("run",)
    patience: float = PATIENCE


_REPEATED = ("run", "repetition")
_ROBUST = "mend what raises: any dimension, any finite value and +inf can occur"

CHECKS = (
    Check("parameters", parameters.check_parameters, "declare fields of plain types with defaults that fit", ()),
    Check("run", searching.check_run, "mend what raises: this is an ordinary function of three variables", (), START),
    Check("budget", searching.check_budget, "mend what raises: any budget from 1 on can occur"),
    Check("repetition", searching.check_repetition, "mend what raises: this is an ordinary run with another seed"),
    Check("processes", searching.check_processes, "mend what raises in a new process", _REPEATED, 2 * START),
    Check("no state", searching.check_state, "a second run of an instance must start as the first did", _REPEATED),
    Check("pickling", searching.check_pickling, "keep plain values in the fields: no locks, no files", _REPEATED),
    Check("global states", searching.check_global_states, "draw from rng alone", _REPEATED),
    Check("box", searching.check_box, _ROBUST),
    Check("repair", searching.check_repair, "objective.repair(x) may move points within the box"),
    Check("dimensions", searching.check_dimensions, _ROBUST),
    Check("values", searching.check_values, _ROBUST),
    Check("contract", manners.check_contract, "use nothing but what the objective offers"),
    Check("anonymity", manners.check_anonymity, "use nothing but what the objective offers", _REPEATED),
    Check("silence", manners.check_silence, "a run must not need a terminal"),
    Check("leftovers", manners.check_leftovers, "a run must not depend on the working folder"),
)
"""All checks, in the order in which they are made."""


def each_check(ask: Callable[[Check], Verdict | None], checks: Iterable[Check] = CHECKS) -> Iterator[Verdict]:
    """Yield the verdicts that ``ask`` gives on the checks, without those that need one that did not pass."""
    passed: set[str] = set()
    for check in checks:
        verdict = ask(check) if passed.issuperset(check.needs) else None
        if verdict is not None:
            passed |= {check.name} if verdict.passed else set()
            yield verdict


def judge(check: Check, subject: Subject) -> Verdict | None:
    """Return the verdict of one check, None where there is nothing to examine.

    Whatever the optimizer raises becomes the finding.
    """
    try:
        return Verdict(check.name, "conformance", True, check.examine(subject))
    except UnmadeError:
        return None
    except FaultError as fault:
        return failed(check, fault.finding, fault.mend)
    except (Exception, SystemExit) as error:
        return failed(check, f"it raised {describe_error(error)}")


def failed(check: Check, finding: str, mend: str = "") -> Verdict:
    """Return a failed verdict of that check; without a ``mend`` of its own it gets the check's."""
    return Verdict(check.name, "conformance", False, finding, mend or check.mend)
