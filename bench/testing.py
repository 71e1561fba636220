"""Tests for authors of plug-ins: the rules of the contracts as cases of pytest.

This module needs pytest, which backlash-bench does not install.
"""

from __future__ import annotations

import atexit
import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from typing import ClassVar

import pytest

from bench.check.checker import Checker
from bench.check.conformance.problem_subject import ProblemSubject
from bench.check.conformance.rules import TABLES, Rule
from bench.check.conformance.subject import AnySubject, Subject
from bench.contract.optimizer import Optimizer, is_frozen
from bench.contract.problem import Problem
from bench.helpers.errors import BenchError, nearest

__all__ = ["RuleCheck", "parametrize_with_checks", "parametrize_with_problem_checks"]

Source = str | type[Optimizer] | Optimizer | type[Problem] | Problem
ExpectedFailures = Mapping[str, str]


def parametrize_with_checks(
    optimizers: Iterable[Source], *, expected_failures: ExpectedFailures | None = None
) -> pytest.MarkDecorator:
    """Decorate a test function, so that pytest runs it once for every optimizer and rule of the contract.

    The function has one argument, ``check``, and calls it. The ids are the optimizer and the rule, such as
    ``HillClimber-budget`` or ``HillClimber(sigma=0.1)-no-state``. A check runs in a process of its own and within a
    time limit, as in :func:`bench.check_optimizer`. It fails with the finding and how to fix it, and is skipped where
    it means nothing because the optimizer breaks another rule. While pytest collects tests, no optimizer runs and none
    is loaded by its name.

    Example:
        >>> from bench.testing import parametrize_with_checks
        >>>
        >>> @parametrize_with_checks([HillClimber, "my-optimizer", HillClimber(sigma=0.1)])
        ... def test_conforms(check):
        ...     check()

    Args:
        optimizers: names, classes or instances, as for :func:`bench.check_optimizer`.
        expected_failures: the reason for every rule that is known to be broken, by the rule's name, such as
            ``{"silence": "the library prints a banner"}``. A failure is then expected (xfail, strict): a check of that
            rule that passes is reported as a failure.

    Raises:
        BenchError: when ``optimizers`` is a single optimizer, is empty or contains anything else, and for an unknown
            rule or a missing reason in ``expected_failures``.
    """
    return _parametrized(optimizers, Subject, expected_failures)


def parametrize_with_problem_checks(
    problems: Iterable[str | type[Problem] | Problem], *, expected_failures: ExpectedFailures | None = None
) -> pytest.MarkDecorator:
    """Decorate a test function, so that pytest runs it once for every problem and rule of the contract.

    It does for problems, as for :func:`bench.check_problem`, what :func:`parametrize_with_checks` does for optimizers.

    Example:
        >>> from bench.testing import parametrize_with_problem_checks
        >>>
        >>> @parametrize_with_problem_checks(["water-filling-2", "water-filling-8"])
        ... def test_conforms(check):
        ...     check()

    Args:
        problems: names, classes or instances.
        expected_failures: as of :func:`parametrize_with_checks`.

    Raises:
        BenchError: as from :func:`parametrize_with_checks`.
    """
    return _parametrized(problems, ProblemSubject, expected_failures)


def _parametrized(
    sources: Iterable[Source], subject: type[AnySubject], expected_failures: ExpectedFailures | None
) -> pytest.MarkDecorator:
    if isinstance(sources, (str, type, Optimizer, Problem)):
        raise BenchError(f"give a list of {subject.kind}s, such as [{sources!r}]")
    cases = [case for source in sources for case in _cases(source, subject, expected_failures)]
    if not cases:
        raise BenchError(f"give at least one {subject.kind} to check")
    return pytest.mark.parametrize("check", cases)


class RuleCheck:
    """The check of one optimizer or problem against one rule of its contract; a test calls it.

    Attributes:
        source: the optimizer or problem as it was given.
        rule: the name of the rule, such as ``"budget"``.
    """

    _last: ClassVar[Checker | None] = None  # its process ends when another plug-in is checked

    def __init__(self, source: Source, rule: Rule, checker: Checker, subject: type[AnySubject]) -> None:
        self.source, self.rule = source, rule.name
        self._rule, self._checker, self._subject = rule, checker, subject

    def __repr__(self) -> str:
        return f"<check of {_label(self.source)}: {self.rule}>"

    def __call__(self) -> None:
        """Return if the plug-in keeps the rule; fail the test if it breaks the rule.

        The test is skipped where the rule cannot be checked because another one is broken.

        Raises:
            BenchError: for an unknown name.
        """
        __tracebackhide__ = True
        label, checker = _label(self.source), self._checker
        try:
            self._subject.of(self.source, {}, 0)
        except BenchError as error:
            raise BenchError(str(error)) from None  # without the frames in which the name was looked up
        if RuleCheck._last not in (None, checker):
            RuleCheck._last.close()
        RuleCheck._last = checker
        verdict = checker.verdict(self._rule)
        if verdict is None and checker.unloadable:
            pytest.skip(f"not checked: {checker.unloadable}")
        if verdict is None:
            pytest.skip(f"not checked, because {label} breaks the rule {checker.obstacle(self._rule).name!r}")
        if not verdict.passed:
            finding = f"{label} breaks the rule {self.rule!r}: {verdict.finding}"
            pytest.fail(f"{finding}\nremedy: {verdict.remedy}", pytrace=False)


def _cases(source: Source, subject: type[AnySubject], expected_failures: ExpectedFailures | None) -> Iterator[object]:
    """Yield one case for every rule, with its id and, where it is expected to fail, its mark."""
    expected = expected_failures or {}
    checker = Checker(subject(source) if isinstance(source, str) else subject.of(source, {}, 0))
    atexit.register(checker.close)
    names = [rule.name for rule in TABLES[subject.kind]]
    for name, reason in expected.items():
        if name not in names:
            raise BenchError(f"expected_failures names an unknown rule {name!r}{nearest(name, names)}")
        if not isinstance(reason, str) or not reason.strip():
            raise BenchError(f"expected_failures must give the reason for {name!r} as a text, not {reason!r}")
    for rule in TABLES[subject.kind]:
        marks = []
        if rule.name in expected:
            marks.append(pytest.mark.xfail(reason=expected[rule.name], strict=True, raises=pytest.fail.Exception))
        name = f"{_label(source)}-{rule.name.replace(' ', '-')}"
        yield pytest.param(RuleCheck(source, rule, checker, subject), id=name, marks=marks)


def _label(source: Source) -> str:
    """Return the plug-in's part of an id: a name, a class's name, or that with the parameters that were set."""
    if isinstance(source, str):
        return source
    if isinstance(source, (type, Problem)):
        return source.__name__ if isinstance(source, type) else str(source.name)
    parameters = []
    for field in dataclasses.fields(source) if is_frozen(type(source)) else ():  # type: ignore[arg-type]
        value = getattr(source, field.name)
        if isinstance(value, (bool, int, float, str)) and value != field.default:
            parameters.append(f"{field.name}={value!r}")  # no others: they may show an address, and ids must repeat
    return f"{type(source).__name__}({', '.join(parameters)})"
