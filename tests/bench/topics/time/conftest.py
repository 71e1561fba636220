"""Sections of a small study whose trials ran in given environments."""

from types import SimpleNamespace

import pandas as pd
import pytest

from bench import Results
from bench.report.parts import Section
from bench.topics.findings import Findings
from bench.topics.time import environment


@pytest.fixture(scope="module")
def folder(make, tmp_path_factory):
    """Return the folder of a study of 2 problems, 3 optimizers and 4 trials."""
    return make(tmp_path_factory.mktemp("made") / "s", trials=4)


@pytest.fixture
def render(folder, monkeypatch):
    """Return a function that makes the section of such records; ``origins`` gives each trial the number of one."""

    def rendered(records, origins=None, of=environment):
        results = Results(folder)
        results.environments[:] = records
        numbers = pd.Series(origins or [None] * len(results.frame), dtype=object)
        monkeypatch.setattr(Results, "origins", numbers)
        section = of.section(Findings(results))
        assert isinstance(section, Section)
        return SimpleNamespace(
            text=" ".join(section.text), warnings=section.warnings, tables={item.name: item for item in section.items}
        )

    return rendered
