"""Figures: what each draws, on whose axes, and that no data or label can break one."""

import io
import itertools
import re
import warnings

import matplotlib
import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from bench import BenchError, analysis, plots
from bench.objective import Trace
from bench.plots import style
from bench.report import plots as report

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
GRID = np.array([1, 2, 5, 10, 20, 50, 99])


@pytest.fixture(autouse=True)
def quiet():
    """Draw as a report does, and let no warning through but of letters that the font lacks."""
    with warnings.catch_warnings(), style.context():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message="Glyph")
        yield


def trials(cells):
    """Return a tidy frame of {(problem, optimizer): values}; an infinite value is a failed trial."""
    rows = [
        {
            "problem": problem, "optimizer": optimizer, "trial": trial, "seed": trial, "nfev": 9,
            "status": "ok" if np.isfinite(value) else "failed", "fun": value if np.isfinite(value) else np.nan,
            "speed_rpm": 100 + value if np.isfinite(value) else np.nan,
        }
        for (problem, optimizer), values in cells.items()
        for trial, value in enumerate(values)
    ]  # fmt: skip
    return pd.DataFrame(rows)


def curves(problems, optimizers, median=10.0):
    level = np.where(GRID < 5, np.inf, median)
    parts = [
        pd.DataFrame(
            {"problem": p, "optimizer": o, "evaluations": GRID, "median": level, "q1": level - 1, "q3": level + 1}
        )
        for p in problems
        for o in optimizers
    ]
    return pd.concat(parts, ignore_index=True)


def times(problems, optimizers, unreached=()):
    rows = [
        (p, o, tau, 1.0, 3, 1, np.inf if o in unreached and tau < 0.05 else 10 / tau)
        for p in problems
        for o in optimizers
        for tau in (1.0, 0.5, 0.1, 0.01, 0.001)
    ]
    return pd.DataFrame(rows, columns=["problem", "optimizer", "tau", "target", "trials", "successes", "ert"])


def plateau(problems, optimizers):
    rows = [(p, o, 0.0, 3.0, 3, 3, 1.0) for p in problems for o in optimizers]
    return pd.DataFrame(rows, columns=["problem", "optimizer", "tau", "target", "trials", "successes", "ert"])


def fractions(optimizers, along="evaluations"):
    parts = [pd.DataFrame({"optimizer": o, along: GRID, "fraction": np.linspace(0, 1, len(GRID))}) for o in optimizers]
    return pd.concat(parts, ignore_index=True)


def improvements(optimizers):
    rows = [(a, b, 3, 0.6, 0.45, 0.7) for a, b in itertools.combinations(optimizers, 2)]
    return pd.DataFrame(rows, columns=["first", "second", "problems", "probability", "low", "high"])


def clock(optimizers):
    return pd.DataFrame({"optimizer": optimizers, "trials": 3, "wall_mean": 2.0, "objective_mean": 0.5})


def ranks_of(optimizers):
    return pd.Series(np.arange(1.0, len(optimizers) + 1), index=optimizers)


def axes():
    return Figure().subplots()


def svg(figure):
    file = io.BytesIO()
    FigureCanvasSVG(figure).print_svg(file, metadata={"Date": None})
    return file.getvalue().decode()


def texts(ax):
    return [text.get_text() for text in ax.texts if text.get_text()]


def every_figure(optimizers, problems=("p", "q")):
    frame = trials({(p, o): [1.0, 2.0, 4.0] for p in problems for o in optimizers})
    ranks = ranks_of(optimizers)
    return [
        report.distribution_figure(frame, problems[0], 0.5, {"speed_rpm": (101.0, 0.5)}),
        report.convergence_figure(curves(problems, optimizers), optimizers),
        report.regret_figure(curves(problems, optimizers), optimizers),
        report.ert_figure(times(problems, optimizers), optimizers),
        report.ecdf_figure(fractions(optimizers), fractions(optimizers, "groups"), optimizers, tau=0.01),
        report.rank_figure(ranks, [list(ranks.index)], 1.5),
        report.forest_figure(improvements(optimizers)),
        report.timing_figure(clock(optimizers)),
    ]


