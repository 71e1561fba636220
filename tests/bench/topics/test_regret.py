"""Regret in the sections, where an optimum is known; optimizers a, b and c find about 5, 6 and 7 on p and q."""

import pytest

from bench import Results
from bench.topics.anytime import section as anytime
from bench.topics.comparison import section as comparison
from bench.topics.findings import Findings


@pytest.fixture(scope="module")
def folder(make, tmp_path_factory):
    """Return the folder of a study without optima, to be read only."""
    return make(tmp_path_factory.mktemp("usual") / "s")


class TestRegret:
    @staticmethod
    def findings(folder, **optima):
        found = Findings(Results(folder))
        found.trials.__dict__["optima"] = optima
        return found

    @staticmethod
    def names(section):
        return [item.name for item in section.items]

    def test_the_median_regret_stands_beside_the_medians(self, folder):
        found = self.findings(folder, p=4.0)
        shown = comparison.section(found)
        table = shown.items[1]
        assert self.names(shown) == ["comparison", "regret"]
        assert table.frame.index.tolist() == ["p"]
        medians = found.final.summary.set_index(["problem", "optimizer"])["median"]
        assert table.frame.loc["p"].tolist() == [medians["p", each] - 4.0 for each in "abc"]
        assert table.data["optimum"].tolist() == [4.0] * 3
        assert "The optimum is known on 1 problem. No optimizer’s median trial reached it." in shown.text[-1]
        *_, each = anytime.section(found).sections
        assert "regret-curves" in self.names(each)

    def test_whose_median_trial_ends_at_the_optimum_is_said(self, make, tmp_path):
        always = {"a": {"fun": 3.0}, "b": {"fun": 3.0 + 1e-13}}
        shown = comparison.section(self.findings(make(tmp_path / "s", changes=always), p=3.0, q=2.0))
        assert "known on 2 problems. The median trial reached it on 1 with a and on 1 with b." in shown.text[-1]

    def test_failed_trials_are_marked_in_it(self, make, tmp_path):
        table = comparison.section(self.findings(make(tmp_path / "s", fail=[("p", "b")]), p=3.0, q=2.0)).items[1]
        assert [cell.lost for cell in table.rows[0]] == [False, False, True, False]
        assert table.rows[0][2].text == "∞"

    @pytest.mark.slow
    @pytest.mark.parametrize("optima", [{}, {"p": 6.5, "q": 6.5}])
    def test_there_is_none_without_an_optimum_or_with_one_that_was_beaten(self, folder, optima):
        found = self.findings(folder, **optima)
        assert self.names(comparison.section(found)) == ["comparison"]
        assert "regret-curves" not in self.names(anytime.section(found))
        assert "Targets fall from tau = 1 to 0.001." in " ".join(anytime.section(found).text)
