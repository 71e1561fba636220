"""The section on the kinds of problems."""

import numpy as np
import pandas as pd

from bench import Results
from bench.topics.findings import Findings
from bench.topics.landscapes import section as landscape
from bench.topics.landscapes.features import Landscapes, landscapes


def findings(folder, table, left_out=None):
    found = Findings(Results(folder))
    found._computed[landscapes] = Landscapes(table, left_out or {})
    return found


def table(problems, **columns):
    names = [f"p{i}" for i in range(problems)]
    return pd.DataFrame(dict.fromkeys(landscape.SHOWN, 0.5) | columns, index=pd.Index(names, name="problem"))


def test_problems_that_do_not_load_are_left_out(make, tmp_path):
    found = Findings(Results(make(tmp_path / "s")))
    assert set(found.of(landscapes).left_out) == {"p", "q"}
    assert landscape.section(found) is None


def test_few_problems_are_shown_without_a_claim(make, tmp_path):
    folder = make(tmp_path / "s", problems=("p0", "p1"))
    section = landscape.section(findings(folder, table(1), {"p1": "no"}))
    assert len(section.items) == 1
    assert "Not described: p1" in section.text[1]
    assert section.text[-1].endswith("from 10 problems on; here are 1.")
    one = landscape.section(findings(make(tmp_path / "t", problems=("p0",), optimizers=("a",)), table(1)))
    assert len(one.text) == 1


def test_the_feature_that_goes_with_ranks_is_named(make, tmp_path):
    folder = make(tmp_path / "s", problems=tuple(f"p{i}" for i in range(12)), trials=2)
    found = findings(folder, table(12, extra=np.arange(12.0)))
    section = landscape.section(found)
    assert section.text[-1].startswith("The features or the ranks are the same on all problems")
    found.final.__dict__["medians"] = pd.DataFrame(
        {"a": np.arange(12.0), "b": np.full(12, 5.5), "c": np.full(12, 99.0)}, index=[f"p{i}" for i in range(12)]
    )
    section = landscape.section(found)
    assert "2 tests of a feature" in section.text[-1]
    assert "a ranks worse the larger extra (rho = 0.87)" in section.text[-1]
    assert section.items[1].data["significant"].all()
