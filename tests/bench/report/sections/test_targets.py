"""Targets in the sections: the usual ones, those asked for, running times and the order under three sets."""

import numpy as np
import pandas as pd
import pytest

from bench import BenchError, Results
from bench.report.findings import Findings
from bench.report.methods import methods
from bench.report.sections import anytime, datasets
from bench.report.target_words import default_targets, meaning, target_words
from bench.storage.results import ProblemFacts
from bench.study.targets import KINDS


@pytest.fixture(scope="module")
def folder(make, tmp_path_factory):
    """Return the folder of a study without optima: optimizers a, b and c find about 5, 6 and 7 on p and q."""
    return make(tmp_path_factory.mktemp("usual") / "s", trials=4)


def findings(folder, asked=None, expected=None, **optima):
    found = Findings(Results(folder), asked)
    if expected:
        found.results._facts = lambda label: ProblemFacts(expected=expected)
    found.trials.__dict__["optima"] = optima
    return found


class TestDefault:
    @pytest.mark.parametrize(
        ("known", "functions", "chosen"),
        [
            ({"p": ProblemFacts(0.0, features={"suite": "bbob-noisy"})}, [], "precisions"),
            ({"p": ProblemFacts(0.0, features={"suite": "bbob"}), "q": ProblemFacts(0.0)}, [], "relative"),
            ({"p": ProblemFacts(None, features={"suite": "cec2011"})}, [], "relative"),
            ({"p": ProblemFacts(1.0, features={"suite": "engineering"})}, [], "relative"),
            ({"p": ProblemFacts(0.0, features={"suite": "mine"})}, ["p"], "precisions"),
            ({"p": ProblemFacts(0.0)}, [], "relative"),
            ({}, [], "relative"),
        ],
    )
    def test_precisions_only_where_the_field_has_them(self, known, functions, chosen):
        assert default_targets(known, functions) == chosen

    def test_those_asked_for_come_before_the_study_s(self, folder):
        found = findings(folder)
        found.results.study = found.results.study.override(targets="quantiles")
        assert found.anytime.words.kind == "quantiles"
        again = findings(folder, [0.1])
        again.results.study = found.results.study
        assert again.anytime.words.chosen == [0.1]


class TestSections:
    @pytest.mark.sampled(3)
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
        section = anytime.section(found)
        names = [item.name for item in section.items]
        assert names.count("target-sets") == 1
        assert ("aocc" in names) == (found.anytime.words.kind == "precisions" and bool(found.trials.unbeaten))
        assert "nan" not in " ".join(section.text)
        assert datasets.section(found).sections
        assert methods(found).text

    def test_running_times_have_their_spread_and_seconds(self, folder):
        found = findings(folder, [5.0, 2.0, 1e-3], p=4.0, q=4.0)
        table = found.anytime.running_times
        spread = ["low", "high", "p10", "p90", "ert_per_d", "ert_s", "low_s", "high_s", "p10_s", "p90_s"]
        assert list(table) == ["problem", "optimizer", "precision", "trials", "successes", "ert", *spread]
        own = table[table["successes"] > 0]
        assert len(own)
        assert (own["low"] <= own["ert"]).all()
        assert (own["ert"] <= own["high"]).all()
        assert (own["ert_s"] > 0).all()

    def test_one_optimizer_is_not_ordered(self, make, tmp_path):
        found = findings(make(tmp_path / "s", optimizers=("a",), trials=1), "precisions", p=4.0)
        section = anytime.section(found)
        assert "choice" not in " ".join(section.text)
        assert "target-sets" not in [item.name for item in section.items]

    def test_failed_trials_alone_have_no_targets(self, make, tmp_path):
        folder = make(tmp_path / "s", fail=[(p, o) for p in "pq" for o in "abc"])
        found = findings(folder, "precisions")
        assert found.anytime.running_times.empty
        assert anytime.section(found).text

    def test_a_tolerance_needs_an_expected_metric(self, folder):
        with pytest.raises(BenchError, match="need a problem with an expected metric, and this study has none"):
            findings(folder, "tolerance").anytime.check_targets()


class TestOrder:
    @staticmethod
    def said(folder, **ranks):
        found = findings(folder)
        rows = [
            {"set": name, "problems": 2, "optimizer": label, "area": 0.5, "rank": rank}
            for name, own in ranks.items()
            for label, rank in zip("abc", own, strict=True)
        ]
        found.anytime.__dict__["target_sets"] = pd.DataFrame(rows)
        return " ".join(anytime._sets_agree(found))

    def test_the_choice_matters_or_not(self, folder):
        same = self.said(folder, x=[1, 2, 3], y=[1, 2, 3], z=[1, 2, 3])
        assert same == (
            "The choice of targets does not matter here: the order of the optimizers is the same under 3 sets of "
            "targets (x, y and z)."
        )
        assert "the first is the same, a, but the order of the others" in self.said(folder, x=[1, 2, 3], y=[1, 3, 2])
        other = self.said(folder, x=[1, 2, 3], y=[2, 1, 3], z=[1.5, 1.5, 3])
        assert (
            "matters: of 3 sets of targets (x, y and z), the first is a under x; b under y; a and b under z." in other
        )

    def test_where_nothing_can_be_compared_nothing_is_said(self, folder):
        assert self.said(folder, x=[1, 2, 3]) == ""
        assert self.said(folder, x=[np.nan] * 3, y=[1, 2, 3]) == ""


def test_every_set_is_explained():
    for chosen in (*KINDS, [1.0], [1.0, 0.1], ["5%"]):
        words = target_words(chosen)
        assert set(words.levels) >= {words.level}
        for known in ([True], [False], [True, False]):
            assert meaning(words, known).endswith(".")
