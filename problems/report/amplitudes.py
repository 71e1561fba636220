"""Fig. 7.4: the disturbance amplitude each trial found, against the expected one and its accuracy band."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from bench import Results
from bench.analysis import in_study_order, labels
from bench.report import Figure, Section, Table, style
from bench.report.words import listing
from problems.signature.problem import TOLERANCE_RPM

COLUMNS = ("problem", "optimizer", "trial", "status", "amplitude_rpm", "error_rpm", "expected_rpm")


def sections(results: Results) -> list[Section]:
    """Return the section on amplitudes; figures alone where no expected amplitude is known."""
    data = amplitudes(in_study_order(results.frame, results.study))
    figures = (_figure(data, "dots"), _figure(data, "boxes"))
    if data["expected_rpm"].isna().all():
        text = ("No expected amplitude is known for these problems, so there is no error to give.",)
        return [Section("Disturbance amplitude (thesis Fig. 7.4)", text, figures)]
    errors = errors_by(data, ["optimizer"])
    return [
        Section("Disturbance amplitude (thesis Fig. 7.4)", _in_words(data, errors), (*figures, *_tables(data, errors)))
    ]


def amplitudes(frame: pd.DataFrame) -> pd.DataFrame:
    """Return one row a trial of the problems that have an amplitude: what was found, expected and missed, in rpm.

    A problem's expected amplitude is read off any of its finished trials, so that a failed one has it too.
    """
    error = frame["amplitude_error_rpm"] if "amplitude_error_rpm" in frame else pd.Series(np.nan, index=frame.index)
    error, found = pd.to_numeric(error), pd.to_numeric(frame["amplitude_rpm"])
    expected = (found - error).groupby(frame["problem"], observed=False).transform("median")
    data = frame.assign(amplitude_rpm=found, error_rpm=error, expected_rpm=expected)[list(COLUMNS)]
    known = data.loc[found.notna(), "problem"].unique()
    data = data[data["problem"].isin(known)]
    return data.assign(problem=data["problem"].cat.remove_unused_categories())


def errors_by(data: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """Return trials, mean and median error in rpm and the share of trials within the accuracy band, by ``keys``.

    Only trials with a known expected amplitude count; a failed one has no error and is not within the band.
    """
    known = data[data["expected_rpm"].notna()]
    groups = known.assign(within=known["error_rpm"].abs() <= TOLERANCE_RPM).groupby(keys, observed=True)
    return groups.agg(
        trials=("within", "size"),
        mean_error=("error_rpm", "mean"),
        median_error=("error_rpm", "median"),
        within=("within", "mean"),
    )


def _in_words(data: pd.DataFrame, errors: pd.DataFrame) -> tuple[str, ...]:
    shares = errors["within"].sort_values(ascending=False, kind="stable")
    within = listing([f"{share:.0%} of the trials of {label}" for label, share in shares.items()])
    band = f"±{TOLERANCE_RPM:.4f} rpm about the expected amplitude (Delta-A/2 of section 7.2.3)"
    text = [f"Within the accuracy band of {band} lie {within}."]
    outside = data.loc[data["error_rpm"].abs() > TOLERANCE_RPM, "error_rpm"]
    if len(outside):
        text.append(
            f"Of the {len(outside):,} finished trials outside it, {(outside < 0).mean():.0%} underestimate the "
            "amplitude (the thesis finds the same tendency in its swarms: a failed fit keeps the smaller half of the "
            "oscillation)."
        )
    return tuple(text)


def _tables(data: pd.DataFrame, errors: pd.DataFrame) -> list[Table]:
    note = "Errors are over finished trials; the share is over all, and a failed trial is not within the band."
    overall = Table(
        "amplitude-errors",
        f"Amplitude error in rpm (found less expected), and the share of trials within ±{TOLERANCE_RPM:.4f} rpm.",
        _shown(errors),
        decimals={"mean error": 2, "median error": 2, "within band %": 1},
        note=note,
    )
    cells = _shown(errors_by(data, ["problem", "optimizer"]))
    decimals = {"within band %": 0, "median error": 2, "mean error": 2}
    by_dataset = [
        Table(
            f"amplitude-{column.removesuffix(' %').replace(' ', '-')}-by-dataset",
            f"By dataset: {caption}.",
            cells[column].unstack("optimizer").rename_axis(columns=None),
            decimals=decimals[column],
        )
        for column, caption in (
            ("within band %", "share of trials within the band, in percent"),
            ("median error", "median amplitude error in rpm"),
            ("mean error", "mean amplitude error in rpm"),
        )
    ]
    return [overall, *by_dataset]


def _shown(errors: pd.DataFrame) -> pd.DataFrame:
    renamed = errors.rename(columns={"mean_error": "mean error", "median_error": "median error"})
    return renamed.assign(**{"within band %": 100 * errors["within"]}).drop(columns="within")


def _figure(data: pd.DataFrame, form: str) -> Figure:
    """Return Fig. 7.4 as "dots" (its upper part) or "boxes" (its lower one), a panel an optimizer."""
    problems, optimizers = labels(data, "problem"), labels(data, "optimizer")
    expected = data.groupby("problem", observed=False)["expected_rpm"].first().reindex(problems).to_numpy()
    figure, axes = style.panels(len(optimizers), columns=2, height=2.6, sharex=True, sharey=True)
    for ax, optimizer in zip(axes, optimizers, strict=True):
        own = data[(data["optimizer"] == optimizer) & data["amplitude_rpm"].notna()]
        values = [own.loc[own["problem"] == problem, "amplitude_rpm"].to_numpy() for problem in problems]
        (_dots if form == "dots" else _boxes)(ax, values)
        _expected(ax, expected)
        ax.set_title(style.plain(optimizer), loc="left")
        ax.set_xticks(range(len(problems)), [style.plain(_short(problem), 12) for problem in problems])
        ax.xaxis.set_tick_params(rotation=90 if max(map(len, map(_short, problems)), default=0) > 2 else 0)
        ax.grid(visible=False, axis="x")
    for ax in axes[::2]:
        ax.set_ylabel("amplitude |A| in rpm")
    for ax in axes[-2:]:
        ax.set_xlabel("dataset")
        ax.xaxis.set_tick_params(labelbottom=True)
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper left", ncols=3)
    drawn = "every trial a dot, one column of dots a dataset" if form == "dots" else "the same as box plots by dataset"
    caption = (
        f"Disturbance amplitude found, {drawn}. Line: the expected amplitude; dotted: the accuracy band of "
        f"±{TOLERANCE_RPM:.4f} rpm (thesis Fig. 7.4)."
    )
    return Figure(f"amplitude-{form}", caption, figure, data)


def _short(problem: str) -> str:
    """Return the number of a simulated dataset, any other label as it is."""
    return re.sub(r"^signature-(?=\d+$)", "", problem)


def _dots(ax: Axes, values: list[np.ndarray]) -> None:
    at = np.repeat(np.arange(len(values)), [len(column) for column in values])
    many = len(at) > style.MANY_POINTS
    ax.plot(
        at, np.concatenate(values), "o", color=style.PALETTE[0], markersize=3, markeredgewidth=0, alpha=0.6,
        rasterized=many, label="trial",
    )  # fmt: skip


def _boxes(ax: Axes, values: list[np.ndarray]) -> None:
    ax.boxplot(
        values, positions=range(len(values)), widths=0.6, manage_ticks=False,
        flierprops={"marker": "o", "markersize": 2.5, "markeredgewidth": 0.5},
        medianprops={"color": style.PALETTE[0], "linewidth": 1.4}, boxprops={"linewidth": 0.8},
        whiskerprops={"linewidth": 0.8}, capprops={"linewidth": 0.8},
    )  # fmt: skip


def _expected(ax: Axes, expected: np.ndarray) -> None:
    at = np.arange(len(expected))
    if np.isnan(expected).all():
        return
    ax.plot(at, expected, color=style.REFERENCE, linewidth=1.0, marker="_", markersize=7, label="expected amplitude")
    for sign, label in ((-1, "accuracy band"), (1, None)):
        ax.plot(at, expected + sign * TOLERANCE_RPM, ":", color=style.REFERENCE, linewidth=1.0, label=label)
