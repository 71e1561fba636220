"""The rule of the parameters."""

from textwrap import dedent

import pytest

from tests.bench.check import faulty
from tests.bench.check.conformance.examine import expect_broken, verdicts

FAULTS = [
    (faulty.Thawed, "parameters", "Thawed is no frozen dataclass", "@dataclass(frozen=True)"),
    (faulty.Plain, "parameters", "Plain is no frozen dataclass", "@dataclass(frozen=True)"),
    (faulty.Undecorated, "parameters", "'step' of Undecorated looks like a parameter", "above Undecorated too"),
    (faulty.Greedy, "parameters", "takes anything as 'step'", "call super().__post_init__()"),
    (faulty.Hasty, "parameters", "a wrong 'step' raises TypeError", "before anything else"),
    (faulty.Empty, "parameters", "it takes agents=0", "the least population that the method works with"),
    (faulty.Crowded, "parameters", "it fails with agents=1, the least", "declare the least population"),
    (faulty.Demanding, "parameters", "'step' has no default", "a default"),
    (faulty.Abstract, "parameters", "no method minimize", "write minimize"),
    (faulty.Misfit, "parameters", "BenchError: parameter 'step' of Misfit must be a whole number", "that fit"),
]


@pytest.mark.parametrize(
    ("optimizer", "rule", "finding", "remedy"), FAULTS, ids=lambda each: getattr(each, "__name__", "")
)
def test_a_fault_breaks_its_own_rule_alone_and_says_how_to_mend_it(optimizer, rule, finding, remedy):
    expect_broken(optimizer, rule, finding, remedy)


def test_what_a_constructor_raises_is_a_verdict_under_any_name(tmp_path):
    (tmp_path / "mine.py").write_text(
        dedent(
            """
            from dataclasses import dataclass
            import bench

            @dataclass(frozen=True)
            class Mine(bench.Optimizer):
                def __post_init__(self):
                    raise OSError("no licence")

                def minimize(self, objective, rng): ...
            """
        )
    )
    found = verdicts("mine.py:Mine")
    assert found.keys() == {"parameters"}
    assert "OSError: no licence" in found["parameters"].finding
