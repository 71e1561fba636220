"""The figures of a report: sizes, captions, data, and that no data or label can break one."""

import io
import re

import numpy as np
import pandas as pd
import pytest
from matplotlib.backends.backend_pdf import FigureCanvasPdf

from bench import analysis
from bench.objective import Trace
from bench.plots import style
from bench.topics.anytime.figures import convergence_figure, ecdf_figure, ert_figure, figures_apart, regret_figure
from bench.topics.datasets.figures import distribution_figure
from bench.topics.figures import at_round_numbers
from bench.topics.findings import BEST
from bench.topics.ranks.figures import forest_figure
from bench.topics.suite.figures import reached_figure, scatter_figure
from tests.bench.plots.frames import (
    GRID,
    curves,
    fractions,
    improvements,
    strict,
    svg,
    times,
    trials,
)

HOSTILE = [
    "$a_1$ \\frac{",
    "bell\x07\nline",
    "日本語" * 9,
    "x" * 500,
    "x" * 499 + "y",
    "<b>&amp;",
    "a $ b",
    "evaluations",
]


@pytest.fixture(autouse=True)
def strictly():
    with strict():
        yield


def every_figure(optimizers, problems=("p", "q")):
    frame = trials({(p, o): [1.0, 2.0, 4.0] for p in problems for o in optimizers})
    shares = fractions([*optimizers, BEST]).rename(columns={"evaluations": "per_dimension"})
    reached = pd.concat([shares.assign(problem=f"{each}, d = 2") for each in problems])
    ends = {f"{each}, d = 2": dict.fromkeys(optimizers, 10.0) for each in problems}
    erts = pd.DataFrame(
        {"problem": "p", "kind": "d = 2", optimizers[0]: [1.0, np.inf, 8.0], "another": [2.0, 3.0, np.inf]}
    )
    return [
        distribution_figure(frame, problems[0], 0.5, {"speed_rpm": (101.0, 0.5)}),
        convergence_figure(curves(problems, optimizers), optimizers),
        regret_figure(curves(problems, optimizers), optimizers),
        ert_figure(times(problems, optimizers), optimizers),
        ecdf_figure(fractions(optimizers), fractions(optimizers, "groups"), optimizers, target="tau = 0.01"),
        reached_figure("targets", reached, optimizers, ends=ends),
        reached_figure("targets-of-all", reached, optimizers, ends=ends, columns=2),
        scatter_figure(erts, optimizers[0], "another"),
        forest_figure(improvements(optimizers)),
    ]


class TestApart:
    """Problems p and q of function f, whose optimum is known, and r of g."""

    def test_each_function_has_a_figure_of_its_regret_or_else_of_its_values(self):
        shown = [convergence_figure(curves(["p", "q", "r"], "ab"), "ab"), regret_figure(curves(["p", "q"], "ab"), "ab")]
        of_f, of_g = figures_apart(shown, {"p": "f", "q": "f", "r": "g"}, "ab")
        assert [each.name for each in (of_f, of_g)] == ["convergence-f", "convergence-g"]
        assert [ax.get_ylabel() for ax in of_f.figure.axes] == ["regret", ""]
        assert [ax.get_ylabel() for ax in of_g.figure.axes] == ["best value so far"]
        assert set(of_f.data["problem"]) == {"p", "q"}
        assert "Convergence on g: the median best objective value over evaluations" in of_g.caption

    def test_the_only_function_has_none(self):
        shown = [convergence_figure(curves(["p", "q"], "ab"), "ab")]
        assert figures_apart(shown, {"p": "f", "q": "f"}, "ab") == []


class TestEveryFigure:
    @pytest.mark.sampled(1)
    @pytest.mark.parametrize("optimizers", [["one"], ["a", "b", "c"], HOSTILE], ids=["one", "three", "hostile"])
    def test_is_drawn_in_a_width_of_the_page(self, optimizers):
        figures = every_figure(optimizers, ("p", "$q$ 日本" * 20))
        for each in figures:
            assert svg(each.figure).startswith("<?xml")
            assert each.figure.get_figwidth() in (style.COLUMN, style.PAGE)
            assert each.table.rows or optimizers == ["one"]
        assert len({each.name for each in figures}) == len(figures)

    @pytest.mark.slow
    def test_a_hundred_optimizers_fit_on_a_page(self):
        optimizers = [f"optimizer-{i}" for i in range(100)]
        for each in every_figure(optimizers, ("p",)):
            assert each.figure.get_figheight() < 10, each.name

    def test_no_text_is_smaller_than_a_journal_allows(self):
        for each in every_figure(["a", "b"]):
            sizes = [float(size) for size in re.findall(r"font(?:-size)?: ([0-9.]+)px", svg(each.figure))]
            assert min(sizes) >= 6.5
            assert max(sizes) <= 8.0

    @pytest.mark.slow
    def test_nothing_is_cut_off(self):
        optimizers = ["mealpy:AugmentedAEO", "W" * 24, "日本語" * 8]
        for each in every_figure(optimizers):
            box, size = each.figure.get_tightbbox(), each.figure.get_size_inches()
            assert box.x0 >= -0.01, each.name
            assert box.y0 >= -0.01, each.name
            assert box.x1 <= size[0] + 0.01, each.name
            assert box.y1 <= size[1] + 0.01, each.name

    @pytest.mark.slow
    def test_the_same_data_give_the_same_bytes(self):
        first, second = ([svg(each.figure) for each in every_figure(["a", "b"])] for _ in range(2))
        assert first == second

    def test_a_pdf_embeds_truetype_fonts(self):
        file = io.BytesIO()
        FigureCanvasPdf(forest_figure(improvements(["a", "b"])).figure).print_pdf(file)
        assert b"/FontFile2" in file.getvalue()
        assert b"/Type3" not in file.getvalue()

    def test_frames_without_rows(self):
        empty = [
            convergence_figure(curves(["p"], ["a"]).iloc[:0], ["a"]),
            regret_figure(curves(["p"], ["a"]).iloc[:0], ["a"]),
            ert_figure(times(["p"], ["a"]).iloc[:0], ["a"]),
            ecdf_figure(fractions(["a"]).iloc[:0], fractions(["a"]).iloc[:0], ["a"], target="tau = 0.01"),
            forest_figure(improvements(["a"])),
        ]
        for each in empty:
            svg(each.figure)
            assert each.table.rows == []


