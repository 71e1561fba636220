"""The whole report, from a study's folder to the page."""

from types import SimpleNamespace

import pytest

from bench import BenchError, Results
from bench.report import Section, write, write_report
from bench.report.findings import Findings
from bench.report.sections import anytime, comparison, integrity
from bench.storage.folder import Folder

PARTS = [
    "Verdict", "Integrity checks", "Comparison", "Across problems", "Convergence and targets", "Problem by problem",
    "Time", "Power", "Methods", "Environment, seeds and data", "Downloads",
]  # fmt: skip


def numbered(titles):
    return [f"{number} {title}" for number, title in enumerate(titles, 1)]


def patch_plugins(monkeypatch, **sections):
    plugins = SimpleNamespace(entries=lambda group: sections, load=lambda group, name: sections[name])
    monkeypatch.setattr(write, "registry", plugins)


@pytest.fixture(scope="module", autouse=True)
def _no_plugin_sections():
    with pytest.MonkeyPatch.context() as monkeypatch:
        patch_plugins(monkeypatch)
        yield


@pytest.fixture(scope="module")
def folder(make, tmp_path_factory):
    """Return the folder of a study that has its report, to be read only."""
    folder = make(tmp_path_factory.mktemp("usual") / "s")
    write_report(folder)
    return folder


@pytest.fixture(scope="module")
def usual(read, folder):
    """The page of this report."""
    return read(folder / "report.html")


def test_a_clear_winner_is_named_with_its_grounds(usual):
    assert "a is ranked first on 2 of 2 problems and separable from every rival on 2 of 2 (n = 8 trials" in usual.text
    assert "No single winner" not in usual.text


def test_the_eleven_parts_stand_in_their_order(usual):
    assert usual.texts("h2") == numbered(PARTS)


def test_the_page_stands_alone(usual):
    usual.check_that_it_stands_alone(("tables/", "figures/", "methods.", "references."))
    assert usual.tags.count("svg") == usual.tags.count("figure") == 8
    assert usual.tags.count("caption") == usual.tags.count("table")
    assert set(usual.values("scope")) == {"col", "row"}


def test_every_file_named_on_the_page_exists_and_no_other(usual, folder):
    linked = {href for href in usual.values("href") if not href.startswith("#")}
    assert {"methods.md", "methods.tex", "references.bib"} <= linked
    assert all((folder / href).is_file() for href in linked)
    linked = {href for href in linked if "/" in href}
    written = {str(path.relative_to(folder)) for kind in ("tables", "figures") for path in (folder / kind).iterdir()}
    assert linked == written
    assert {"tables/comparison.csv", "tables/comparison.tex", "figures/convergence.pdf", "tables/trials.csv"} <= written


def test_the_same_results_give_the_same_bytes(make, tmp_path):
    folder = make(tmp_path / "s", fail=[("p", "a", 0)])
    contents = []
    for _ in range(2):
        write_report(folder)
        files = [path for path in sorted(folder.rglob("*")) if path.is_file() and "sqlite" not in path.name]
        contents.append({path: path.read_bytes() for path in files})
    assert contents[0] == contents[1]


def test_no_single_winner_is_said(make, read, tmp_path):
    folder = make(tmp_path / "s", optimizers=("a", "b"), trials=3)
    page = read(write_report(folder))
    assert "No single winner: a is ranked first on 2 of 2" in page.text
    assert "with 3 trials in the smallest cell the test can find no difference at all" in page.text
    assert page.text.count("1 of 1 pair cannot be significant whatever the values") == 2


def test_failed_and_missing_trials_are_said(make, read, tmp_path):
    folder = make(tmp_path / "s", fail=[("p", "b"), ("q", "a", 1)], skip=[("q", "c"), ("p", "a", 7)])
    page = read(write_report(folder))
    assert "9 of 48 planned trials are missing and 1 of 6 cells are empty. Cells hold 0 to 8 trials" in page.text
    assert "fewer than others: a on p, c on q." in page.text
    assert "9 of 39 trials did not finish (failed 9), in b on p, a on q. They count as +inf." in page.text
    assert "No trial of c on this problem." in page.text
    assert "ValueError: <b>boom</b> & more" in page.text
    assert "Traceback" not in page.text


@pytest.mark.parametrize(
    "shape",
    [
        {"optimizers": ("a",)},
        {"optimizers": ("a",), "problems": ("p",), "trials": 1},
        {"trials": 1},
        {"problems": ("p",), "fail": [("p", "a"), ("p", "b"), ("p", "c")]},
        {"problems": ("p",), "skip": [("p", "a"), ("p", "b"), ("p", "c")]},
        {"skip": [("p", "a"), ("q", "b")]},
        {"skip": [("p", "a"), ("p", "b"), ("p", "c")]},
        {"optimizers": tuple(f"o{i}" for i in range(12)), "problems": ("p",)},
    ],
)
def test_every_partial_study_has_all_parts_too(make, read, tmp_path, shape):
    page = read(write_report(make(tmp_path / "s", **shape)))
    assert page.texts("h2") == numbered(PARTS)


def test_hostile_labels_are_only_text(make, read, tmp_path):
    problems = ("../../x", "<script>alert(1)</script>", "$\\frac{", 'a"b', "p:1/2")
    folder = make(tmp_path / "s", problems=problems, optimizers=("<img src=x onerror=y>", "a&b_%", "{{ 7*7 }}"))
    page = read(write_report(folder))
    assert "img" not in page.tags
    assert page.tags.count("script") == 1  # the page's own
    assert "<script>alert(1)</script>: every pair of optimizers." in page.text
    assert "{{ 7*7 }}" in page.text
    assert {path.name for path in tmp_path.iterdir()} == {"s"}
    assert len(list((folder / "tables").glob("tests-*.csv"))) == len(problems)


