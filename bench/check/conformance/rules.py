"""The tables of the contracts' rules, which ``bench.check``, ``bench check`` and ``bench.testing`` share.

A rule's function takes a :class:`~bench.check.conformance.subject.Subject`, of an optimizer, or a
:class:`~bench.check.conformance.problem_subject.ProblemSubject`. It returns one sentence on what it observed, or raises
:class:`~bench.check.conformance.recording.ViolationError`. It judges one rule alone: what breaks another rule passes it
wherever possible.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from bench.check.conformance import (
    apartness,
    clocks,
    following,
    invariances,
    isolation,
    parameters,
    problem_probes,
    problem_rules,
    robustness,
)
from bench.check.conformance.recording import ViolationError
from bench.check.conformance.subject import START_SECONDS, AnySubject
from bench.check.verdict import Verdict
from bench.sandbox.messages import describe_error

SECONDS = 300.0  # that a rule may take: up to a dozen runs of about 150 evaluations, also of a slow optimizer


@dataclass(frozen=True)
class Rule:
    """One rule of the contract.

    Attributes:
        name: the name in verdicts, such as ``"budget"``.
        examine: the rule's function; it may return None where the optimizer cannot be constructed.
        remedy: how to fix an exception that the plug-in raises in this check.
        needs: the rules that it must keep before this one can be checked.
        seconds: that its check may take.
    """

    name: str
    examine: Callable[[Any], str | None]
    remedy: str
    needs: tuple[str, ...] = ("run",)
    seconds: float = SECONDS


_ORDINARY = "fix what raises: this is an ordinary function of three variables"
_REPEATED = ("run", "repetition")
_ROBUST = "fix what raises: any dimension, any finite value and +inf can occur"

RULES = (
    Rule("parameters", parameters.check_parameters, "declare fields of plain types with defaults that fit", ()),
    Rule("run", robustness.check_run, _ORDINARY, (), START_SECONDS),
    Rule("budget", robustness.check_budget, "fix what raises: any budget from 1 on can occur"),
    Rule("repetition", isolation.check_repetition, "fix what raises: this is an ordinary run with another seed"),
    Rule("processes", isolation.check_processes, "fix what raises in a new process", _REPEATED),
    Rule("no state", isolation.check_state, "a second run of an instance must start as the first did", _REPEATED),
    Rule("pickling", isolation.check_pickling, "keep plain values in the fields: no locks, no files", _REPEATED),
    Rule("global states", isolation.check_global_states, "draw from rng alone", _REPEATED),
    Rule("clock", clocks.check_clock, "fix what raises where clocks go fast", _REPEATED),
    Rule("leader", following.check_leader, "fix what raises with other values", _REPEATED),
    Rule("box", robustness.check_box, _ROBUST),
    Rule("dimensions", robustness.check_dimensions, _ROBUST),
    Rule("values", robustness.check_values, _ROBUST),
    Rule("contract", isolation.check_contract, "use nothing but what the objective offers"),
    Rule("anonymity", isolation.check_anonymity, "use nothing but what the objective offers", _REPEATED),
    Rule("silence", isolation.check_silence, "a run must not need a terminal"),
    Rule("leftovers", isolation.check_leftovers, "a run must not depend on the working folder"),
    Rule("invariances", invariances.check_invariances, _ROBUST, _REPEATED),
    Rule("idle parameters", invariances.check_parameters_in_use, "fix what raises with other parameters", _REPEATED),
)
"""All rules, in the order in which they are checked."""

APART = Rule("problem apart", apartness.check_apart, "get values from objective(x) alone", _REPEATED)
"""The rule that is checked only on request, as it takes processes that can be given sockets."""

_ANY_POINT = "fix what raises: any point of the box can occur, alone and in batches of any size"
_PURE = ("declaration", "values", "batches")
_DECIDED = (*_PURE, "noise")

PROBLEM_RULES = (
    Rule("declaration", problem_rules.check_declaration, "set the attributes of a Problem where it is made", ()),
    Rule("values", problem_rules.check_values, _ANY_POINT, ("declaration",)),
    Rule("batches", problem_rules.check_batches, _ANY_POINT, ("declaration", "values")),
    Rule("calls", problem_probes.check_calls, _ANY_POINT, _PURE),
    Rule("resolution", problem_probes.check_resolution, _ANY_POINT, _PURE),
    Rule("variables", problem_probes.check_variables, _ANY_POINT, _PURE),
    Rule("noise", problem_rules.check_noise, "take evaluate(x, rng), and return true values from noiseless(x)", _PURE),
    Rule("repair", problem_rules.check_box_repair, "let repair take any point, also outside the box", ("declaration",)),
    Rule("optimum", problem_rules.check_optimum, _ANY_POINT, ("declaration", "values")),
    Rule("processes", isolation.check_processes, "fix what raises in a new process", _DECIDED),
    Rule(
        "no state", isolation.check_state, "a second series of calls must find the problem as the first did", _DECIDED
    ),
    Rule("pickling", isolation.check_pickling, "let __reduce__ return load_problem and the name", _DECIDED),
    Rule("global states", isolation.check_global_states, "draw from a generator of its own", _DECIDED),
    Rule("clock", clocks.check_clock, "fix what raises where clocks go fast", _DECIDED),
    Rule("instances", problem_rules.check_instances, "fix what raises for another instance", _DECIDED),
    Rule("silence", isolation.check_silence, "a call must not need a terminal", _DECIDED),
    Rule("leftovers", isolation.check_leftovers, "a call must not depend on the working folder", _DECIDED),
)
"""The rules of a problem, in the order in which they are checked; "no state" to "clock" and those of silence and
leftovers are those of optimizers."""

SEARCH = Rule("search", problem_rules.check_search, "fix what raises during a search", _DECIDED, 86_400.0)
"""The rule of a problem that is checked only on request, as it takes minutes."""

TABLES = {"optimizer": RULES, "problem": PROBLEM_RULES}


def find_rule(name: str, kind: str = "optimizer") -> Rule:
    """Return the rule of that name for an optimizer or a problem."""
    return next(rule for rule in (*TABLES[kind], APART, SEARCH) if rule.name == name)


def judge(rule: Rule, subject: AnySubject) -> Verdict | None:
    """Return the verdict on one rule, None where there is nothing to examine; any exception becomes the finding."""
    try:
        observed = rule.examine(subject)
        return None if observed is None else Verdict(rule.name, "conformance", True, observed)
    except ViolationError as violation:
        return failed(rule, violation.finding, violation.remedy)
    except (Exception, SystemExit) as error:
        return failed(rule, f"it raised {describe_error(error)}")


def failed(rule: Rule, finding: str, remedy: str = "") -> Verdict:
    """Return a failed verdict on the rule; without a ``remedy`` of its own it gets the rule's."""
    return Verdict(rule.name, "conformance", False, finding, remedy or rule.remedy)