class TestEveryFigure:
    @pytest.mark.parametrize("optimizers", [["one"], ["a", "b", "c"], HOSTILE], ids=["one", "three", "hostile"])
    def test_is_drawn_in_a_width_of_the_page(self, optimizers):
        figures = every_figure(optimizers, ("p", "$q$ 日本" * 20))
        for each in figures:
            assert svg(each.figure).startswith("<?xml")
            assert each.figure.get_figwidth() in (style.COLUMN, style.TEXT)
            assert each.table.rows or optimizers == ["one"]
        assert len({each.name for each in figures}) == len(figures)

    def test_a_hundred_optimizers_fit_on_a_page(self):
        optimizers = [f"optimizer-{i}" for i in range(100)]
        for each in every_figure(optimizers, ("p",)):
            assert each.figure.get_figheight() < 10, each.name

    def test_no_text_is_smaller_than_a_journal_allows(self):
        for each in every_figure(["a", "b"]):
            sizes = [float(size) for size in re.findall(r"font(?:-size)?: ([0-9.]+)px", svg(each.figure))]
            assert min(sizes) >= 6.5
            assert max(sizes) <= 8.0

    def test_nothing_is_cut_off(self):
        optimizers = ["mealpy:AugmentedAEO", "W" * 24, "日本語" * 8]
        for each in every_figure(optimizers):
            box, size = each.figure.get_tightbbox(), each.figure.get_size_inches()
            assert box.x0 >= -0.01, each.name
            assert box.y0 >= -0.01, each.name
            assert box.x1 <= size[0] + 0.01, each.name
            assert box.y1 <= size[1] + 0.01, each.name

    def test_the_same_data_give_the_same_bytes(self):
        first, second = ([svg(each.figure) for each in every_figure(["a", "b"])] for _ in range(2))
        assert first == second

    def test_a_pdf_embeds_truetype_fonts(self):
        file = io.BytesIO()
        FigureCanvasPdf(report.timing_figure(clock(["a"])).figure).print_pdf(file)
        assert b"/FontFile2" in file.getvalue()
        assert b"/Type3" not in file.getvalue()

    def test_frames_without_rows(self):
        empty = [
            report.convergence_figure(curves(["p"], ["a"]).iloc[:0], ["a"]),
            report.regret_figure(curves(["p"], ["a"]).iloc[:0], ["a"]),
            report.ert_figure(times(["p"], ["a"]).iloc[:0], ["a"]),
            report.ecdf_figure(fractions(["a"]).iloc[:0], fractions(["a"]).iloc[:0], ["a"], tau=0.01),
            report.forest_figure(improvements(["a"])),
            report.timing_figure(clock([])),
            report.rank_figure(pd.Series(dtype=float), [], 1.0),
        ]
        for each in empty:
            svg(each.figure)
            assert each.table.rows == []

    def test_functions_draw_on_the_axes_given_or_on_new_ones(self):
        from matplotlib import pyplot

        frame, ranks = trials({("p", "a"): [1.0, 2.0]}), ranks_of(["a", "b"])
        draw = [
            lambda ax: plots.box_plot(frame, "p", ax=ax),
            lambda ax: plots.convergence(curves(["p"], ["a"]), "p", ax=ax),
            lambda ax: plots.regret(curves(["p"], ["a"]), "p", ax=ax),
            lambda ax: plots.ert(times(["p"], ["a"]), "p", ax=ax),
            lambda ax: plots.ecdf(fractions(["a"]), ax=ax),
            lambda ax: plots.data_profile(fractions(["a"], "groups"), ax=ax),
            lambda ax: plots.cd_diagram(ranks, ax=ax),
            lambda ax: plots.a12_forest(improvements(["a", "b"]), ax=ax),
            lambda ax: plots.timing(clock(["a"]), ax=ax),
        ]
        for function in draw:
            given = axes()
            assert function(given) is given
        with matplotlib.rc_context({"backend": "agg"}):
            for function in draw:
                assert isinstance(function(None), Axes)
            assert len(pyplot.get_fignums()) == len(draw)
            pyplot.close("all")


