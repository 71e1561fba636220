"""What the Tab key offers: names of optimizers, problems, studies and folders, in parts where there are many."""

import pytest

from bench.cli import completion


@pytest.fixture
def complete(bench_here, monkeypatch):
    """Return a function that completes a command line as bash's completion does."""

    def offered(line, cwd="."):
        words = line.split(" ")
        monkeypatch.setenv("_BENCH_COMPLETE", "complete_bash")
        monkeypatch.setenv("COMP_WORDS", "\n".join(["bench", *words]))
        monkeypatch.setenv("COMP_CWORD", str(len(words)))
        return bench_here(cwd=cwd).stdout.split()

    return offered


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("solve signature-12 cma", ["cma-es", "cma-es-fast"]),
        ("check cma-es-f", ["cma-es-fast"]),
        ("run thesis-", ["thesis-equal", "thesis-plus"]),
        ("run mi", ["mine.toml"]),
        ("run quick --optimizer alo", ["alo"]),
        ("run quick --problem bbob-noisy-f101-d2-i15", ["bbob-noisy-f101-d2-i15"]),
        ("status ", ["near", "results/runs/mine"]),
        ("status results", ["results/runs/mine"]),
        ("report near results", ["results/runs/mine"]),
        ("doctor ne", ["near"]),
        ("list stu", ["studies"]),
        ("gat", ["gate"]),
    ],
)
def test_arguments_and_options_complete(complete, line, offered, tmp_path):
    for place in ("near", "results/runs/mine", "results/runs/empty"):
        (tmp_path / place).mkdir(parents=True)
        if place != "results/runs/empty":
            (tmp_path / place / "study.toml").touch()
    (tmp_path / "mine.toml").touch()
    assert complete(line, tmp_path) == offered


def test_many_problems_complete_part_by_part():
    functions = completion.problems("bbob-f")
    assert functions == [f"bbob-f{number:02d}-" for number in range(1, 25)]
    assert completion.problems("bbob-f08-d1") == [f"bbob-f08-d10-i{number}" for number in sorted(range(1, 16), key=str)]
    assert "signature-" in completion.problems("")
    assert "bbob-" in completion.problems("")


def test_names_in_parts_never_lose_one():
    names = [f"a-b-{number // 10}-{number}" for number in range(100)]
    assert completion.by_parts(names, "") == [f"a-b-{tens}-" for tens in range(10)]
    assert completion.by_parts(names, "a-b-3") == [f"a-b-{tens}-" for tens in range(10)]
    assert completion.by_parts(names[:40], "") == names[:40]
    same = [f"x{number}" for number in range(50)]
    assert completion.by_parts(same, "x") == same


def test_of_a_family_of_optimizers_only_the_name_is_offered():
    """mealpy takes seconds to import."""
    assert completion.optimizers("mea") == ["mealpy"]


def test_a_plugin_that_fails_to_load_is_offered_and_hides_no_other(complete):
    assert complete("check b") == ["bipop-cma-es", "broken"]
