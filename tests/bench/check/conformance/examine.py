"""Verdicts on faulty optimizers, made in this process."""

from bench.check.checker import Checker
from bench.check.conformance.rules import RULES, judge
from bench.check.conformance.subject import Subject

ALL = {rule.name for rule in RULES}
IN_ONE_PROCESS = [rule for rule in RULES if rule.name != "processes"]


class InThisProcess(Checker):
    def _judge(self, rule):
        return judge(rule, self._subject)


def verdicts(optimizer, rules=IN_ONE_PROCESS, **options):
    """Return the verdicts by rule."""
    checker = InThisProcess(Subject.of(optimizer, options, seed=0))
    return {verdict.check: verdict for verdict in filter(None, map(checker.verdict, rules))}


def failures(found):
    return [verdict for verdict in found.values() if not verdict.passed]


def expect_broken(found, rule, finding, remedy):
    """Assert that of these verdicts by rule this one alone failed, with a finding and advice that hold these words."""
    assert [verdict.check for verdict in failures(found)] == [rule]
    assert finding in found[rule].finding
    assert remedy in found[rule].remedy
    assert "\n" not in found[rule].finding
