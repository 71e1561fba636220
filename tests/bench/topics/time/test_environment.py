"""The report distinguishes machines and versions, and which trials came from which."""

import pandas as pd

from tests.bench.topics.time.records import NEWER, OLD, RECORD


def shown(table):
    return [[cell.text for cell in row] for row in table.rows]


def test_an_environment_that_made_no_trial_left_warns_of_nothing(render):
    section = render([RECORD, NEWER], [1] * 24)
    assert section.warnings == ()
    assert list(section.tables["runs"].frame["trials"]) == [24, 0]
    assert render([RECORD, NEWER]).warnings != ()  # which made them is not known


def test_the_records_of_older_folders_are_read(render):
    section = render([OLD, OLD | {"python": "3.12.1"}])
    assert "B differs from A by Python 3.11.7 → 3.12.1" in section.warnings[0]
    assert shown(section.tables["environment"])[-1] == [
        "commit", f"{RECORD['git']['commit']} with uncommitted changes",
    ]  # fmt: skip
    assert "trials" not in section.tables["runs"].frame
    assert "environment-trials" not in section.tables
    assert render([{}]).tables["runs"].frame.shape[0] == 1
    assert "no record" in render([]).warnings[0]


def test_fifty_environments_can_still_be_read(render):
    records = [RECORD | {"python": f"3.11.{i}"} for i in range(50)]
    section = render(records, [1 + i % 50 for i in range(24)])
    (warning,) = section.warnings
    assert warning.startswith("The trials come from 24 different environments")
    assert warning.endswith("D differs from A by Python 3.11.0 → 3.11.3; and 20 more.")
    assert list(section.tables["environments"].frame.index[[0, 25, 26, 49]]) == ["A", "Z", "AA", "AX"]
    table = section.tables["environment-trials"]
    assert len(table.header) == 13
    assert table.header[-1] == ("others", True)
    assert (table.frame.sum(axis=1) == 8).all()
    assert table.data["environment"].nunique() == 24


def test_the_state_of_code_is_shown_by_a_hash(render):
    dirty = {"commit": "f" * 40, "dirty": True, "diff": "0123456789abcdef" * 4}
    rows = shown(render([RECORD | {"checkouts": {"mine": dirty}}]).tables["environment"])
    assert ["commit of mine", f"{'f' * 40} with uncommitted changes (0123456789ab)"] in rows


def test_every_table_is_written_as_latex_and_csv(render, tmp_path):
    from bench.report.write import save_table

    section = render([RECORD, NEWER, OLD], [1, 2, 3] * 8)
    for name, table in section.tables.items():
        for path in save_table(table, tmp_path, name):
            assert (tmp_path / path).stat().st_size
    data = pd.read_csv(tmp_path / "tables" / "environment-trials.csv")
    assert list(data.columns) == ["problem", "optimizer", "trial", "run", "environment"]
    assert list(data["run"]) == [1, 2, 3] * 8
