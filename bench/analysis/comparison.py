"""One number, and one comparison of a chosen optimizer with its rivals over the problems at hand.

The number is the *chance to end lower*: on a problem, the probability that a run of one optimizer ends lower than a run
of a rival, ties counted half, a failure highest (A12); of an optimizer, its mean over the rivals; over problems, the
mean over problems, whatever the numbers of runs. It orders everything that is ordered.

Claims are of three kinds, each with its own 5%, of which no other kind knows:

- over these problems, :func:`compare`: a winner that the results name, each of its tests at 5%, as all of them must
  reject (intersection-union test; Berger 1982, Technometrics 24); or the k - 1 tests of a subject that was named before
  the results, at 5% / (k - 1) each;
- on each problem, :func:`bench.analysis.pairwise_tests`: pairs by Holm's method within the problem. Of N problems
  without any difference, N / 20 would show one;
- curves: bands that hold together with 95% (:mod:`bench.analysis.bands`).

The test over problems is stratified. Its variance is that of the runs alone, so it holds whatever the problems are, and
says nothing of further ones. It takes the variance that one A12 on all problems would have, the largest there is for
their mean (:func:`bench.analysis.direction.stratified`). Its interval holds the means that it does not reject. A cell
with a single run leaves no variance, and nothing is tested.

Runs that share a seed over problems are not independent: they may begin at the same point, or draw the same steps. All
runs of one seed are then one, and the variance is that of the sums of what each run contributes to the mean (a
linearised jackknife over seeds; Shao and Tu 1995, The Jackknife and Bootstrap), where it is the larger one, with
Student's t.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from bench.analysis.cells import labels, scores
from bench.analysis.direction import ALPHA, Effects, effects, inference, stratified, wins
from bench.analysis.standings import a12_matrix, mean_chance, ranks
from bench.analysis.strata import Places, Samples, rows, strata
from bench.contract.typing import Floats

OUTCOMES = ("better", "worse", "open")
"""What a test says of the chosen optimizer: it ends lower than the rival, higher, or neither is shown."""

COLUMNS = ("rival", "problems", "chance", "low", "high", "p", "level", "outcome")


def chances(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the chance to end lower on each problem, a row a cell: problem, optimizer, n, chance and rank.

    ``n`` are the runs; ``chance`` is the mean of A12 over the rivals that have runs on the problem, of pooled instances
    the mean of that within each; ``rank`` is 1 for the highest chance, and those that tie share their mean rank. Both
    are missing for a cell without runs.
    """
    optimizers, tables = labels(frame, "optimizer"), []
    for problem, groups in strata(frame).items():
        n = [sum(map(len, own)) for own in zip(*groups, strict=True)]
        chance = chance_within(groups)
        rank = np.full(len(n), np.nan)
        there = np.array(n, dtype=bool)
        rank[there] = ranks(chance[there])
        columns = {"problem": problem, "optimizer": optimizers, "n": n, "chance": chance, "rank": rank}
        tables.append(pd.DataFrame(columns))
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=[*["problem", "optimizer", "n"]])


def chance_within(groups: Sequence[Samples]) -> Floats:
    """Return the chance of each of k optimizers to end lower than its rivals, (k,), the mean over strata of samples."""
    there = [place for place, sample in enumerate(groups[0]) if len(sample)]
    chance = np.full(len(groups[0]), np.nan)
    if len(there) > 1:
        chance[there] = mean_chance(np.mean([a12_matrix([own[place] for place in there]) for own in groups], axis=0))
    return chance


def order(chances_of: pd.DataFrame) -> pd.DataFrame:
    """Return the order over problems, the best first: optimizer, problems, chance, place and first.

    ``chance`` is the mean over the problems on which every optimizer has runs; those that tie share their mean
    ``place``. ``first`` counts the problems on which an optimizer alone has the highest chance. ``chances_of`` are
    those of :func:`chances`.
    """
    whole = (chances_of["n"] > 0).groupby(chances_of["problem"], sort=False, observed=True).transform("all")
    complete = chances_of[whole & chances_of["chance"].notna()]
    table = pd.DataFrame({"optimizer": labels(chances_of, "optimizer"), "problems": complete["problem"].nunique()})
    by_optimizer = complete.groupby("optimizer", observed=True)
    table["chance"] = table["optimizer"].map(by_optimizer["chance"].mean()).astype(float)
    table["place"] = ranks(table["chance"].to_numpy(dtype=float))
    table["first"] = table["optimizer"].map((complete["rank"] == 1).groupby(complete["optimizer"], observed=True).sum())
    table["first"] = table["first"].fillna(0).astype(int)
    return table.sort_values("place", kind="stable", ignore_index=True)


