"""Fig. 7.4: the amplitude each trial found beside the expected one, and the conclusions from it (section 7.2.3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from scipy.stats import binomtest, spearmanr

from bench import Study
from bench.analysis import ALPHA, labels
from bench.plots import style
from bench.report import Figure, Section, Table, leaders, listing
from problems.backlash.report.accuracy import (
    SAY,
    dataset_panels,
    errors_by,
    estimates,
    expected_by_problem,
    shares_within,
    signed_and_size,
    with_truth,
)
from problems.backlash.report.fitting_errors import EXTRA, SWARMS, algorithms, other_conditions
from problems.backlash.signature.problem import TOLERANCE_RPM

REFERENCES = ("expected amplitude", "accuracy band")
LEGEND = {"dots": ("trial", *REFERENCES), "boxes": ("median", "beyond the whiskers", *REFERENCES)}
BAND = f"±{TOLERANCE_RPM:.4f} rpm"
FEWEST = 4  # datasets; of three, even a perfect rank correlation has p = 1/6


def sections(frame: pd.DataFrame, truths: pd.DataFrame, study: Study) -> list[Section]:
    """Return the section on amplitudes, with figures only where no expected amplitude is known."""
    title = "Disturbance amplitude (thesis Fig. 7.4)"
    data = estimates(frame, truths, "amplitude_rpm")
    if data.empty:
        return [Section(title, ("No trial found an amplitude.",))]
    errors = errors_by(data, ["problem", "optimizer"])
    figures = [figure(data, errors, form) for form in ("dots", "boxes")]
    if errors.empty:
        text = ("No expected amplitude is known for these problems, so there is no error to give.",)
        return [Section(title, text, tuple(figures))]
    return [Section(title, sentences(data, study), (*figures, *_tables(data, errors)))]


def _tables(data: pd.DataFrame, cells: pd.DataFrame) -> list[Table]:
    overall = Table(
        "amplitude-errors",
        f"Amplitude error in rpm (found less expected), and the percentage of trials within {BAND}.",
        errors_by(data, ["optimizer"]),
        decimals={"mean error": 2, "median error": 2, "median |error|": 2, "within band %": 1},
        note="Errors are over finished trials, the percentage is over all; a failed trial is not within the band.",
    )
    captions = {
        "within band %": (f"percentage of trials within {BAND}", 0),
        "median |error|": ("median size of the amplitude error in rpm", 2),
        "median error": ("median amplitude error in rpm", 2),
        "mean error": ("mean amplitude error in rpm", 2),
    }
    by_dataset = [
        Table(
            f"amplitude-{column.removesuffix(' %').replace(' ', '-').replace('|error|', 'size')}-by-dataset",
            f"By dataset: {caption}.",
            cells[column].unstack("optimizer").rename_axis(columns=None),
            decimals=decimals,
        )
        for column, (caption, decimals) in captions.items()
    ]
    return [overall, *by_dataset]


def figure(data: pd.DataFrame, errors: pd.DataFrame, form: str) -> Figure:
    """Return Fig. 7.4 as "dots" (its upper part) or "boxes" (its lower one), a panel an optimizer."""
    problems, optimizers = labels(data, "problem"), labels(data, "optimizer")
    drawn, axes = dataset_panels(optimizers, problems, list(LEGEND[form]), columns=3, height=1.4)
    truth = expected_by_problem(data)
    amplitudes = data[data["found"].notna()]
    for ax, optimizer in zip(axes, optimizers, strict=True):
        trials = amplitudes[amplitudes["optimizer"] == optimizer]
        (_dots if form == "dots" else _boxes)(ax, trials["problem"].cat.codes.to_numpy(), trials["found"].to_numpy())
        _expected(ax, truth)
    for ax in axes[::3]:
        ax.set_ylabel("|A| in rpm")
    handles = {str(handle.get_label()): handle for ax in axes for handle in ax.get_legend_handles_labels()[0]}
    style.legend_above(drawn, list(handles.values()))
    what = "every trial a dot" if form == "dots" else "box plots (whiskers: 1.5 times the interquartile range)"
    caption = (
        f"Disturbance amplitude found, by dataset: {what}. Line: the expected amplitude; dotted: the accuracy band of "
        f"{BAND} (thesis Fig. 7.4)."
    )
    return Figure(f"amplitude-{form}", caption, drawn, data, errors.reset_index() if len(errors) else None)


def _dots(ax: Axes, at: np.ndarray, values: np.ndarray) -> None:
    ax.plot(
        at, values, "o", color=style.PALETTE[0], markersize=2, markeredgewidth=0, alpha=0.6,
        rasterized=len(at) > style.MANY_POINTS, label=LEGEND["dots"][0],
    )  # fmt: skip


def _boxes(ax: Axes, at: np.ndarray, values: np.ndarray) -> None:
    """Draw Tukey's box plots."""
    places = np.unique(at)
    ax.use_sticky_edges = False  # the end of a box is no limit of the axis
    thin, line = {"linewidth": 0.6}, {"color": style.PALETTE[0], "linewidth": 1.2}
    beyond = {"marker": "o", "markersize": 2, "markeredgewidth": 0.4}
    drawn = ax.boxplot(
        [values[at == place] for place in places], positions=places, widths=0.6, manage_ticks=False, boxprops=thin,
        whiskerprops=thin, capprops=thin, medianprops=line, flierprops=beyond,
    )  # fmt: skip
    for kind, label in (("medians", LEGEND["boxes"][0]), ("fliers", LEGEND["boxes"][1])):
        for artist in drawn[kind][:1]:
            artist.set_label(label)


