"""The optimizer under check, as a name, a class or an instance, and in another process."""

from bench import load_optimizer
from bench.check.conformance.subject import Subject
from tests.bench.check.conformance.examine import failures, verdicts


def test_a_class_of_a_file_is_checked_under_its_relative_name(tmp_path):
    (tmp_path / "mine.py").write_text(
        "def search(objective, rng, n=3):\n    while True: objective(objective.initial(n))\n"
    )
    found = verdicts("mine.py:search")
    assert not failures(found)
    made = load_optimizer("mine.py:search", n=2)
    assert Subject.of(made, {}, 0) == Subject("mine.py:search", {"n": 2})
    assert Subject.of(type(made), {}, 0) == Subject("mine.py:search")
