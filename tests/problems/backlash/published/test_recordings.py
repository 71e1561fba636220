"""The authors' recordings as problems and as a study, and the published numbers beside them."""

import numpy as np
import pandas as pd
import pytest

from bench import BenchError, Study, load_problem
from problems.backlash.published import download as files
from problems.backlash.published.recordings import table_7_3
from problems.backlash.report import fitting_errors
from problems.backlash.report.figures import short
from problems.backlash.signature.datasets import dataset


@pytest.fixture
def load(published, monkeypatch):
    """Load a problem of the published recordings, of which there may be a part."""
    monkeypatch.setenv(files.VARIABLE, str(published))

    def of(name, **options):
        try:
            return load_problem(name, **options)
        except BenchError as error:
            if "is not in" in str(error):
                pytest.skip(str(error))
            raise

    return of


def test_the_shared_recordings_are_whole(published):
    found = [files.look_up(file, published) for file in files.registry().values()]
    assert all(whole for path, whole in found if path is not None)


@pytest.mark.parametrize("level", [3, 12])
def test_a_clean_recording_is_the_file_s(load, published, level):
    problem = load(f"published-{level:02d}")
    table = pd.read_excel(published / f"Speeddata{level}.xlsx", engine="openpyxl").to_numpy()
    np.testing.assert_allclose(problem.time, table[:, 0], atol=1e-12)
    np.testing.assert_allclose(problem.signal + problem.mean_rps, table[:, 1])


def test_the_truth_is_the_half_gap_and_where_the_table_has_it_the_theoretical_amplitude(load):
    known = load("published-03").expected
    assert known["backlash_rad"][0] == pytest.approx(0.0005)
    assert known["amplitude_rpm"][0] == pytest.approx(60 * 0.4159)
    assert "amplitude_rpm" not in load("published-12").expected


def test_without_the_files_problems_are_named_and_planned_but_not_loaded(monkeypatch, tmp_path):
    monkeypatch.setenv(files.VARIABLE, str(tmp_path))
    study = Study.load("published")
    assert {trial.problem for trial in study.plan()} == {f"published-{level:02d}" for level in range(3, 14)}
    with pytest.raises(BenchError, match=r"Speeddata3.xlsx is not in .*; get it with 'bench data fetch'$"):
        study.dimensions()
    with pytest.raises(BenchError, match=r"Data_with_Noise_11.zip is not in"):
        load_problem("published:high-11-02")
    with pytest.raises(BenchError, match="has no option 'units'"):
        load_problem("published-03", units="rpm")


def test_table_7_2_takes_the_published_recordings_for_its_datasets():
    assert fitting_errors.datasets(Study.load("published")) == {f"published-{k:02d}": k for k in range(3, 14)}
    assert [short(name) for name in ("published-03", "published-13", "published:low-1-3")] == [
        "3", "13", "published:low-1-3",
    ]  # fmt: skip


def test_every_printed_error_of_table_7_3_is_that_of_the_mean():
    rows = [*table_7_3().dropna().itertuples()]
    errors = [100 * abs(row.mean - row.theoretical) / row.theoretical for row in rows]
    assert len(rows) == 10
    assert errors == pytest.approx([row.error for row in rows], abs=0.01)


def test_its_theoretical_amplitudes_are_the_peaks_of_datasets_2_to_11():
    simulated = [dataset(level).peak for level in range(2, 12)]
    assert simulated == pytest.approx(table_7_3()["theoretical"].loc[2:11].tolist(), rel=0.03)
