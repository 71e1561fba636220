"""What a report says of the number of trials: what would be needed, and extensions."""

import numpy as np
import pandas as pd
import pytest

from bench import Results
from bench.topics.findings import Findings
from bench.topics.integrity import section as integrity
from bench.topics.trials import section as trials
from bench.topics.verdict import section as verdict


@pytest.fixture(scope="module")
def folder(make, tmp_path_factory):
    """b and c are equal and far above a, on both problems."""
    return make(tmp_path_factory.mktemp("trials") / "s", trials=12, changes={"c": {"fun": 6.0}, "b": {"fun": 6.0}})


def findings_of(folder, records=()):
    results = Results(folder)
    results.environments[:] = records
    return Findings(results)


def test_pairs_that_are_not_separated_are_listed_with_the_trials_that_would(folder):
    shown = trials.section(findings_of(folder)).items[0].frame
    columns = ["first", "second", "trials", "needed", "more"]
    assert shown[columns].to_numpy().tolist() == [["b", "c", 12, ">1,000", ""]] * 2


@pytest.mark.parametrize(("problems", "trials"), [(("p", "q"), 10), (("p", "q"), 4), (("p",), 4)])
def test_no_number_of_trials_is_advised_with_which_the_test_cannot_reject(make, tmp_path, problems, trials):
    """Every pair is separated completely, and the tests on problems need more trials than there are."""
    final = findings_of(make(tmp_path / "few", problems, trials=trials)).final
    assert final.levels.problems == 0
    fewest = final.needed[["needed", "low"]].min(axis=None)
    assert final.enough == fewest
    assert Findings(Results(make(tmp_path / "enough", problems, trials=final.enough))).final.levels.problems
    assert final.needed["level"].iloc[0] == pytest.approx(final.level_on_problems / final.tests)


def test_trials_that_were_added_to_complete_ones_are_said_once_in_each_part(folder):
    record = {"trials": 12, "extends": 8, "packages": {}}
    known = findings_of(folder, records=[{"trials": 8, "extends": None}, record, record])
    assert known.trials.extensions == [(8, 12)]
    (sentence,) = trials.extension_text(known)
    assert sentence == trials.section(known).text[0]
    assert sentence in verdict.section(known).cards[2].text
    assert sum(each.startswith("Optional stopping: Trials were added") for each in integrity.warnings(known)) == 1
    early = findings_of(folder, records=[{"trials": 12, "extends": 3}, {"started": "of an older version"}])
    assert trials.extension_text(early) == []


def test_how_many_trials_would_separate_pairs_is_said_as_committed(committed):
    cases = [[40.0], [np.inf], [np.nan], [40.0, 90.0, np.inf]]
    tables = [pd.DataFrame({"needed": needed, "method": "simulation"}) for needed in cases]
    said = [trials.summary(table, 9, 0.9) for table in tables]
    said += [trials.summary(pd.DataFrame({"needed": [40.0, 90.0], "method": "formula"}), 9)]  # of very many pairs
    committed("trials-cases", "".join(f"{sentence}\n" for case in said for sentence in [*case, ""]))