class TestBoxPlot:
    def test_boxes_are_quartiles_and_every_trial_is_a_point(self):
        values = np.array([1.0, 2.0, 3.0, 4.0, 100.0])
        ax = plots.box_plot(trials({("p", "a"): -values, ("q", "a"): [7.0]}), "p", ax=axes())
        (bar,) = ax.patches
        assert (bar.get_x(), bar.get_width()) == (-4.0, 2.0)
        assert sorted(ax.lines[0].get_xdata()) == sorted(-values)
        whisker, median = (lines.get_segments()[0] for lines in ax.collections if isinstance(lines, LineCollection))
        assert whisker[:, 0].tolist() == [-4.0, -1.0]
        assert median[:, 0].tolist() == [-3.0, -3.0]

    def test_what_is_not_drawn_is_said(self):
        frame = trials({("p", "good"): [1.0], ("p", "bad"): [np.inf, np.inf], ("p", "huge"): [1e300, 1.0]})
        frame["optimizer"] = pd.Categorical(frame["optimizer"], ["good", "bad", "huge", "none"])
        ax = plots.box_plot(frame, "p", ax=axes())
        assert {round(text.xy[1]): text.get_text() for text in ax.texts if text.get_text()} == {
            1: "2 failed", 2: "1 too large", 3: "no trial",
        }  # fmt: skip
        assert [len(line.get_xdata()) for line in ax.lines] == [1, 0, 1, 0]
        assert "2 missing" in texts(plots.box_plot(frame, "p", column="speed_rpm", ax=axes()))

    def test_truth_is_a_line_with_a_hatched_band(self):
        frame = trials({("p", "a"): [1.0, 2.0]})
        ax = plots.box_plot(frame, "p", column="speed_rpm", expected=101.5, tolerance=0.25, ax=axes())
        line, band = ax.lines[-1], ax.patches[-1]
        assert set(line.get_xdata()) == {101.5}
        assert (band.get_x(), band.get_width(), band.get_hatch()) == (101.25, 0.5, "/////")
        assert [text.get_text() for text in ax.get_legend().texts] == ["expected 101.5", "± 0.25"]

    @pytest.mark.parametrize(("optimum", "text"), [(0.0, "optimum 0 (off the axis)"), (0.5, "optimum 0.5")])
    def test_an_optimum_that_a_log_axis_cannot_show_is_said(self, optimum, text):
        ax = plots.box_plot(trials({("p", "a"): [1.0, 100.0]}), "p", optimum=optimum, ax=axes())
        assert ax.get_xscale() == "log"
        assert [each.get_text() for each in ax.get_legend().texts] == [text]

    @pytest.mark.parametrize(
        "values",
        [[5.0] * 3, [0.0] * 3, [-5.0, -5.0], [1.0, 1.0 + 1e-15], [1e-300, 1e99], [-1e308, 1e308], [np.inf], []],
    )
    def test_values_of_any_size(self, values):
        frame = trials({("p", "a"): values, ("q", "a"): [1.0]})
        frame["problem"] = pd.Categorical(frame["problem"], ["p", "q"])  # known, also without a trial
        svg(report.distribution_figure(frame, "p", 0.0, {"speed_rpm": (1.0, 1e-9)}).figure)

    @pytest.mark.parametrize(
        ("optimum", "expected", "said"),
        [
            (0.5, {}, "Line: the optimum. "), (None, {}, "is the median. Failed"),
            (None, {"speed_rpm": (101.0, 1.0)}, "Lines: the true values (hatched"),
            (0.5, {"speed_rpm": (101.0, 1.0)}, "Lines: the optimum and the true values (hatched"),
        ],
    )  # fmt: skip
    def test_the_caption_says_what_the_lines_are(self, optimum, expected, said):
        frame = trials({("p", "a"): [1.0, 2.0]})
        assert said in report.distribution_figure(frame, "p", optimum, expected).caption

    def test_a_panel_for_each_figure_whose_truth_is_known(self):
        frame = trials({("p", "a"): [1.0, 2.0]})
        wide = report.distribution_figure(frame, "p", None, {"speed_rpm": (1.0, 2.0), "unknown": (1.0, 1.0)})
        assert [ax.get_xlabel() for ax in wide.figure.axes] == ["objective value", "speed_rpm"]
        assert wide.figure.get_figwidth() == style.TEXT
        assert report.distribution_figure(frame, "p", None, {}).figure.get_figwidth() == style.COLUMN
        assert wide.data["speed_rpm"].tolist() == [101.0, 102.0]


