"""The optimizer under check, as a name, a class or an instance, and in another process."""

from bench import load_optimizer
from bench.check.conformance.subject import Subject, pack, unpack
from tests.bench.check import faulty
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


def test_an_instance_is_checked_with_its_parameters():
    optimizer = faulty.Sound(agents=2, way="near")
    packed = pack(Subject.of(optimizer, {}, 3))
    assert unpack(packed) == Subject(optimizer, {}, 3, packed)
    assert "kept budgets of 1, 2, 3, 9, 1000" in verdicts(optimizer)["budget"].finding
