"""The contribution of each parameter of a sweep, and of each pair of them, to the results of its combinations.

Everything starts from *chances*: of a trial, the chance that a trial of a random combination of the sweep, on the same
problem, ends higher; ties count half. This is one less the relative effect of nonparametric factorial designs, with
pseudo-ranks, so that unequal numbers of trials move nothing (Brunner, Konietschke, Pauly and Puri 2017, Journal of the
Royal Statistical Society B 79(5)). It is the A12 of the trial against the whole sweep, needs no scale that problems
share, and a failed trial is the worst.

The chances of all combinations on a problem are a function of the parameters on a full grid. Functional ANOVA takes it
apart into main effects and interactions (Hutter, Hoos and Leyton-Brown 2014, An efficient approach for assessing
hyperparameter importance, ICML). Each part's variance over the grid holds a known part of the randomness of the trials,
which is subtracted: the variance of a parameter without any effect is 0 in expectation, and below it as often as above.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations, product
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import binomtest, chi2, rankdata

from bench.analysis.across import friedman
from bench.analysis.cells import cells, labels
from bench.analysis.direction import ALPHA, least_p
from bench.analysis.pairwise import holm
from bench.study.sweep import Levels, Sweep
from bench.typing import Floats

FEWEST = 5  # trials of each combination, from which a parameter is tested on a single problem
HIGHER, TRIALS = "higher interactions", "randomness of trials"
"""The names of the components that are no parameter and no pair of parameters."""

Factors = tuple[str, ...]


class Contributions(NamedTuple):
    """The contributions of the parameters of a sweep.

    Attributes:
        levels: problem, factor, level and ``chance``, the mean over the combinations with that value.
        effects: problem, component, ``share`` of the variance of the chances of single trials, and p. Components are
            the parameters, their pairs as "a × b", :data:`HIGHER` and :data:`TRIALS`; their shares add up to 1, and
            those of parts without effect scatter about 0. Shares are missing where a combination has a single trial, or
            all trials tie. p is that of :func:`stratified_test`, of parameters only, and missing below :data:`FEWEST`
            trials.
        left_out: the problems on which a combination has no trial.
    """

    levels: pd.DataFrame
    effects: pd.DataFrame
    left_out: list[str]


def contributions(frame: pd.DataFrame, sweep: Sweep) -> Contributions:
    """Return the contributions of a sweep's parameters on each problem; the sweep must lack no combination."""
    factors = {name: levels for name, levels in sweep.factors.items() if len(levels) > 1}
    by_cell = cells(frame[frame["optimizer"].isin(list(sweep.labels.values()))], merge=True)
    chosen = {
        tuple(level for name, level in zip(sweep.factors, levels, strict=True) if name in factors): label
        for levels, label in sweep.labels.items()
    }
    levels, effects, left_out = [], [], []
    for problem in labels(frame, "problem"):
        samples = {key: by_cell.get((problem, label), np.empty(0)) for key, label in chosen.items()}
        fewest = min(map(len, samples.values()))
        if not fewest:
            if any(map(len, samples.values())):
                left_out.append(problem)
            continue
        chances_of = dict(zip(samples, chances(list(samples.values())), strict=True))
        means = [float(chances_of[key].mean()) for key in product(*factors.values())]
        parts = decomposed(np.reshape(means, [len(values) for values in factors.values()]))
        for axis, (name, own_levels) in enumerate(factors.items()):
            main = 0.5 + parts[(axis,)].ravel()
            levels += [(problem, name, level, chance) for level, chance in zip(own_levels, main, strict=True)]
        tested = {
            name: stratified_test(_strata(samples, factors, name)) if fewest >= FEWEST else np.nan for name in factors
        }
        for component, share in _shares(chances_of, parts, list(factors)).items():
            effects.append((problem, component, share, tested.get(component, np.nan)))
    return Contributions(
        pd.DataFrame(levels, columns=["problem", "factor", "level", "chance"]),
        pd.DataFrame(effects, columns=["problem", "component", "share", "p"]),
        left_out,
    )


def chances(samples: list[Floats]) -> list[Floats]:
    """Return for each value the chance that a value of a random sample is higher, ties counted half; lower is better.

    Each sample counts once, whatever its size.
    """
    ordered = [np.sort(values) for values in samples]
    chances_of = []
    for values in samples:
        below = [
            np.searchsorted(sample, values, "left") + np.searchsorted(sample, values, "right") for sample in ordered
        ]
        shares = [1 - count / (2 * len(sample)) for count, sample in zip(below, ordered, strict=True)]
        chances_of.append(np.mean(shares, axis=0))
    return chances_of


def decomposed(grid: Floats) -> dict[tuple[int, ...], Floats]:
    """Return the functional ANOVA of a function on a full grid: for each set of axes, the part that depends on these.

    A part has length 1 along the other axes and sums to 0 along its own; all parts add up to the function. The set of
    no axes is the mean.
    """
    parts: dict[tuple[int, ...], Floats] = {}
    for size in range(grid.ndim + 1):
        for axes in combinations(range(grid.ndim), size):
            averaged = tuple(set(range(grid.ndim)) - set(axes))
            part = grid.mean(axis=averaged, keepdims=True) if averaged else grid.copy()
            for less, smaller in parts.items():
                if set(less) < set(axes):
                    part = part - smaller
            parts[axes] = part
    return parts


