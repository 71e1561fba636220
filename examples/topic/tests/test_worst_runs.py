"""What an author's own tests need: that a number is right, and that small and odd studies have a page."""

import pytest
import worst_runs

import bench
from bench.topics import Findings


def study(folder, optimizers, trials=3):
    """Run a small study and return its findings."""
    small = bench.Study.from_dict(
        {
            "name": "small", "trials": trials, "budget": 40, "problems": [{"name": "classical-sphere-d2-i1"}],
            "optimizers": [{"name": name} for name in optimizers],
        }
    )  # fmt: skip
    bench.run(small, folder, n_jobs=1)
    return Findings(bench.Results(folder))


def test_the_worst_run_is_the_largest_value(tmp_path):
    findings = study(tmp_path / "s", ["random-search", "cma-es"])
    section = worst_runs.section(findings)
    frame = bench.load_results(tmp_path / "s")
    for optimizer, rows in frame.groupby("optimizer", observed=True):
        assert section.items[0].frame.loc["classical-sphere-d2-i1", optimizer] == rows["fun"].max()
    assert section.items[1].data["problems"].sum() == 1


@pytest.mark.parametrize("optimizers", [["random-search"], ["random-search", "cma-es"]])
def test_one_trial_and_one_optimizer_have_a_page(tmp_path, optimizers):
    study(tmp_path / "s", optimizers, trials=1)
    page = bench.write_report(tmp_path / "s", n_jobs=1).read_text(encoding="utf-8")
    assert (f"{worst_runs.TITLE}</h2>" in page) == (len(optimizers) > 1)
    assert "failed and is left out" not in page
