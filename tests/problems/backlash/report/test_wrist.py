"""The section on a robot's wrist: its rows beside the thesis's."""

import pytest

from bench import Results, Study
from bench.report import Table
from bench.study import Entry
from bench.topics import Findings
from problems.backlash.report import sections
from problems.backlash.report.wrist import TITLE
from tests.bench.reports import ended, store


def shown(folder, found):
    """Return the section of a study whose trials find these amplitudes, in rps by problem, give or take 0.01."""
    study = Study("wrist", tuple(Entry(name, name) for name in found), (Entry("cma-es", "cma-es"),), trials=2)

    def row_of(trial):
        return ended(1.0, metrics={"amplitude_rpm": 60 * (found[trial.problem] + 0.02 * trial.number - 0.01)})

    results = Results(store(folder, study, row_of))
    return next((each for each in sections(Findings(results)) if each.title == TITLE), None)


def test_a_joint_s_means_stand_beside_the_published_ones(tmp_path):
    section = shown(tmp_path / "s", {"wrist-4-healthy": 0.08, "wrist-4-tampered": 0.2})
    text = " ".join(section.text)
    assert "Joint 4: the mean |A| is 0.080 rps healthy and 0.200 rps tampered (published 0.101 and 0.209)." in text
    assert "Here they are choices" in text
    (table,) = (item for item in section.items if isinstance(item, Table))
    assert table.frame["mean published"].tolist() == [0.101, 0.209]
    assert table.frame["expected published"].tolist() == [0.07, 0.17]
    assert table.frame["expected"].tolist() == pytest.approx([0.07, 0.17], rel=0.01)
    assert table.frame["stdev"].tolist() == pytest.approx([0.0141, 0.0141], abs=1e-4)


def test_joint_1_has_nothing_published_and_nothing_to_see(tmp_path):
    section = shown(tmp_path / "s", {"wrist-1-healthy": 0.03, "wrist-1-tampered": 0.03})
    assert "its axis is vertical, so no gap opens" in " ".join(section.text)


def test_one_state_alone_is_not_compared_and_other_studies_have_no_section(tmp_path):
    assert "Joint" not in " ".join(shown(tmp_path / "s", {"wrist-5-healthy": 0.05}).text)
    assert shown(tmp_path / "t", {"signature-05": 0.5}) is None
