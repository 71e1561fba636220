"""The competition's table in a report; optimizers a, b and c find about 5, 6 and 7 on p and q."""

from bench.report.latex import to_latex
from bench.results.results import ProblemFacts
from bench.topics.findings import Findings
from bench.topics.units import section as units
from tests.bench.made import Known


def section(folder, subject=None, suite="cec2022", **optima):
    def facts(label):  # an instance of each function
        return ProblemFacts(optima.get(label), features={"suite": suite, "function": label} if suite else {})

    found = Findings(Known(folder, facts), asked_subject=subject)
    found.trials.__dict__["dimensions"] = dict.fromkeys(found.trials.problems, 10)
    return units.section(found)


def tables(section):
    return {item.name: item for item in section.items}


def test_signs_and_their_counts_are_beside_the_means(make, tmp_path):
    found = section(make(tmp_path / "s", trials=6), "b", p=1.0, q=1.0)
    table = tables(found)["competition"]
    assert table.typography.marks.loc["p"].to_dict() == {"a": "−", "b": "", "c": "+"}
    assert table.typography.texts.loc["+ / ≈ / −"].to_dict() == {"a": "0 / 0 / 2", "b": "", "c": "2 / 0 / 0"}
    assert table.typography.texts.loc["U-score"].to_dict() == {"a": "144.0", "b": "72.0", "c": "0.0"}
    assert table.typography.bold.loc["q"].to_dict() == {"a": True, "b": False, "c": False}
    assert not table.typography.bold.loc["U-score"].any()
    mean = table.data.set_index(["problem", "optimizer"])["mean"]
    assert table.typography.texts.at["p", "a"].startswith(f"{mean['p', 'a']:.2e} (")
    assert set(table.data["sign"].dropna()) == {"+", "-"}
    latex = to_latex(table, "competition")
    assert r"\textsuperscript{+}" in latex
    assert "0 / 0 / 2 & " in latex
    assert "\\midrule\n+ / " in latex


def test_checkpoints_are_those_of_the_suite(make, tmp_path):
    (file,) = section(make(tmp_path / "s"), p=1.0, q=1.0).files
    assert file.content.groupby(["problem", "optimizer"]).size().tolist() == [16] * 6
    assert not section(make(tmp_path / "t"), suite="cec2019", p=1.0).files
