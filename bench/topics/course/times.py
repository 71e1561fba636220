"""Running times on suites: by function and target as a figure, and their ratios as the table behind it."""

from __future__ import annotations

import numpy as np
import pandas as pd

from bench import analysis
from bench.analysis.matrix import table as table_of
from bench.analysis.running_time import separably_fastest
from bench.plots import ert, style
from bench.report.parts import Figure, File, Table, Typography
from bench.topics.course import words
from bench.topics.findings import Anytime, Findings, Trials

COLUMNS, ACROSS, DOWN = 6, 0.1, 0.22  # panels beside each other, and inches between them
MOST = 40  # panels
LEFT = 0.6


def times_figure(findings: Findings) -> Figure | None:
    """Return the ERT over targets, a panel a function in the largest dimension, the table of ratios behind it.

    None where the problems are not the functions of a suite, or where no run reached a target.
    """
    trials, anytime = findings.trials, findings.anytime
    if len(trials.suite_functions) < len(trials.problems) or anytime.running_times.empty:
        return None
    if not (anytime.running_times["successes"] > 0).any():
        return None
    shown, places = findings.display.shown, panels(trials)
    hits = anytime.hits(shown)
    times = analysis.expected_running_time(hits[hits["problem"].isin(places)])
    times = times[times["optimizer"].isin(shown)]
    pens = {label: findings.display.pens[label] for label in shown}
    above = style.legend_height([str(entry.get_label()) for entry in style.handles(pens)])
    figure, axes = style.grid(
        len(places), columns=COLUMNS if len(places) > 4 else max(len(places), 1), height=0.85, left=LEFT,
        across=ACROSS, down=DOWN, top=above + DOWN,
    )  # fmt: skip
    drawn = times[(times["tau"] > 0) & np.isfinite(times["ert"].astype(float))]
    hardest = drawn.groupby("problem", observed=True)["tau"].min().min()
    for place, ((problem, title), ax) in enumerate(zip(places.items(), axes, strict=True)):
        ert(times, problem, pens=pens, legend=False, ax=ax)
        ax.set_title(title, loc="left", fontsize="small")
        ax.set_xlim(1.2 * drawn["tau"].max(), hardest / 1.2)
        ax.set_ylim(drawn["ert"].min() / 1.5, 1.5 * drawn["ert"].max())
        style.log_scale(ax, "x")
        style.log_scale(ax, "y")
        ax.tick_params(labelleft=place % COLUMNS == 0, labelbottom=place + COLUMNS >= len(places))
        ax.set_ylabel("")
        ax.set_xlabel("")
    chosen = anytime.target_set
    if chosen.rising:
        for ax in axes:
            ax.set_xticks(chosen.tabled, [chosen.level_text(tau) for tau in chosen.tabled], minor=False)
    corner = axes[-1 - (len(places) - 1) % COLUMNS] if len(places) > COLUMNS else axes[0]
    corner.set_xlabel(chosen.unit, loc="left")
    style.legend_above(figure, style.handles(pens))
    dimensions = {trials.dimensions[problem] for problem in places if problem in trials.dimensions}
    where = f" in dimension {dimensions.pop()}" if len(dimensions) == 1 and len(trials.problems) > len(places) else ""
    text = words.times_caption(where, chosen.unit)
    return Figure("running-times-by-target", text, figure, chosen.in_unit(times), ratios(findings))


def panels(trials: Trials) -> dict[str, str]:
    """Return the titles of the problems with a panel: each function in its largest dimension, at most :data:`MOST`."""
    largest: dict[str, str] = {}
    for label in trials.problems:
        features = trials.known[label].features
        name = f"{features.get('suite', '')} {features.get('function', label)}"
        known = largest.get(name)
        if known is None or trials.dimensions.get(label, 0) > trials.dimensions.get(known, 0):
            largest[name] = label
    suites = {str(trials.known[label].features.get("suite", "")) for label in largest.values()}
    shown = list(largest.items())[:MOST]
    titles = [name if len(suites) > 1 else name.partition(" ")[2] for name, _ in shown]
    names = style.names(titles, style.letters((style.PAGE - LEFT) / COLUMNS - ACROSS, style.SMALL))
    return {label: names[title] for title, (_, label) in zip(titles, shown, strict=True)}


