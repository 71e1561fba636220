"""The picture of the evidence: the trials where they fit, the leader against each rival elsewhere."""

import pandas as pd
import pytest

from bench import Results, Study
from bench.plots import style
from bench.report.page import inline
from bench.topics.findings import Findings
from bench.topics.verdict.first_picture import evidence, leader_figure, shows_trials, trials_figure
from tests.bench.plots.frames import strict, svg, trials
from tests.bench.reports import ended, store


@pytest.fixture(autouse=True)
def strictly():
    with strict():
        yield


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("problems", "optimizers", "picture"),
    [(1, 3, "every-trial"), (6, 3, "every-trial"), (7, 3, "leader-against-each"), (12, 2, "every-trial"),
     (13, 2, "leader-against-each"), (2, 11, "leader-against-each")],
)  # fmt: skip
def test_trials_are_shown_of_few_problems_or_of_two_optimizers(make, tmp_path, problems, optimizers, picture):
    labels = (tuple(f"{kind}{i}" for i in range(number)) for kind, number in (("p", problems), ("o", optimizers)))
    findings = Findings(Results(make(tmp_path / "s", *labels, trials=2)))
    assert evidence(findings, clear=False).name == picture
    assert shows_trials(findings) == (picture == "every-trial")


def across(probability):
    """Return three pairs of a, b and c, of which a and b end lower than c with this probability."""
    rows = [("b", "a", 0.4, False), ("a", "c", probability, True), ("b", "c", probability, True)]
    tests = pd.DataFrame(rows, columns=["first", "second", "probability", "significant"])
    for prefix in ("", "joint_"):
        tests = tests.assign(
            **{f"{prefix}low": tests["probability"] - 0.1, f"{prefix}high": tests["probability"] + 0.2}
        )
    return tests


def test_the_leader_is_drawn_against_each_rival_and_filled_where_a_test_shows_it():
    figure = leader_figure(across(0.7), ["a", "b", "c"], clear=False)
    assert figure.data[["second", "significant"]].to_numpy().tolist() == [["b", False], ["c", True]]
    assert [text.get_text() for text in figure.figure.axes[0].get_yticklabels()] == ["b", "c"]
    assert leader_figure(across(0.7), ["a", "b", "c"], clear=True).data["significant"].all()


def drawn(cells, solved=()):
    frame = trials(cells)
    problems = list(dict.fromkeys(frame["problem"]))
    return trials_figure(
        frame, problems, dict.fromkeys(problems, 0.5), set(solved), style.pens(frame["optimizer"].unique())
    )


def test_every_trial_is_a_point_and_failed_ones_are_counted():
    figure = drawn({("p", "a"): [1.0, 2.0, float("inf")], ("p", "b"): [3.0], ("q", "a"): [4.0], ("q", "b"): [5.0, 6.0]})
    panels = figure.figure.axes
    assert [ax.get_title(loc="left") for ax in panels] == ["p", "q"]
    points = [[line for line in ax.lines if line.get_marker() in style.MARKERS] for ax in panels]
    assert [sum(len(line.get_xdata()) for line in lines) for lines in points] == [3, 3]
    assert panels[0].texts[0].get_text() == "1 failed"
    assert len(figure.data) == 7
    assert figure.shown.loc[("p", "b"), "median"] == 3.0
    svg(figure.figure)


@pytest.mark.parametrize("count", [1, 2, 4, 5, 6, 12])
def test_the_picture_is_as_wide_as_a_page_and_no_text_is_cut(count):
    figure = drawn({(f"problem-{i}", name): [1.0, 20.0, 1e6] for i in range(count) for name in ("a", "random-search")})
    width, height = figure.figure.get_size_inches()
    box = figure.figure.get_tightbbox()
    assert width in (style.COLUMN, style.PAGE)
    assert height < 4
    assert (box.x0 >= -0.01, box.y0 >= -0.01, box.x1 <= width + 0.01, box.y1 <= height + 0.01) == (True,) * 4


def test_precisions_are_drawn_from_the_solved_one_on():
    figure = drawn({("p", "a"): [0.0, 1e-3]}, solved="p")
    assert figure.figure.axes[0].lines[0].get_xdata().min() == 1e-8
    assert "those below 1e-08 are drawn there" in figure.caption
    assert "Line: the optimum" not in figure.caption


def test_a_page_draws_in_its_own_ink_and_the_files_keep_theirs():
    text = svg(drawn({("p", "a"): [1.0, 2.0]}).figure)
    shown = str(inline(text, "f", "A figure."))
    for old, new in (("#000000", "currentColor"), ("#ffffff", "var(--page)"), ("#dddddd", "var(--grid)")):
        assert old in text
        assert old not in shown
        assert new in shown


def test_the_data_are_those_of_the_drawn_problems():
    frame = trials({("p", "a"): [1.0], ("q", "a"): [2.0]})
    figure = trials_figure(frame, ["q"], {}, set(), style.pens(["a"]))
    pd.testing.assert_series_equal(figure.data["fun"].reset_index(drop=True), pd.Series([2.0], name="fun"))


@pytest.mark.parametrize(("targets", "least", "scale"), [("precisions", 0.5, "log"), ("relative", 400.5, "linear")])
def test_errors_of_a_suite_with_a_known_optimum_are_drawn_on_a_log_axis(tmp_path, targets, least, scale):
    """Values of 400.5 to 3,400 above an optimum of 400 would crowd together on a linear axis."""
    ends = {"gwo": 400.5, "random-search": 3_400.0}
    table = {"name": "s", "trials": 2, "budget": 100, "problems": ["cec2022-f02-d10"], "optimizers": [*ends]}
    study = Study.from_dict(table | {"targets": targets})
    store(tmp_path / "s", study, lambda trial: ended(ends[trial.optimizer] + trial.number))
    picture = evidence(Findings(Results(tmp_path / "s")), clear=False)
    (ax,) = picture.figure.axes
    points = [value for line in ax.lines if line.get_marker() in style.MARKERS for value in line.get_xdata()]
    assert min(points) == pytest.approx(least)
    assert ax.get_xscale() == scale