@pytest.mark.parametrize(
    "values",
    [[5.0] * 3, [0.0] * 3, [-5.0, -5.0], [1.0, 1.0 + 1e-15], [1e-300, 1e99], [-1e308, 1e308], [np.inf], []],
)
def test_values_of_any_size(values):
    frame = trials({("p", "a"): values, ("q", "a"): [1.0]})
    frame["problem"] = pd.Categorical(frame["problem"], ["p", "q"])  # known, also without a trial
    svg(distribution_figure(frame, "p", 0.0, {"speed_rpm": (1.0, 1e-9)}).figure)


def test_a_panel_for_each_figure_whose_truth_is_known():
    frame = trials({("p", "a"): [1.0, 2.0]})
    wide = distribution_figure(frame, "p", None, {"speed_rpm": (1.0, 2.0), "unknown": (1.0, 1.0)})
    assert [ax.get_xlabel() for ax in wide.figure.axes] == ["objective value", "speed_rpm"]
    assert wide.figure.get_figwidth() == style.PAGE
    assert distribution_figure(frame, "p", None, {}).figure.get_figwidth() == style.COLUMN
    assert wide.data["speed_rpm"].tolist() == [101.0, 102.0]


def test_an_optimizer_looks_the_same_in_every_figure():
    every = convergence_figure(curves(["p"], ["b"]), ["a", "b"]).figure
    assert [line.get_color() for line in every.axes[0].lines if len(line.get_xdata())] == [
        style.pens(["a", "b"])["b"].color
    ]
    assert [text.get_text() for text in every.legends[0].texts] == ["a", "b"]


def test_the_table_behind_them_holds_round_numbers():
    shown = convergence_figure(curves(["p", "q"], ["b", "a"]), ["b", "a"]).shown
    assert list(shown.columns) == ["b", "a"]
    assert shown.index.names == ["problem", "evaluations"]
    assert shown.loc["q"].index.tolist() == GRID.tolist()
    assert shown.loc[("q", 10), "a"] == 10.0
    many = at_round_numbers(curves(range(60), ["a"]), ["problem", "evaluations"], "median", (1, 2, 5))
    assert many.loc[3].index.tolist() == [1, 10, 99]


@pytest.mark.parametrize(("plateaus", "others"), [("p", "q"), ("pr", "")])
@pytest.mark.parametrize("budget", [1, 30])
def test_every_curve_of_trials_on_a_plateau_and_of_any_budget(plateaus, others, budget):
    falling = Trace(np.array([1, 5, 20])[: min(budget, 3)], np.array([9.0, 4.0, 1.0])[: min(budget, 3)])
    level = Trace(np.array([1]), np.array([3.0]))
    traces = {
        (problem, optimizer, trial): level if problem in plateaus else falling
        for problem in plateaus + others for optimizer in "ab" for trial in range(2)
    }  # fmt: skip
    frame = pd.DataFrame([*traces], columns=["problem", "optimizer", "trial"]).assign(status="ok", nfev=budget)
    hits = analysis.hitting_times(frame, traces, analysis.targets(traces), budget)
    grid = analysis.evaluation_grid(budget)
    profile = analysis.data_profiles(hits, 0.01, analysis.evaluation_grid(1), dict.fromkeys("pqr", 2))
    for each in (
        convergence_figure(analysis.convergence(frame, traces, grid), ["a", "b"]),
        ecdf_figure(analysis.ecdf(hits, grid), profile, ["a", "b"], target="tau = 0.01"),
        ert_figure(analysis.expected_running_time(hits), ["a", "b"]),
    ):
        svg(each.figure)
        drawn = [len(line.get_xdata()) for ax in each.figure.axes for line in ax.lines]
        assert any(drawn) != (each.name == "expected-running-time" and (budget == 1 or not others))


def test_the_data_of_both_panels_of_targets_reached_are_kept():
    shown = ecdf_figure(fractions(["a"]), fractions(["a"]), ["a"], target="tau = 0.01")
    assert shown.data["panel"].value_counts().to_dict() == {"targets reached": 7, "data profile": 7}
    assert "tau = 0.01" in shown.caption
