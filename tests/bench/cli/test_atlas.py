"""The command atlas."""

import pytest

TABLE = """
[methods.climb]
generation = 5
[[methods.climb.implementations]]
name = "hill-climber"
[[methods.climb.implementations]]
name = "hill-climber"
label = "copy"
[[methods.climb.implementations]]
name = "scatter"
[[methods.climb.implementations]]
name = "faulty"
"""


@pytest.fixture
def table(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(TABLE, encoding="utf-8")
    return file


@pytest.mark.slow
def test_it_prints_who_differs_and_writes_the_same_pages_again(bench_here, table, tmp_path):
    for name, jobs in (("one", 1), ("other", 2)):
        done = bench_here(
            "atlas", table, "--trials", "12", "--budget", "200", "--jobs", jobs, "--output", tmp_path / name
        )
        assert done.returncode == 0, done.stderr
    # In five dimensions "faulty" draws uniform points, as "scatter" does.
    assert "4 of 6 pairs of implementations of one method are different (240 tests" in " ".join(done.stdout.split())
    for each in (tmp_path / "one").iterdir():
        if each.name != "times.csv":
            assert each.read_bytes() == (tmp_path / "other" / each.name).read_bytes()
    page = (tmp_path / "one" / "climb.md").read_text(encoding="utf-8")
    assert "| `hill-climber`, `copy` | not found different |" in page
    assert "| `hill-climber`, `scatter` | **different** |" in page


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("none.toml",), "none.toml cannot be read"),
        (("--method", "gwp"), "the atlas has no method 'gwp'; did you mean 'gwo'"),
        (("--trials", "1"), "--trials"),
        (("--budget", "10"), "--budget"),
        (("--output", "."), "holds other files than an atlas"),
    ],
)
def test_bad_input_costs_one_sentence(bench_here, table, arguments, reason):
    done = bench_here("atlas", *arguments, cwd=table.parent)
    assert done.returncode == 2
    assert reason in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_missing_library_is_named_with_its_extra(bench_here, tmp_path, monkeypatch):
    import optimizers.common.family as family
    from bench.errors import BenchError

    def missing(module, extra, needed):
        raise BenchError(f"{needed} {module}; install it with: pip install 'backlash-bench[{extra}]'")

    monkeypatch.setattr(family, "require", missing)
    done = bench_here("atlas", "--method", "jso", "--trials", "2", "--budget", "60", "--jobs", "1", cwd=tmp_path)
    assert done.returncode == 2
    assert "pip install 'backlash-bench[minion]'" in done.stderr
    assert done.stderr.count("\n") == 1
