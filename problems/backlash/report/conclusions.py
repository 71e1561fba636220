"""Compare the thesis's conclusions from Fig. 7.4 (section 7.2.3) with the study's own trials."""

from __future__ import annotations

import pandas as pd
from scipy.stats import binomtest, spearmanr

from bench import Study
from bench.analysis import ALPHA
from bench.report.wording import count, leaders, listing
from problems.backlash.report.accuracy import errors_by, shares_within
from problems.backlash.report.fitting_errors import EXTRA, SWARMS, algorithms
from problems.backlash.signature.problem import TOLERANCE_RPM

FEWEST = 4  # datasets; of three, even a perfect rank correlation has p = 1/6


def sentences(data: pd.DataFrame, study: Study) -> tuple[str, ...]:
    """Return the shares within the accuracy band, and each conclusion of the thesis beside what was found here.

    Args:
        data: from :func:`problems.backlash.report.accuracy.estimates`, of the amplitude.
        study: its optimizers that the thesis has, too, are compared; a conclusion on others is left out.
    """
    known = algorithms(study)
    swarms = data[data["optimizer"].isin([known[name] for name in SWARMS if name in known])]
    swarms = swarms.assign(optimizer=swarms["optimizer"].cat.remove_unused_categories())
    band = f"±{TOLERANCE_RPM:.4f} rpm about the expected amplitude (half of Delta A of section 7.2.3)"
    return (
        f"{shares_within(data)} are within the accuracy band of {band}.",
        *_most_accurate(data, known),
        *_underestimates(swarms),
        *_widens(data),
        *_narrowest(swarms, known),
    )


def _most_accurate(data: pd.DataFrame, known: dict[str, str]) -> list[str]:
    """Return which algorithm has most and fewest trials within the band, where the thesis's all have trials."""
    if not {*SWARMS, EXTRA} <= set(known):
        return []
    within = errors_by(data, ["optimizer"])["within band %"].reindex([known[name] for name in (*SWARMS, EXTRA)])
    if within.isna().any():
        return []
    swarms = within.drop(known[EXTRA])
    claims = {
        "CMA-ES the most suited": within[known[EXTRA]] > swarms.max(),
        "GWO the best of the swarms": swarms[known["gwo"]] > swarms.drop(known["gwo"]).max(),
        "DA the least effective": swarms[known["da"]] < swarms.drop(known["da"]).min(),
    }
    return [f"The thesis finds {_agreement(claims)}."]


def _agreement(claims: dict[str, bool]) -> str:
    """Return claims as two lists: those that these shares support, and those that they do not."""
    held = [claim for claim, holds in claims.items() if holds]
    failed = [claim for claim, holds in claims.items() if not holds]
    parts = [f"{listing(held)}, and these shares agree"] if held else []
    parts += [f"{listing(failed)}, and these shares disagree"] if failed else []
    return "; it also finds ".join(parts)


def _underestimates(swarms: pd.DataFrame) -> list[str]:
    """Return whether the swarms underestimate more often than they overestimate, by a sign test of datasets each.

    The unit is the dataset: trials on one dataset share its error.
    """
    known = swarms[swarms["error"].notna()]
    if not len(known):
        return []
    below = known.groupby("optimizer", observed=True)["error"].agg(lambda errors: (errors < 0).mean())
    often = []
    for label, own in known.groupby("optimizer", observed=True):
        medians = own.groupby("problem", observed=True)["error"].median()
        signs = medians[medians != 0] < 0
        if len(signs) and binomtest(int(signs.sum()), len(signs), alternative="greater").pvalue <= ALPHA:
            often.append(label)
    found = listing([f"{share:.0%} for {label}" for label, share in below.items()])
    text = (
        "The thesis finds that the swarms underestimate the amplitude more often than they overestimate it, as a "
        "failed fit keeps the smaller half of the oscillation. Here the share of finished trials below the expected "
        f"amplitude is {found}. The median is below it on more than half of the datasets for {len(often)} of "
        f"{count(len(below), 'swarm')} (sign test over datasets at {ALPHA:g})."
    )
    return [text]


def _widens(data: pd.DataFrame) -> list[str]:
    """Return for how many optimizers the results scatter more at larger expected amplitudes."""
    width = _interquartile_range(data)
    width = width.join(data.groupby("problem", observed=True)["expected"].first()).dropna(subset="expected")
    grows, tested = [], 0
    for optimizer in width.columns.drop("expected"):
        own = width[[optimizer, "expected"]].dropna()
        if len(own) >= FEWEST and own[optimizer].nunique() > 1:
            tested += 1
            result = spearmanr(own["expected"], own[optimizer], alternative="greater")
            grows += [result.statistic] if result.pvalue <= ALPHA else []
    if not tested:
        return []
    text = (
        "The thesis finds that the results scatter more at larger backlash, as the bounds of A widen with it. Here the "
        f"interquartile range grows with the expected amplitude for {len(grows)} of {count(tested, 'optimizer')}"
    )
    return [f"{text} (Spearman’s rank correlation {min(grows):.2f} to {max(grows):.2f})." if grows else f"{text}."]


def _narrowest(swarms: pd.DataFrame, known: dict[str, str]) -> list[str]:
    """Return which swarm has the narrowest boxes, which mislead according to the thesis."""
    width = _interquartile_range(swarms)
    if len(width.columns) < 2 or "alo" not in known:
        return []
    narrowest = width.eq(width.min(axis=1), axis=0)
    within = errors_by(swarms, ["optimizer"])["within band %"]
    best = listing([str(label) for label in within.index[within == within.max()]])
    leading = leaders(narrowest, "the narrowest interquartile range of the swarms")
    text = (
        "The thesis’s box plots show ALO as the most precise swarm, and it warns that they mislead, as the results of "
        "GWO are either close to the expected amplitude or far from it. Here "
        f"{leading}, while {best} has the largest share within the band."
    )
    return [text]


def _interquartile_range(data: pd.DataFrame) -> pd.DataFrame:
    """Return the interquartile range of the values found, problems by optimizers."""
    groups = data[data["expected"].notna()].groupby(["problem", "optimizer"], observed=True)["found"]
    width: pd.DataFrame = (groups.quantile(0.75) - groups.quantile(0.25)).unstack("optimizer")
    return width.set_axis(list(width.columns), axis=1)