def stratified_test(strata: list[list[Floats]]) -> float:
    """Return p of the test that the samples of every stratum come from one distribution, against a common shift.

    Each stratum holds a sample for each value of the parameter, all else being equal. Ranks within strata are summed
    with the weights of van Elteren (1960, Bulletin de l'Institut International de Statistique 37), for two samples or
    more; the chi-squared statistic uses the variances under permutation within strata, so ties are accounted for. With
    one stratum it is the test of Kruskal and Wallis, with one value a sample Friedman's.
    """
    k = len(strata[0])
    total, variance = np.zeros(k), np.zeros((k, k))
    for samples in strata:
        sizes = np.array([len(sample) for sample in samples], dtype=float)
        n = sizes.sum()
        ranks = rankdata(np.concatenate(samples))
        sums = np.array([part.sum() for part in np.split(ranks, np.cumsum([len(sample) for sample in samples])[:-1])])
        total += (sums - sizes * ranks.mean()) / (n + 1)
        spread = ranks.var() * n / max(n - 1, 1)
        variance += spread * (np.diag(sizes) - np.outer(sizes, sizes) / n) / (n + 1) ** 2
    if variance.trace() < 1e-12:  # all values tie
        return 1.0
    statistic = float(total[:-1] @ np.linalg.pinv(variance[:-1, :-1]) @ total[:-1])
    return float(chi2.sf(statistic, k - 1))


def mean_shares(effects: pd.DataFrame) -> pd.Series[float]:
    """Return the mean share of each component over the problems that have shares, in the order of the components."""
    with_shares = effects.dropna(subset="share")
    return with_shares.groupby("component", sort=False)["share"].mean()


def level_tests(levels: pd.DataFrame, alpha: float = ALPHA) -> pd.DataFrame:
    """Return one row a parameter: does any of its values rank differently from the others over the problems?

    Columns: factor; problems; ``best``, the value with the highest mean chance, "" where two share it; ``chance``, that
    mean, and ``lowest``, that of the worst value; ``first``, the problems on which the best value has the highest
    chance, ties included; p, by the sign test for two values and by Friedman's test, which is the same question, as
    Iman and Davenport corrected it, for more; p_holm, adjusted over the parameters; ``note``, "" unless no outcome
    could be significant, or all problems tie. Each problem counts once.
    """
    rows: list[dict[str, Any]] = []
    for factor, of_factor in levels.groupby("factor", sort=False):
        table = of_factor.pivot(index="problem", columns="level", values="chance")
        table = table[list(dict.fromkeys(of_factor["level"]))].round(12)  # sums of shares differ in last digits
        means = table.mean().sort_values(ascending=False, kind="stable")
        if len(means) == 2:
            differing = table[table.iloc[:, 0] != table.iloc[:, 1]]
            note = "identical" if differing.empty else "untestable" if least_p(len(differing)) > alpha else ""
            higher = int((differing.iloc[:, 0] > differing.iloc[:, 1]).sum())
            p = 1.0 if note else float(binomtest(higher, len(differing)).pvalue)
        else:
            wide = dict(friedman(1 - table).iloc[0])
            p, note = wide["p_iman_davenport"], wide["note"]
        tie = np.isclose(means.iloc[0], means.iloc[1], rtol=0, atol=1e-9)
        rows.append(
            {
                "factor": factor, "problems": len(table), "best": "" if tie else means.index[0],
                "chance": means.iloc[0], "lowest": means.iloc[-1],
                "first": int((table[means.index[0]] >= table.max(axis=1)).sum()), "p": float(p), "note": note,
            }
        )  # fmt: skip
    tests = pd.DataFrame(rows, columns=["factor", "problems", "best", "chance", "lowest", "first", "p", "note"])
    return tests.assign(p_holm=holm(tests["p"].to_numpy(dtype=float)))


def _strata(samples: Mapping[Levels, Floats], factors: Mapping[str, Levels], name: str) -> list[list[Floats]]:
    """Return the samples of each value of a parameter, by the combinations of all others."""
    axis = list(factors).index(name)
    strata: dict[Levels, list[Floats]] = {}
    for key in product(*factors.values()):
        strata.setdefault(key[:axis] + key[axis + 1 :], []).append(samples[key])
    return list(strata.values())


def _shares(
    chances_of: Mapping[Levels, Floats], parts: Mapping[tuple[int, ...], Floats], names: list[str]
) -> dict[str, float]:
    """Return the share of each component of the variance among single trials, all missing where it is not known."""
    count = len(chances_of)
    if min(map(len, chances_of.values())) > 1:
        within = np.array([values.var(ddof=1) for values in chances_of.values()])
        # The variance of a combination's mean.
        noise = float((within / [len(values) for values in chances_of.values()]).mean())
        random = float(within.mean())
    else:
        noise = random = np.nan
    sizes = parts[tuple(range(len(names)))].shape
    variances: dict[str, float] = {}
    for axes, part in parts.items():
        if not axes:
            continue
        freedom = np.prod([sizes[axis] - 1 for axis in axes])
        component = " × ".join(names[axis] for axis in axes) if len(axes) < 3 else HIGHER
        variance = float((part**2).mean()) - freedom / count * noise
        variances[component] = variances.get(component, 0.0) + variance
    variances[TRIALS] = random
    total = sum(variances.values())
    return {name: variance / total if total > 1e-12 else np.nan for name, variance in variances.items()}