class TestCurves:
    def test_an_infinite_median_is_not_drawn(self):
        ax = plots.convergence(curves(["p"], ["a", "b"]), "p", ax=axes())
        assert [line.get_xdata().tolist() for line in ax.lines] == [[5, 10, 20, 50, 99]] * 2
        assert ax.get_xscale() == "log"
        assert ax.get_yscale() == "linear"

    def test_wide_values_have_a_log_axis(self):
        wide = curves(["p"], ["a"]).assign(median=np.geomspace(1, 100, len(GRID)))
        assert plots.convergence(wide, "p", ax=axes()).get_yscale() == "log"
        assert plots.convergence(wide.assign(median=-wide["median"]), "p", ax=axes()).get_yscale() == "linear"

    def test_a_curve_of_regret_ends_at_the_optimum_and_its_band_at_what_is_drawn(self):
        above = curves(["p"], ["a", "b"]).assign(median=[*np.geomspace(8, 1e-9, 5), 0.0, 0.0, *np.full(7, 2.0)])
        above = above.assign(q1=0.0, q3=above["median"] + 1)
        ax = plots.regret(above, "p", ax=axes())
        assert [line.get_xdata().tolist() for line in ax.lines] == [GRID[:5].tolist(), GRID.tolist()]
        assert ax.get_yscale() == "log"
        assert 1e-11 < ax.get_ylim()[0] < 1e-9
        assert ax.collections[0].get_datalim(ax.transData).y0 == pytest.approx(1e-9)
        svg(ax.figure)

    def test_regret_of_none_but_trials_at_the_optimum_has_axes_all_the_same(self):
        ax = plots.regret(curves(["p"], ["a"]).assign(median=0.0, q1=0.0, q3=0.0), "p", ax=axes())
        svg(ax.figure)
        assert [len(line.get_xdata()) for line in ax.lines] == [0]

    def test_an_optimizer_looks_the_same_in_every_figure(self):
        every = report.convergence_figure(curves(["p"], ["b"]), ["a", "b"]).figure
        assert [line.get_color() for line in every.axes[0].lines if len(line.get_xdata())] == [style.PALETTE[1]]
        assert [text.get_text() for text in every.legends[0].texts] == ["a", "b"]

    def test_the_table_behind_them_holds_round_numbers(self):
        shown = report.convergence_figure(curves(["p", "q"], ["b", "a"]), ["b", "a"]).shown
        assert list(shown.columns) == ["b", "a"]
        assert shown.index.names == ["problem", "evaluations"]
        assert shown.loc["q"].index.tolist() == GRID.tolist()
        assert shown.loc[("q", 10), "a"] == 10.0
        many = report._at_round_numbers(curves(range(60), ["a"]), ["problem", "evaluations"], "median", (1, 2, 5))
        assert many.loc[3].index.tolist() == [1, 10, 99]

    def test_a_curve_ends_in_an_open_marker_where_targets_are_left(self):
        ax = plots.ert(times(["p"], ["a", "b"], unreached=["b"]), "p", ax=axes())
        full, short, end = ax.lines
        assert full.get_xdata().tolist() == [1.0, 0.5, 0.1, 0.01, 0.001]
        assert short.get_xdata().tolist() == [1.0, 0.5, 0.1]
        assert (end.get_xdata()[0], end.get_markerfacecolor()) == (0.1, "white")
        left, right = ax.get_xlim()
        assert left > 1.0 > 0.001 > right

    def test_a_problem_on_which_no_target_was_reached_has_axes_all_the_same(self):
        ax = plots.ert(times(["p"], ["a"]).assign(ert=np.inf), "p", ax=axes())
        svg(ax.figure)
        assert [len(line.get_xdata()) for line in ax.lines] == [0]

    @pytest.mark.parametrize(("plateaus", "others"), [("p", "q"), ("pr", "q"), ("p", ""), ("pr", "")])
    def test_a_plateau_has_an_empty_panel_and_a_row_in_the_table(self, plateaus, others):
        table = pd.concat([plateau(plateaus, ["a", "b"]), times(others, ["a", "b"]) if others else None])
        each = report.ert_figure(table, ["a", "b"])
        svg(each.figure)
        panels = {ax.get_title(loc="left"): ax for ax in each.figure.axes}
        assert list(panels) == [*plateaus, *others]
        for problem, ax in panels.items():
            assert [len(line.get_xdata()) for line in ax.lines] == ([0, 0] if problem in plateaus else [5, 5])
        assert len({ax.get_xlim() for ax in panels.values()}) == 1
        assert len({tuple(ax.get_xticks()) for ax in panels.values()}) == 1
        assert len(each.data) == len(table)
        assert all(each.shown.loc[(problem, 0.0), "a"] == 1.0 for problem in plateaus)
        assert all(each.shown.loc[problem].index.tolist() == [1.0, 0.1, 0.01, 0.001] for problem in others)
        assert "tau = 0" in each.caption

    def test_without_a_plateau_no_caption_speaks_of_one(self):
        assert "tau = 0" not in report.ert_figure(times("pq", ["a"]), ["a"]).caption

    @pytest.mark.parametrize(("plateaus", "others"), [("p", "q"), ("pr", "")])
    @pytest.mark.parametrize("budget", [1, 30])
    def test_every_curve_of_trials_on_a_plateau_and_of_any_budget(self, plateaus, others, budget):
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
            report.convergence_figure(analysis.convergence(frame, traces, grid), ["a", "b"]),
            report.ecdf_figure(analysis.ecdf(hits, grid), profile, ["a", "b"], tau=0.01),
            report.ert_figure(analysis.expected_running_time(hits), ["a", "b"]),
        ):
            svg(each.figure)
            drawn = [len(line.get_xdata()) for ax in each.figure.axes for line in ax.lines]
            assert any(drawn) != (each.name == "expected-running-time" and (budget == 1 or not others))

    def test_shares_go_from_none_to_all(self):
        ax = plots.data_profile(fractions(["a"], "groups"), ax=axes())
        assert ax.get_xlabel() == "groups of d + 1 evaluations"
        assert ax.get_ylim() == (-0.02, 1.02)
        shown = report.ecdf_figure(fractions(["a"]), fractions(["a"]), ["a"], tau=0.01)
        assert shown.data["panel"].value_counts().to_dict() == {"targets reached": 7, "data profile": 7}
        assert "tau = 0.01" in shown.caption


