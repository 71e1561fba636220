"""CMA-ES against the swarms under equal conditions: the same handling, the same start and the same population."""

from __future__ import annotations

import pandas as pd

from bench import Study
from bench.analysis import ALPHA, medians, pairwise_tests, probability_of_improvement, summarise, wilcoxon_tests
from bench.errors import BenchError
from bench.optimizer import CONDITIONS
from bench.plugins.loading import is_built_in
from bench.report import Section, Table
from bench.report.wording import interval, leaders, listing, p_text
from problems.backlash.report.fitting_errors import EXTRA, SWARMS, part

TITLE = "CMA-ES and the swarms under equal conditions"
ROW = ["agents", "swarm"]


def sections(frame: pd.DataFrame, study: Study) -> list[Section]:
    """Return the section, none where no swarm ran with the handling, start and population of CMA-ES."""
    text, rows = [], []
    for agents, labels in equal_groups(study).items():
        own = part(frame, list(frame["problem"].cat.categories), labels.values())
        middle = medians(summarise(own)).dropna(how="all")
        if middle.empty:
            continue
        table = against_swarms(own, labels)
        rows.append(pd.concat([table], keys=[agents], names=ROW))
        text.append(f"With {agents} agents {_sentence(own, middle, table, labels[EXTRA])}")
    if not rows:
        return []
    return [Section(TITLE, (_lead(len(rows)), *text), (_table(pd.concat(rows)),))]


def equal_groups(study: Study) -> dict[int, dict[str, str]]:
    """Return by number of agents the labels of CMA-ES and of the swarms, by plug-in, where all repair random starts.

    Only the optimizers that come with the harness are loaded. Of several alike, the first counts.
    """
    groups: dict[int, dict[str, str]] = {}
    for entry in study.optimizers:
        if entry.name in (EXTRA, *SWARMS) and is_built_in(entry.name):
            try:
                own = study.optimizer(entry.label)
            except BenchError:  # its library is missing
                continue
            agents, handling, start = (getattr(own, name, None) for name in CONDITIONS)
            if agents and (handling, start) == ("repair", "random"):
                groups.setdefault(agents, {}).setdefault(entry.name, entry.label)
    return {key: labels for key, labels in sorted(groups.items()) if EXTRA in labels and len(labels) > 1}


def against_swarms(frame: pd.DataFrame, labels: dict[str, str]) -> pd.DataFrame:
    """Return a row a swarm: on how many datasets CMA-ES is lower, by medians and by tests, and by how much.

    Columns: datasets; median (on how many CMA-ES's is lower), lower and higher (on how many the Kolmogorov-Smirnov
    test with Holm's adjustment over the pairs of a dataset distinguishes them, and A12 favours CMA-ES or the swarm);
    probability, low and high (that a run of CMA-ES ends below one of the swarm: the mean of A12 over datasets and its
    bootstrap interval); p_holm (Wilcoxon's test across datasets, adjusted over the pairs).
    """
    cma = labels[EXTRA]
    middle = medians(summarise(frame))
    frame = part(frame, list(middle.index), list(frame["optimizer"].cat.categories))
    pairs = pairwise_tests(frame)
    across = wilcoxon_tests(middle)
    rows = {}
    for swarm in (labels[name] for name in SWARMS if name in labels):
        both = pairs[_of(pairs, cma, swarm) & pairs["significant"]]
        chance = probability_of_improvement(part(frame, list(middle.index), (cma, swarm))).iloc[0]
        ends = [chance["probability"], chance["low"], chance["high"]]
        if chance["first"] == swarm:
            ends = [1 - ends[0], 1 - ends[2], 1 - ends[1]]
        rows[swarm] = {
            "datasets": len(middle),
            "median": int((middle[cma] < middle[swarm]).sum()),
            "lower": int((both["lower"] == cma).sum()),
            "higher": int((both["lower"] == swarm).sum()),
            **dict(zip(("probability", "low", "high"), ends, strict=True)),
            "p_holm": across.loc[_of(across, cma, swarm), "p_holm"].iloc[0],
        }
    return pd.DataFrame(rows).T


def _of(pairs: pd.DataFrame, one: str, other: str) -> pd.Series[bool]:
    """Return which rows are about these two, in either order."""
    return pairs["first"].isin([one, other]) & pairs["second"].isin([one, other])


def _lead(sizes: int) -> str:
    return (
        "In the thesis CMA-ES searches the box from its midpoint, while the swarms start at random and are held to the "
        "constraints. Here all of them repair their points by the constraints and start at random, with the same "
        f"population{'' if sizes == 1 else f', of {sizes} sizes'}. CMA-ES stops by its own tolerances and does not "
        "restart, so it may leave a part of its budget unused. The datasets are levels of one gap, not independent "
        "samples, so that p across them overstates the evidence."
    )


def _sentence(frame: pd.DataFrame, middle: pd.DataFrame, table: pd.DataFrame, cma: str) -> str:
    lowest = leaders(middle.eq(middle.min(axis=1), axis=0), "the lowest median")
    tests = [f"{swarm} on {row.lower:.0f} (higher on {row.higher:.0f})" for swarm, row in table.iterrows()]
    made = frame.groupby("optimizer", observed=True)["nfev"].mean()
    text = f"{lowest}. By the tests, {cma} is lower than {listing(tests)}."
    if made[cma] < made.max():
        text += f" A run of {cma} made {made[cma]:,.0f} evaluations on average, a run of a swarm {made.max():,.0f}."
    return text


def _table(table: pd.DataFrame) -> Table:
    titles = {"median": "lower median on", "lower": "tests: lower on", "higher": "tests: higher on"}
    shown = table[["datasets", *titles]].astype(int).rename(columns=titles)
    shown["P(CMA-ES lower)"] = table["probability"].astype(float)
    shown["95% interval"] = [interval(low, high, 2) for low, high in zip(table["low"], table["high"], strict=True)]
    shown["Wilcoxon"] = table["p_holm"].map(lambda p: p_text(float(p)))
    return Table(
        "equal-conditions",
        "CMA-ES beside each swarm with the same population, handling and start: on how many datasets it is lower.",
        shown,
        decimals={"P(CMA-ES lower)": 2},
        note=f"Tests: exact Kolmogorov-Smirnov at {ALPHA:g} with Holm’s adjustment over the pairs of a dataset and a "
        "population, and a 95% interval of A12 on one side of 0.5. P: that a run of CMA-ES ends below one of the "
        "swarm, the mean of A12 over datasets. Wilcoxon: across datasets, on the medians, adjusted over the pairs.",
        data=table.reset_index(),
    )
