"""Targets in the sections: the usual ones, those asked for, and running times."""

import numpy as np
import pandas as pd
import pytest

from bench import Results, load_problem
from bench.results.results import ProblemFacts
from bench.topics.course import section as course
from bench.topics.course.times import ratios
from bench.topics.findings import Findings
from bench.topics.methods.methods import methods
from tests.bench.formats.made import make as made
from tests.bench.formats.made import record
from tests.bench.made import Known


@pytest.fixture(scope="module")
def folder(make, tmp_path_factory):
    """Return the folder of a study without optima: optimizers a, b and c find about 5, 6 and 7 on p and q."""
    return make(tmp_path_factory.mktemp("usual") / "s", trials=4)


def findings(folder, asked=None, expected=None, **optima):
    known = Known(folder, lambda label: ProblemFacts(expected=expected)) if expected else Results(folder)
    found = Findings(known, asked)
    found.trials.__dict__["optima"] = optima
    return found


class TestSections:
    @pytest.mark.sampled(1)
    @pytest.mark.parametrize(
        ("chosen", "optima"),
        [
            *(("precisions", optima) for optima in ({}, {"p": 4.0}, {"p": 4.0, "q": 0.0})),
            *(("relative", optima) for optima in ({}, {"p": 4.0, "q": 0.0})),
            ("quantiles", {"p": 4.0}),
            ("tolerance", {}),
            *(([9.0, 1.0, 0.1], optima) for optima in ({}, {"p": 4.0})),
            (["50%"], {"p": 4.0, "q": 0.0}),
        ],
    )
    def test_every_set_has_its_parts(self, folder, chosen, optima):
        found = findings(folder, chosen, {"speed": (1.0, 2.0)} if chosen == "tolerance" else None, **optima)
        found.anytime.check_targets()
        section = course.section(found)
        written = [file.path for file in section.files]
        assert "tables/running-times.csv" in written
        assert ("tables/aocc.csv" in written) == (found.anytime.target_set.absolute and bool(found.trials.unbeaten))
        assert "nan" not in " ".join(section.text)
        assert methods(found).text


class TestRunLengths:
    """Targets by running length, of f08 in 2 dimensions: 3 trials of 100 evaluations, of optimizers a and b."""

    @pytest.fixture
    def small(self, tmp_path):
        def found(asked=None, function="bbob-f08-d2", **changes):
            precisions = [1e2, 10**1.8, 10**1.6, 10**1.4, 10**1.2]
            known = pd.DataFrame(
                {"problem": "bbob-f08-d2", "precision": precisions, "ert": [1.0, 2.0, 6.0, 19.0, 99.0]}
            )
            optimum = load_problem(f"{function}-i1").optimum

            def row(trial, _values):
                ends = {"a": 10**1.3, "b": 90.0}[trial.optimizer]
                values = np.concatenate([np.full(7, 500.0), np.full(93, ends)]) + optimum
                return record(values, 2)

            study = {"trials": 3, "row": row} | changes
            folder = made(tmp_path / "s", {f"{function}-i1": 2}, **study).paths[0]
            made_of = Findings(Results(folder), asked)
            vars(made_of.anytime)["best"] = known
            return made_of

        return found

    def test_they_are_the_usual_ones_of_small_budgets_where_the_best_is_there(self, small):
        found = small()
        assert found.anytime.target_set == "runlength"
        assert found.anytime.near == 0

    def test_the_table_is_relative_to_the_best_of_2009(self, small):
        """Within 3 d evaluations the best reached 10^1.6; a precision of 10^1.4 took it 19 evaluations, and a 8."""
        found = small()
        table = ratios(found)
        assert list(table.frame) == ["best of 2009", "a", "b"]
        assert table.typography.texts.iloc[0, 0] == "19"
        assert table.frame["a"].iloc[0] == pytest.approx(8 / 19)
        precision = table.data[table.data["optimizer"] == "a"].set_index("budget / d")["precision"]
        assert precision.to_dict() == pytest.approx(
            {0.5: 10**1.8, 1.2: 10**1.6, 3.0: 10**1.4, 10.0: 10**1.2, 50.0: 10.0}
        )