def _expected(ax: Axes, truth: pd.DataFrame) -> None:
    at, expected, tolerance = np.arange(len(truth)), truth["expected"], truth["tolerance"]
    if expected.isna().all():
        return
    ax.plot(at, expected, "-", color=style.REFERENCE, linewidth=0.8, label=REFERENCES[0])
    for sign, label in ((-1, REFERENCES[1]), (1, None)):
        ax.plot(at, expected + sign * tolerance, ":", color=style.REFERENCE, linewidth=0.8, label=label)


def sentences(data: pd.DataFrame, study: Study) -> tuple[str, ...]:
    """Return the shares within the accuracy band, and each conclusion of the thesis beside what was found here.

    Args:
        data: from :func:`problems.backlash.report.accuracy.estimates`, of the amplitude.
        study: its optimizers that the thesis has, too, are compared; a conclusion on others is left out.
    """
    label_of = algorithms(study)
    swarms = data[data["optimizer"].isin([label_of[name] for name in SWARMS if name in label_of])]
    swarms = swarms.assign(optimizer=swarms["optimizer"].cat.remove_unused_categories())
    band = f"{BAND} about the expected amplitude (half of Delta A of section 7.2.3)"
    text = (
        f"{shares_within(data)} are within the accuracy band of {band}.",
        _most_accurate(data, label_of, study),
        signed_and_size(data, " rpm"),
        _underestimates(swarms),
        _widens(data),
        _narrowest(swarms, label_of),
    )
    return tuple(filter(None, text))


def _most_accurate(data: pd.DataFrame, label_of: dict[str, str], study: Study) -> str:
    """Return the algorithms with most and fewest trials within the band, if all of the thesis's have trials.

    A claim is neither supported nor contradicted where Wilson's intervals of the shares overlap.
    """
    if not {*SWARMS, EXTRA} <= set(label_of):
        return ""
    compared = [label_of[name] for name in (*SWARMS, EXTRA)]
    groups = with_truth(data).groupby("optimizer", observed=True)["within"]
    counts = groups.agg(["sum", "size"]).reindex(compared)
    if counts.isna().any(axis=None):
        return ""
    shares = {
        str(label): (hits / trials, *binomtest(int(hits), int(trials)).proportion_ci(method="wilson"))
        for label, hits, trials in counts.itertuples(name=None)
    }
    swarms = [label_of[name] for name in SWARMS]
    claims = {
        "CMA-ES the most suited": _above(shares, label_of[EXTRA], swarms),
        "GWO the best of the swarms": _above(shares, label_of["gwo"], swarms),
        "DA the least effective": _below(shares, label_of["da"], swarms),
    }
    verdicts = {1: "agree", -1: "disagree", 0: "are too close to decide"}
    parts = [
        f"{listing(alike)}, and these shares {text}"
        for verdict, text in verdicts.items()
        if (alike := [claim for claim, outcome in claims.items() if outcome == verdict])
    ]
    found = f"The thesis finds {'; it also finds '.join(parts)} (by 95% Wilson intervals)."
    return f"{found} {other_conditions(study)}".strip()