class TestRanks:
    def test_names_stand_by_their_rank_and_bars_join_cliques(self):
        ranks = pd.Series({"worst": 4.0, "best": 1.25, "good": 2.0, "fair": 2.75})
        ax = plots.cd_diagram(ranks, [["best", "good"], ["good", "fair"], ["worst"]], 1.0, ax=axes())
        assert texts(ax)[:4] == ["best  1.25", "good  2.00", "4.00  worst", "2.75  fair"]
        assert "CD = 1.00" in texts(ax)
        bars = [bar.get_segments()[0][:, 0] for bar in ax.collections]
        np.testing.assert_allclose(bars, [[1.25, 2.0], [2.0, 2.75]], atol=0.05)
        elbows = [line.get_xdata()[0] for line in ax.lines[:4]]
        assert elbows == [1.25, 2.0, 4.0, 2.75]
        assert [line.get_xdata()[1] - line.get_xdata()[0] for line in ax.lines[4:]] == [1.0]

    def test_a_missing_rank_is_left_out(self):
        ax = plots.cd_diagram(pd.Series({"a": 1.0, "b": np.nan}), [["a", "b"]], ax=axes())
        assert texts(ax) == ["a  1.00"]
        assert not ax.collections

    def test_of_too_many_the_best_and_the_worst_are_named(self):
        ax = plots.cd_diagram(ranks_of([f"o{i}" for i in range(100)]), ax=axes())
        assert texts(ax)[0] == "o0  1.00"
        assert "100.00  o99" in texts(ax)
        assert "40 more between these" in texts(ax)


class TestForest:
    pairs = pd.DataFrame(
        {"problem": ["p", "p", "q"], "first": ["a", "a", "a"], "second": ["b", "c", "b"], "a12": [0.9, 0.45, 0.5],
         "a12_low": [0.8, 0.3, 0.4], "a12_high": [1.0, 0.6, 0.6]}
    )  # fmt: skip

    def test_intervals_and_points(self):
        ax = plots.a12_forest(self.pairs, "p", ax=axes())
        assert [tick.get_text() for tick in ax.get_yticklabels()] == ["a vs b", "a vs c"]
        clear, open_ = ax.lines[-2:]
        assert (clear.get_xdata().tolist(), open_.get_xdata().tolist()) == ([0.9], [0.45])
        assert open_.get_markerfacecolor() == "white"
        np.testing.assert_allclose([s[:, 0] for s in ax.collections[-1].get_segments()], [[0.8, 1.0], [0.3, 0.6]])

    def test_a_missing_effect_keeps_its_row(self):
        pairs = self.pairs.assign(a12=np.nan, a12_low=np.nan, a12_high=np.nan)
        ax = plots.a12_forest(pairs, "p", ax=axes())
        svg(ax.figure)
        assert len(ax.get_yticklabels()) == 2