def test_a_plugins_sections_come_after_the_comparison(make, read, tmp_path, monkeypatch):
    patch_plugins(monkeypatch, mine=lambda results: [Section("Mine", (results.study.name,))])
    page = read(write_report(make(tmp_path / "s", problems=("p",), trials=2)))
    assert page.texts("h2") == numbered([*PARTS[:3], "Mine", *PARTS[3:]])
    assert "Mine made" in page.text


def test_a_plugin_that_fails_costs_only_its_own_section(make, read, tmp_path, monkeypatch):
    bad = {"boom": lambda results: 1 / 0, "none": lambda results: None, "texts": lambda results: ["no section"]}
    patch_plugins(monkeypatch, mine=lambda results: [Section("Mine")], **bad)
    page = read(write_report(make(tmp_path / "s", problems=("p",), trials=2)))
    added = ["Section boom", "Mine", "Section none", "Section texts"]
    assert page.texts("h2") == numbered([*PARTS[:3], *added, *PARTS[3:]])
    for name in bad:
        assert f"The report section '{name}' failed and is left out" in page.text
    assert "'mine'" not in page.text


def test_a_folder_without_results_is_refused(tmp_path):
    with pytest.raises(BenchError):
        write_report(tmp_path)


def test_a_busy_machine_is_flagged(make, read, tmp_path):
    waited = {"wall_s": 2.0, "cpu_s": 1.0, "nfev": 60, "stop": "undeclared"}
    page = read(write_report(make(tmp_path / "s", optimizers=("a", "b"), trials=4, changes={"a": waited})))
    assert "Trials of a waited for their core" in page.text
    assert "Undeclared stops: 8 of 16 trials" in page.text


class TestRegret:
    """Where an optimum is known; optimizers a, b and c find about 5, 6 and 7 on problems p and q."""

    @staticmethod
    def findings(folder, **optima):
        found = Findings(Results(folder))
        found.__dict__["optima"] = optima
        return found

    @staticmethod
    def names(section):
        return [item.name for item in section.items]

    def test_the_median_regret_stands_beside_the_medians(self, folder):
        found = self.findings(folder, p=4.0)
        told = comparison.section(found)
        table = told.items[1]
        assert self.names(told) == ["comparison", "regret"]
        assert table.frame.index.tolist() == ["p"]
        medians = found.summary.set_index(["problem", "optimizer"])["median"]
        assert table.frame.loc["p"].tolist() == [medians["p", each] - 4.0 for each in "abc"]
        assert table.data["optimum"].tolist() == [4.0] * 3
        assert "known on 1 problem; the median trial ends at it with no optimizer." in told.text[-1]
        assert "regret-curves" in self.names(anytime.section(found))

    def test_whose_median_trial_ends_at_the_optimum_is_said(self, make, tmp_path):
        always = {"a": {"fun": 3.0}, "b": {"fun": 3.0 + 1e-13}}
        told = comparison.section(self.findings(make(tmp_path / "s", changes=always), p=3.0, q=2.0))
        assert "known on 2 problems; the median trial ends at it with a on 1 and with b on 1." in told.text[-1]

    def test_failed_trials_are_marked_in_it(self, make, tmp_path):
        table = comparison.section(self.findings(make(tmp_path / "s", fail=[("p", "b")]), p=3.0, q=2.0)).items[1]
        assert [cell.lost for cell in table.rows[0]] == [False, False, True, False]
        assert table.rows[0][2].text == "∞"

    @pytest.mark.parametrize("optima", [{}, {"p": 6.5, "q": 6.5}])
    def test_there_is_none_without_an_optimum_or_with_one_that_was_beaten(self, folder, optima):
        found = self.findings(folder, **optima)
        assert self.names(comparison.section(found)) == ["comparison"]
        assert "regret-curves" not in self.names(anytime.section(found))
        assert "Targets fall from tau = 1 to 0.001." in " ".join(anytime.section(found).text)

    @pytest.mark.parametrize(
        ("optima", "said"),
        [
            (
                {"p": 1.0, "q": 1.0},
                "f_L is the known optimum (Moré and Wild 2009). Targets fall from tau = 1 to 1e-08.",
            ),
            ({"p": 1.0}, "Targets fall from tau = 1 to 1e-08 where the optimum is known, else to 0.001."),
        ],
    )
    def test_how_far_the_targets_fall_is_said(self, folder, optima, said):
        assert said in " ".join(anytime.section(self.findings(folder, **optima)).text)


def test_the_biases_that_a_check_noted_are_warned_of(make, tmp_path):
    def noted(check, passed, figure):
        return {"check": check, "passed": passed, "figure": figure}

    folder = make(tmp_path / "s")
    biased = [
        noted("centre bias", False, 4e5),
        noted("structural bias", False, 5e-10),
        noted("starts and seeds", True, None),
    ]
    sound = [
        noted("centre bias", True, 0.9),
        noted("structural bias", True, 0.4),
        noted("boundary clamping", True, 0.0),
    ]
    Folder(folder).note_checks({"a": biased, "b": sound})
    findings = Findings(Results(folder))
    told = integrity.section(findings)
    assert [warning.partition(":")[0] for warning in told.warnings[:2]] == ["Centre bias", "Structural bias"]
    assert "not uniform in the box: a p = 5e-10." in told.warnings[1]
    verdicts = findings.integrity.set_index("check")["verdict"]
    assert set(verdicts[["boundary clamping", "starts and seeds"]]) == {"pass"}
    paragraph = findings.methods.text[0]
    assert "We probed a and b for a bias to the centre of the search space (Kudela, 2022): a has it." in paragraph
    assert "We probed a and b for structural bias" in paragraph
