"""Describe the problems by their features, and name the features that go with the ranks of the optimizers."""

from __future__ import annotations

import pandas as pd

from bench.analysis import ALPHA
from bench.analysis.landscape import LEAST_PROBLEMS, feature_ranks
from bench.report.parts import Part, Section, Table
from bench.report.wording import count, listing
from bench.topics.findings import Findings
from bench.topics.landscapes.features import landscapes
from bench.topics.topic import Topic

TITLE = "Kinds of problems"
SHOWN = {
    "ela_meta.lin_simple.adj_r2": "linear fit R²",
    "ela_meta.quad_simple.adj_r2": "quadratic fit R²",
    "ela_distr.skewness": "skewness",
    "disp.ratio_mean_05": "dispersion",
    "nbc.nn_nb.mean_ratio": "nearest / nearest better",
    "ic.h_max": "information content",
    "fitness_distance.correlation": "fitness-distance",
}
"""The features of the table on the page, with short names."""

MEANING = (
    "Features describe the landscape of a problem, as a sample of random points shows it. A quadratic fit of 1 is a "
    "bowl. The dispersion is the distance among the best 5% of the points over that among all: well below 1 the best "
    "points lie together. The information content is high where the values along a walk rise and fall irregularly. A "
    "fitness-distance correlation near 1 is a funnel towards the best point."
)
ROWS = 12  # of the table of features and ranks


def section(findings: Findings) -> Section | None:
    """Return features of the problems' landscapes, and how they go with ranks; None where no problem is described."""
    found = findings.of(landscapes)
    if found.table.empty:
        return None
    table = found.table
    text = [MEANING + (" Of pooled instances, the first is described." if findings.trials.precisions else "")]
    if found.left_out:
        text.append(
            f"Not described: {listing(sorted(found.left_out))}, which cannot be loaded or sampled here in time."
        )
    shown = table[list(SHOWN)].rename(columns=SHOWN)
    items: list[Part] = [
        Table(
            "landscape",
            f"Features of the landscape of {count(len(table), 'problem')}.",
            shown,
            decimals=2,
            note="–: not defined for this sample. The file has all features, named as in flacco.",
            data=table.reset_index(),
        )
    ]
    sentence, ranks = _ranks(findings, table)
    text += sentence
    return Section(TITLE, tuple(text), (*items, *ranks), on_demand=True)  # background


def _ranks(findings: Findings, table: pd.DataFrame) -> tuple[list[str], list[Part]]:
    """Return the sentences on features and ranks, and the table behind them."""
    if len(findings.trials.optimizers) < 2:
        return [], []
    problems = int(findings.final.medians.index.isin(table.index).sum())
    if problems < LEAST_PROBLEMS:
        few = f"Features are compared with the ranks of the optimizers from {LEAST_PROBLEMS} problems on"
        return [f"{few}; here are {problems}."], []
    trials = findings.trials
    tests = feature_ranks(table, findings.final.medians, trials.blocks, trials.dimensions)
    if tests.empty:
        return ["The features or the ranks are the same on all problems, so none goes with another."], []
    clear = tests[tests["significant"]]
    named = [
        f"{row['optimizer']} ranks {'worse' if row['rho'] > 0 else 'better'} the larger {row['feature']} "
        f"(rho = {row['rho']:.2f})"
        for row in clear.iloc[:3].to_dict("records")
    ]
    several = f"{count(len(tests), 'test')} of a feature and an optimizer’s rank over {problems} problems"
    sentence = (
        f"Of {several}, {count(len(clear), 'is', 'are')} significant at {ALPHA:g}, adjusted for all: {listing(named)}"
        + (", among others." if len(clear) > len(named) else ".")
        if named
        else f"Of {several}, none is significant at {ALPHA:g}, adjusted for all."
    )
    caution = (
        " The tests exchange the features of whole blocks of problems, such as a function in its dimensions, at "
        "random. Their level is their own, beside that of the verdict; a correlation is no cause."
    )
    shown = tests.iloc[:ROWS].rename(columns={"p_adjusted": "p (adjusted)", "rho": "Spearman’s rho"})
    return [sentence + caution], [
        Table(
            "feature-ranks",
            "Features of the landscape that go most with the rank of an optimizer over problems.",
            shown,
            decimals={"Spearman’s rho": 2},
            note="A positive rho: the optimizer ranks worse where the feature is larger. The file has all tests.",
            data=tests,
        )
    ]


TOPIC = Topic(TITLE, section, place=650)
