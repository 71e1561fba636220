"""Versions of a subject beside each other: the page stays about the last one, and says when they were chosen."""

import numpy as np
import pytest

from bench import Results, Study
from bench.storage.folder import Folder
from bench.storage.selection import Selection
from bench.study import Entry
from bench.study.cell import with_inputs
from bench.topics.answer.section import headline, lines
from bench.topics.findings import Findings
from bench.trial.columns import packed
from tests.bench.reports import finished


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Version 1 of mine finds about 6, version 2 about 4, which is below the 5 of its rival."""
    place, rng = Folder(tmp_path_factory.mktemp("versions") / "s"), np.random.default_rng(0)
    place.path.mkdir()
    entries = (tuple(Entry("any", label) for label in labels) for labels in ("pq", ("rival", "mine")))
    study = Study("made", *entries, trials=8, budget=100, subject="mine")
    for number, value in ((1, 6.0), (2, 4.0)):
        cells = {
            labels: cell._replace(optimizer=with_inputs(cell.optimizer, number)) if labels[1] == "mine" else cell
            for labels, cell in study.cells({}).items()
        }
        place.claim(study, Selection(cells))
        with place.store.writer() as writer:
            run = writer.record("environments", {"subject": "mine", "started": f"2026-01-0{number}"})
            for trial in study.plan():
                if trial.optimizer == "mine" or number == 1:
                    ends = value if trial.optimizer == "mine" else 5.0
                    writer.add(trial, packed(finished(ends + 0.1 * rng.standard_normal(), rng)), run)
    return place.path


def test_the_page_stays_about_the_subject_and_its_first_line_has_the_version_before(folder):
    found = Findings(Results(folder, versions=["mine"]))
    assert found.subject == "mine@2"
    assert headline(found) == "mine@2 beats 2 of 2 rivals on these 2 problems."
    (how,) = (line.text for line in lines(found) if line.label == "by how much")
    assert how.startswith("a run of mine@2 ends lower than one of rival in 100% [")


@pytest.mark.parametrize("versions", [(), ("mine",)])
def test_with_and_without_the_version_before_the_page_says_that_the_last_one_was_chosen_after_the_results(
    folder, versions
):
    found = Findings(Results(folder, versions=versions))
    (sure,) = (line.text for line in lines(found) if line.label == "how sure")
    assert sure.startswith("changed after the results: versions of 1 optimizer chosen; run again with another seed")
    said = (
        "is version 2 of 2 run here" if not versions else "The versions before mine@2 are shown beside it, chosen after"
    )
    assert said in found.selection
