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

Whether a parameter matters at all on these problems, by itself or together with others, is tested by permutation: were
it without effect, its values could be exchanged among the trials of a block, in which all else is equal. That holds
whatever the distributions are, with ties and failed trials as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, product
from math import comb
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import binomtest, rankdata

from bench.analysis.across import friedman, p_of_means
from bench.analysis.cells import labels
from bench.analysis.direction import ALPHA, effects, least_p, stacked, stratified
from bench.analysis.pairwise import holm
from bench.analysis.strata import strata
from bench.study.sweep import Levels, Sweep
from bench.typing import Floats

PERMUTATIONS = (199, 4_999)  # of a test, the fewest and the most
WORK = 10_000_000  # values that a test permutes
HIGHER, TRIALS = "higher interactions", "randomness of trials"
"""The names of the components that are no parameter and no pair of parameters."""

Factors = tuple[str, ...]


class Contributions(NamedTuple):
    """The contributions of the parameters of a sweep.

    Attributes:
        levels: problem, factor, level and ``chance``, the mean over the combinations with that value.
        effects: problem, component and ``share`` of the variance of the chances of single trials. Components are the
            parameters, their pairs as "a × b", :data:`HIGHER` and :data:`TRIALS`; their shares add up to 1, and those
            of parts without effect scatter about 0. Shares are missing where a combination has a single trial, or all
            trials tie.
        tests: :func:`level_tests`, with ``p_here``, of :func:`permutation_test` over the blocks of all problems,
            adjusted over the parameters, below which p_holm then never is, and ``worse``, a list of the values of a
            parameter that matters which are shown to end higher than the best one: by the test of the mean A12 over
            blocks, Bonferroni over all pairs of values of all parameters.
        left_out: the problems on which a combination has no trial.
    """

    levels: pd.DataFrame
    effects: pd.DataFrame
    tests: pd.DataFrame
    left_out: list[str]


Group = dict[Levels, Floats]  # the values of each combination on an instance


def contributions(frame: pd.DataFrame, sweep: Sweep) -> Contributions:
    """Return the contributions of a sweep's parameters on each problem; the sweep must lack no combination."""
    factors = {name: levels for name, levels in sweep.factors.items() if len(levels) > 1}
    chosen = {
        tuple(level for name, level in zip(sweep.factors, levels, strict=True) if name in factors): label
        for levels, label in sweep.labels.items()
    }
    own = frame[frame["optimizer"].isin(list(chosen.values()))]
    place = {label: number for number, label in enumerate(labels(own, "optimizer"))}
    levels, shares, left_out, compared = [], [], [], list[list[Group]]()
    for problem, instances in strata(own).items():
        groups = [{key: group[place[label]] for key, label in chosen.items()} for group in instances if place]
        samples = {key: np.concatenate([group[key] for group in groups]) for key in chosen if groups}
        if not samples or not min(map(len, samples.values())):
            if any(map(len, samples.values())):
                left_out.append(problem)
            continue
        compared.append(groups)
        chances_of = dict(zip(samples, chances(list(samples.values())), strict=True))
        means = [float(chances_of[key].mean()) for key in product(*factors.values())]
        parts = decomposed(np.reshape(means, [len(values) for values in factors.values()]))
        for axis, (name, own_levels) in enumerate(factors.items()):
            main = 0.5 + parts[(axis,)].ravel()
            levels += [(problem, name, level, chance) for level, chance in zip(own_levels, main, strict=True)]
        shares += [(problem, *part) for part in _shares(chances_of, parts, list(factors)).items()]
    by_level = pd.DataFrame(levels, columns=["problem", "factor", "level", "chance"])
    tests = level_tests(by_level)
    here = holm(np.array([permutation_test(_ranked(compared, factors, name)) for name in tests["factor"]], dtype=float))
    level = ALPHA / max(sum(comb(len(values), 2) for values in factors.values()), 1)
    worse: list[Any] = [
        [*_worse(compared, factors, str(row.factor), str(row.best), level)] if row.best and p <= ALPHA else []
        for row, p in zip(tests.itertuples(), here, strict=True)
    ]
    p_holm = np.maximum(tests["p_holm"], here)
    shares_of = pd.DataFrame(shares, columns=["problem", "component", "share"])
    return Contributions(
        by_level, shares_of, tests.assign(p_here=here, p_holm=p_holm, worse=pd.Series(worse, dtype=object)), left_out
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


def permutation_test(blocks: Sequence[Sequence[Floats]], seed: int = 0) -> float:
    """Return p of the test that, in every block, the samples of all values of a parameter have one distribution.

    Each block holds a sample for each value, all else being equal. The statistic adds the variation between the means
    of the values over all blocks to that within each block, over the root of their number, so that both weigh the same
    where nothing has an effect: effects count whose direction differs from block to block, and with single trials those
    that do not (Pesarin and Salmaso 2010, Permutation Tests for Complex Data). Values are exchanged within blocks.
    """
    rng, trials = np.random.default_rng(seed), sum(len(sample) for block in blocks for sample in block)
    number = int(np.clip(WORK // max(trials, 1), *PERMUTATIONS))
    apart = np.zeros(1 + number)  # the first is that of the samples as they are
    over_all, weights = np.zeros((1 + number, len(blocks[0]))), np.zeros(len(blocks[0]))
    for block in blocks:
        sizes = np.array([len(sample) for sample in block])
        values = np.tile(np.concatenate(block) - np.mean(np.concatenate(block)), (1 + number, 1))
        rng.permuted(values[1:], axis=1, out=values[1:])
        sums = np.add.reduceat(values, np.cumsum(sizes) - sizes, axis=1)
        apart += (sums**2 / sizes).sum(axis=1)
        over_all, weights = over_all + sums, weights + sizes
    found = apart / np.sqrt(len(blocks)) + (over_all**2 / weights).sum(axis=1)
    return float(np.mean(found >= found[0] - 1e-9))


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


def _ranked(compared: Sequence[Sequence[Group]], factors: Mapping[str, Levels], name: str) -> list[list[Floats]]:
    """Return the blocks of a parameter with ranks among all trials of an instance, from 0 to 1, in place of values."""
    blocks = []
    for group in (group for groups in compared for group in groups):
        ranks = rankdata(np.concatenate([*group.values()]))
        ends = np.cumsum([len(values) for values in group.values()])[:-1]
        blocks += _blocks(dict(zip(group, np.split(ranks / len(ranks), ends), strict=True)), factors, name)
    return blocks


def _worse(
    compared: Sequence[Sequence[Group]], factors: Mapping[str, Levels], name: str, best: str, level: float
) -> Iterator[str]:
    """Yield the values of a parameter that are shown to end higher than the best one, in the mean over blocks."""
    place = factors[name].index(best)
    for other, value in enumerate(factors[name]):
        pairs = [
            stratified([effects(block[place][np.newaxis], block[other][np.newaxis]) for block in instances])
            for groups in compared
            for instances in zip(*(_blocks(group, factors, name) for group in groups), strict=True)
        ]
        every = stacked(pairs)
        if other != place and every.a12.mean() > 0.5 and float(p_of_means(every)[0]) <= level:
            yield value


def _blocks(samples: Group, factors: Mapping[str, Levels], name: str) -> list[list[Floats]]:
    """Return the samples of each value of a parameter, by the combinations of all others."""
    axis = list(factors).index(name)
    blocks: dict[Levels, list[Floats]] = {}
    for key in product(*factors.values()):
        blocks.setdefault(key[:axis] + key[axis + 1 :], []).append(samples[key])
    return list(blocks.values())


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