class TestTiming:
    def test_bars_are_split_and_unknown_times_said(self):
        table = clock(["a", "b"])
        table.loc[1, ["trials", "wall_mean", "objective_mean"]] = [0, np.nan, np.nan]
        ax = plots.timing(table, ax=axes())
        assert [bar.get_width() for bar in ax.patches] == [0.5, 0.0, 1.5, 0.0]
        assert texts(ax) == ["2", "none finished"]


class TestStyle:
    @pytest.mark.parametrize(("count", "length"), [(1, 3), (7, 3), (30, 20)])
    def test_a_legend_above_takes_the_height_it_says(self, count, length):
        texts = [f"{'x' * length}{i}" for i in range(count)]
        figure, (ax,) = style.grid(1, height=1.0, left=0.5, top=style.legend_height(texts))
        for text in texts:
            ax.plot([0, 1], [0, 1], label=text)
        style.legend_above(figure, ax.get_legend_handles_labels()[0])
        figure.draw_without_rendering()
        box = figure.legends[0].get_window_extent().transformed(figure.dpi_scale_trans.inverted())
        assert box.x1 <= style.TEXT
        assert box.y0 >= figure.get_figheight() - style.legend_height(texts)
        assert [text.get_text() for text in figure.legends[0].texts] == texts

    def test_long_labels_stay_apart(self):
        labels = [f"mealpy:Original{i:02d}Optimizer" for i in range(12)] + ["gwo", "x" * 500]
        names = style.names(labels, 20)
        assert len(set(names.values())) == len(labels)
        assert max(map(len, names.values())) <= 20
        assert names["gwo"] == "gwo"
        assert style.names(labels[3:5] + labels[:3] + labels[5:], 20) == names  # whatever their order

    def test_widths_are_measured(self):
        assert style.text_width([]) == 0.0
        assert style.text_width(["i"]) < style.text_width(["W"]) < style.text_width(["i", "WW"])
        assert style.text_width(["日" * 10], 8.0) >= 10 * 8 / 72

    def test_a_grid_has_the_margins_asked_for(self):
        figure, panels = style.grid(
            5, columns=3, width=6.0, height=1.0, left=0.5, right=0.25, bottom=0.4, top=0.3, across=0.2, down=0.1
        )
        np.testing.assert_allclose(figure.get_size_inches(), [6.0, 0.4 + 0.3 + 2 * 1.0 + 0.1])
        assert len(panels) == len(figure.axes) == 5
        boxes = [np.array(ax.get_position().extents) * np.tile(figure.get_size_inches(), 2) for ax in panels]
        np.testing.assert_allclose(boxes[0][[0, 3]], [0.5, 2.8 - 0.3])
        np.testing.assert_allclose(boxes[2][2], 6.0 - 0.25)
        np.testing.assert_allclose(boxes[3][1], 0.4)
        np.testing.assert_allclose(boxes[1][0] - boxes[0][2], 0.2)
        np.testing.assert_allclose(boxes[0][1] - boxes[3][3], 0.1)

    @pytest.mark.parametrize(
        ("limits", "wanted"), [((1, 60_000), "10,000"), ((1, 2e6), "1e4"), ((1e-8, 1), "1e-8"), ((0.01, 1), "0.01")]
    )
    def test_log_axes_have_plain_numbers(self, limits, wanted):
        ax = axes()
        ax.set_xlim(*limits)
        style.log_scale(ax, "x")
        ax.figure.draw_without_rendering()
        assert wanted in [tick.get_text() for tick in ax.get_xticklabels()]


@pytest.mark.parametrize("draw", [plots.box_plot, plots.convergence, plots.ert, plots.a12_forest])
def test_a_problem_that_is_not_there_is_refused_by_name(draw):
    frame = pd.DataFrame({"problem": ["sphere-2"], "optimizer": ["a"]})
    with pytest.raises(BenchError, match="no problem 'sphere-3' to draw; did you mean 'sphere-2'"):
        draw(frame, "sphere-3")