def compare(frame: pd.DataFrame, chosen: str, *, before: bool, alpha: float = ALPHA) -> pd.DataFrame:
    """Compare a chosen optimizer with each rival over these problems, one row a rival.

    Columns: rival; problems, those on which every optimizer has runs; ``chance``, the mean over them of the chance
    that a run of the chosen one ends lower, with low to high, the interval of the test; ``p``, two-sided, that it is
    0.5; ``level`` of the test, and its ``outcome``, one of :data:`OUTCOMES`. The interval holds 0.5 just where the
    outcome is "open". Without a problem, or where a cell has a single run, nothing is tested: p is 1, and no
    interval is known.

    Args:
        frame: the tidy frame; with a column ``seed``, runs of one seed on several problems count as one.
        chosen: the subject, the leader, a version or a candidate.
        before: whether it was named before the results: then each test is a claim, at ``alpha`` over their number.
            Else the level of each is ``alpha``, and the claim is :func:`wins_all`.
        alpha: of all claims together.
    """
    every, places = labels(frame, "optimizer"), rows(frame)
    own, rivals = every.index(chosen), [label for label in every if label != chosen]
    level = alpha / max(len(rivals), 1) if before else alpha
    complete = [groups for groups in places.values() if all(map(len, groups[0]))]  # who has runs has some in each
    values = np.asarray(scores(frame, merge=True), dtype=np.float64)
    seeds = frame["seed"].to_numpy() if "seed" in frame else None
    table = []
    for rival in rivals:
        pairs = [[(group[own], group[every.index(rival)]) for group in groups] for groups in complete]
        table.append((rival, len(complete), *_tested(pairs, values, seeds, level)))
    return pd.DataFrame(table, columns=list(COLUMNS))


def wins_all(comparison: pd.DataFrame) -> bool:
    """Return whether an optimizer that the results named is a winner: every test of :func:`compare` shows it better."""
    return bool(len(comparison)) and bool((comparison["outcome"] == OUTCOMES[0]).all())


def _tested(
    pairs: Sequence[Sequence[Places]], values: Floats, seeds: Floats | None, level: float
) -> tuple[float, float, float, float, float, str]:
    """Return chance, low, high, p, level and outcome of two optimizers, by the places of their runs in each stratum."""
    if not pairs:
        return np.nan, np.nan, np.nan, 1.0, level, OUTCOMES[2]
    samples = [[[values[cell] for cell in both] for both in of] for of in pairs]
    found, freedom = (
        over_problems([[effects(one[np.newaxis], two[np.newaxis]) for one, two in of] for of in samples]),
        np.inf,
    )
    seeds_of = None if seeds is None else [[[seeds[cell] for cell in both] for both in of] for of in pairs]
    if seeds_of is not None and shared(seeds_of):
        factor, freedom = inflation(samples, seeds_of)
        found = found._replace(ratio=found.ratio * factor)
    (low,), (high,), (p,) = inference(found, level, freedom)
    chance = float(found.a12[0])
    outcome = OUTCOMES[2] if p > level else OUTCOMES[int(chance < 0.5)]
    return chance, float(low), float(high), float(p), level, outcome


def over_problems(found: Sequence[Sequence[Effects]]) -> Effects:
    """Return the mean over problems of the mean over their strata, of estimates of one shape each."""
    return stratified([stratified(of_problem) for of_problem in found])


def shared(seeds: Sequence[Sequence[Samples]]) -> bool:
    """Return whether any run of an optimizer has the seed of another one of its runs on another problem or instance."""
    for place in range(2):
        known = pd.Series(np.concatenate([group[place] for groups in seeds for group in groups])).dropna()
        if known.duplicated().any():
            return True
    return False


def shared_by(frame: pd.DataFrame) -> list[str]:
    """Return the optimizers of which runs on different problems have the same seed."""
    cells = frame[["problem", "optimizer", "seed"]].astype(object).dropna().drop_duplicates()
    return list(dict.fromkeys(cells.loc[cells.duplicated(["optimizer", "seed"]), "optimizer"]))


def inflation(samples: Sequence[Sequence[Samples]], seeds: Sequence[Sequence[Samples]]) -> tuple[float, float]:
    """Return by how much runs of one seed make the variance of a mean larger, at least 1, and its degrees of freedom.

    What a run contributes is the mean of its wins less A12, over the runs of its cell. Without the seed of a run, it is
    one of its own.
    """
    contributions, numbers, apart = [], [], 0.0
    for groups, seeds_of in zip(samples, seeds, strict=True):
        for (this, other), both in zip(groups, seeds_of, strict=True):
            won_of = wins(this, other)
            for axis, (own, seeds_own) in enumerate(zip((this, other), both, strict=True)):
                one = (won_of.mean(axis=1 - axis) - won_of.mean()) / len(own) / len(groups)
                contributions.append(one)
                numbers.append(np.asarray(seeds_own, dtype=object))
                apart += float((one**2).sum()) * len(own) / max(len(own) - 1, 1)
    every, number = np.concatenate(contributions), pd.Series(np.concatenate(numbers))
    alone = number.isna()
    codes = pd.factorize(number)[0]
    codes[alone] = codes.max(initial=-1) + 1 + np.arange(int(alone.sum()))
    sums = np.bincount(codes, weights=every)
    groups_of = len(sums)
    if groups_of < 2 or not apart:
        return np.nan if groups_of < 2 else 1.0, 1.0
    return max(float((sums**2).sum()) * groups_of / (groups_of - 1) / apart, 1.0), groups_of - 1.0
