"""Performance profiles: how often an optimizer is the fastest, or nearly so."""

from __future__ import annotations

import numpy as np
import pandas as pd

from bench import analysis
from bench.plots import performance_profile, style
from bench.report.parts import Figure, Section
from bench.report.prose import speaker
from bench.topics.figures import COLUMNS, legend_height, titles
from bench.topics.findings import Findings

TITLE = "Performance profiles"
FEWEST = 2  # problems
ACROSS = 0.2  # inches between panels
SAY = speaker(__package__)


def sections(findings: Findings) -> list[Section]:
    """Return the profiles at the levels of the success rates; nothing for one optimizer, or a single problem."""
    chosen, times, pens = findings.anytime.target_set, findings.anytime.running_times, findings.display.drawn
    times = times[times["problem"].isin(findings.final.medians.index)]
    profiles, problems = {}, [0]
    for level in chosen.levels:
        at_level = times[np.isclose(times[chosen.unit].astype(float), level, rtol=1e-9, atol=0)]
        if len(curves := analysis.performance_profiles(at_level)):
            profiles[chosen.at(level)] = curves
            problems.append(at_level["problem"].nunique())
    if len(findings.trials.optimizers) < 2 or max(problems) < FEWEST:
        return []
    above, down = titles(profiles, COLUMNS, ACROSS)
    figure, axes = style.grid(
        len(profiles), height=1.5, left=0.5, across=ACROSS, down=down, top=legend_height(pens) + down, bottom=0.4
    )
    for place, (title, curves, ax) in enumerate(zip(profiles, profiles.values(), axes, strict=True)):
        performance_profile(curves, pens=pens, legend=False, ax=ax)
        ax.set_title(above[title], loc="left", fontsize="small")
        if place:
            ax.set_ylabel("")
            ax.tick_params(labelleft=False)
    style.legend_above(figure, style.handles(pens))
    data = pd.concat(profiles, names=["target"])
    data = data.reset_index("target").reset_index(drop=True)
    within = data[data["ratio"].isin([1.0])].pivot(index="target", columns="optimizer", values="fraction")
    shown = within.reindex(index=list(profiles), columns=findings.trials.optimizers).rename_axis(columns=None)
    drawn = Figure("performance-profiles", SAY("profiles_caption", max(problems)), figure, data, shown)
    return [Section(TITLE, (SAY("profiles"), *findings.display.drawn_words), (drawn,), folded=True)]