def ratios(findings: Findings) -> Table:
    """Return the ERT to one target over the lowest of the row, or over that of the best of 2009, a row a problem."""
    anytime, shown = findings.anytime, findings.display.shown
    chosen, level = anytime.target_set, level_of(anytime)
    at = anytime.running_times
    at = at[np.isclose(at[chosen.unit].astype(float), level, rtol=1e-9, atol=0)]
    times = table_of(at, "ert").astype(float)
    rows = [label for label in findings.trials.problems if label in times.index]
    times = times.reindex(rows)
    lowest = times.replace(np.inf, np.nan).min(axis=1)
    divisor, name, what = lowest, "lowest ERT", "the lowest of all optimizers"
    if anytime.shows_best:
        best = at.drop_duplicates("problem").set_index("problem")["best2009"].astype(float).reindex(rows)
        divisor, name, what = best.fillna(lowest), "best of 2009", "that of the best of 2009, or the lowest without one"
    frame = times[shown].div(divisor, axis=0)
    never = at[at["successes"] == 0]
    cells = zip(never["problem"], never["optimizer"], never["trials"], strict=True)
    unsolved = {(str(problem), str(label)): f"∞ (0/{trials})" for problem, label, trials in cells}
    texts = {
        label: [
            unsolved.get((problem, label)) or _short(ratio) for problem, ratio in zip(rows, frame[label], strict=True)
        ]
        for label in shown
    }
    stars = fastest(findings, level)
    marks = {label: ["*" if (problem, label) in stars else "" for problem in rows] for label in shown}
    frame.insert(0, name, divisor)
    texts[name] = [_short(value) for value in divisor]
    return Table(
        "running-times",
        f"Expected running times to {chosen.at(level)}, a row a problem.",
        frame.rename_axis(index="problem", columns=None),
        Typography(
            texts=pd.DataFrame(texts, index=frame.index, columns=frame.columns, dtype=object),
            bold=times[shown].eq(lowest, axis=0),
            marks=pd.DataFrame(marks, index=frame.index),
        ),
        note=words.times_note(what, chosen.at(level), bool(stars)),
        data=chosen.in_unit(anytime.running_times, chosen.unit),
        latex=True,
    )


def level_of(anytime: Anytime) -> float:
    """Return the target of the tables, or the hardest that any run reached where none reached that one."""
    times, unit = anytime.running_times, anytime.target_set.unit
    reached = times.loc[times["successes"] > 0, unit].astype(float)
    return float(anytime.target_set.level if np.isclose(reached, anytime.target_set.level).any() else reached.min())


def fastest(findings: Findings, level: float) -> set[tuple[str, str]]:
    """Return the problems and optimizers that reach a target faster than each other one, as the tests show."""
    hits = findings.anytime.tabled_hits
    hits = findings.anytime.compared(hits[np.isclose(hits["tau"].to_numpy(dtype=float), level, rtol=1e-9, atol=0)])
    found = separably_fastest(hits.drop(columns="budget"))
    return set(zip(map(str, found["problem"]), map(str, found["optimizer"]), strict=True))


def files(findings: Findings) -> tuple[File, ...]:
    """Return the running times to every target of the tables, and the areas over convergence curves."""
    anytime, targets = findings.anytime, findings.anytime.target_set
    times = targets.in_unit(anytime.running_times, targets.unit)
    areas = anytime.aocc if targets.absolute else pd.DataFrame()
    made = (
        File("tables/running-times.csv", "The expected running times (ERT) of every cell, with their spread.", times),
        File(
            "tables/aocc.csv", "The area over the convergence curve (AOCC; van Stein et al. 2024) of every cell.", areas
        ),
    )
    return tuple(file for file in made if len(file.content))


def _short(value: float) -> str:
    """Return two significant digits, and all digits before the point."""
    if pd.isna(value):
        return "–"
    return "∞" if np.isinf(value) else f"{value:,.0f}" if value >= 9.95 else f"{value:.2g}"