Share = tuple[float, float, float]  # of trials within the band, with its interval


def _above(shares: Mapping[str, Share], label: str, labels: Sequence[str]) -> int:
    """Return 1 where a label's share is separably the largest, -1 where a rival's is separably larger, else 0.

    The rivals are the others among ``labels``.
    """
    _, low, high = shares[label]
    rivals = [shares[rival] for rival in labels if rival != label]
    if all(low > rival_high for _, _, rival_high in rivals):
        return 1
    return -1 if any(rival_low > high for _, rival_low, _ in rivals) else 0


def _below(shares: Mapping[str, Share], label: str, labels: Sequence[str]) -> int:
    """Return 1 where a label's share is separably the smallest, -1 where a rival's is separably smaller, else 0."""
    return _above({name: (-share, -high, -low) for name, (share, low, high) in shares.items()}, label, labels)


def _underestimates(swarms: pd.DataFrame) -> str:
    """Return whether the swarms underestimate more often than they overestimate."""
    finished = swarms[swarms["error"].notna()]
    if not len(finished):
        return ""
    below = finished.groupby("optimizer", observed=True)["error"].agg(lambda errors: (errors < 0).mean())
    medians = finished.groupby(["optimizer", "problem"], observed=True)["error"].median()
    often = 0  # by tests over datasets, as the trials on one share its error
    for _, signs in (medians[medians != 0] < 0).groupby("optimizer", observed=True):
        often += binomtest(int(signs.sum()), len(signs), alternative="greater").pvalue <= ALPHA
    return SAY("underestimated", [f"{share:.0%} for {label}" for label, share in below.items()], often, ALPHA)


def _widens(data: pd.DataFrame) -> str:
    """Return for how many optimizers the results scatter more at larger expected amplitudes."""
    width = _interquartile_range(data)
    width = width.join(data.groupby("problem", observed=True)["expected"].first()).dropna(subset="expected")
    pairs = [width[["expected", optimizer]].dropna().to_numpy().T for optimizer in width.columns.drop("expected")]
    tests = [
        spearmanr(expected, widths, alternative="greater")
        for expected, widths in pairs
        if len(widths) >= FEWEST and len(np.unique(widths)) > 1
    ]
    if not tests:
        return ""
    return SAY("widens", [test.statistic for test in tests if test.pvalue <= ALPHA], len(tests))


def _narrowest(swarms: pd.DataFrame, label_of: dict[str, str]) -> str:
    """Return the swarm with the narrowest boxes, which mislead according to the thesis."""
    width = _interquartile_range(swarms)
    if len(width.columns) < 2 or "alo" not in label_of:
        return ""
    narrowest = width.eq(width.min(axis=1), axis=0)
    within = errors_by(swarms, ["optimizer"])["within band %"]
    best = listing([str(label) for label in within.index[within == within.max()]])
    return SAY("narrowest", leaders(narrowest, "the narrowest interquartile range of the swarms"), best)


def _interquartile_range(data: pd.DataFrame) -> pd.DataFrame:
    """Return the interquartile range of the values found, problems by optimizers."""
    groups = data[data["expected"].notna()].groupby(["problem", "optimizer"], observed=True)["found"]
    width: pd.DataFrame = (groups.quantile(0.75) - groups.quantile(0.25)).unstack("optimizer")
    return width.set_axis(list(width.columns), axis=1)
