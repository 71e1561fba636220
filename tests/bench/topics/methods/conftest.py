"""The section on methods of a small study whose trials ran in given environments."""

from dataclasses import replace

import pandas as pd
import pytest

from bench import Results
from bench.topics.findings import Findings
from bench.topics.methods.environment import Environments
from bench.topics.methods.section import section


@pytest.fixture(scope="package")
def folder(make, tmp_path_factory):
    """Return the folder of a study of 2 problems, 3 optimizers and 4 trials."""
    return make(tmp_path_factory.mktemp("made") / "s", trials=4)


@pytest.fixture
def render(folder):
    """Return a function that makes the section of such records, with the lines on them of the section on trust.

    ``origins`` gives each trial the number of one.
    """

    def rendered(records, origins=None):
        results = Results(folder)
        results.environments[:] = records
        numbers = pd.Series(origins or [None] * len(results.frame), dtype=object)
        vars(results)["_read"] = results.frame, numbers, results.stored
        lines = tuple(Environments(results).warnings())
        return replace(section(Findings(results)), lines=lines)

    return rendered
