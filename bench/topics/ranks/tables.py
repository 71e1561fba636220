"""The ranking as tables: the rank of every optimizer on every problem as a map, and the ranking over all problems."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import pandas as pd

from bench.analysis.compare import table as table_of
from bench.plots import style
from bench.report.parts import Table
from bench.report.wording import count
from bench.topics.findings import Final, Findings, Trials

MOST_PAIRED = 30  # optimizers of a matrix of pairs
MOST_BLOCKS = 20  # columns of the map of a suite: optimizers times dimensions
TESTED = (
    "; separable: on which it is separably lower than every rival; worse: on which a rival is separably lower than it."
)
HEAD = 20  # letters of an optimizer there
UPRIGHT_HEAD = 28  # of a problem, above a column of a map whose rows are the optimizers
NEAR = "≈"  # beside the rank of an optimizer that no test separates from the first


def rank_map(findings: Findings) -> Table:
    """Return the rank of each optimizer on each problem, darker for a better one; optimizers in order of mean rank.

    Many optimizers, or those of long names, are the rows, as they do not fit beside each other. A suite of many
    problems has a row for each function and, for each optimizer, a column for each dimension.
    """
    order = findings.final.ranked
    ranks = table_of(findings.final.standings, "rank")[order].dropna(how="all")
    best = table_of(findings.final.matrix, "best").astype(bool)[order].loc[ranks.index]
    near = _beside_first(findings.final).loc[ranks.index, order] & ~best
    notes = ["Bold: ranked first.", "Ties share their mean rank."]
    notes += [f"{NEAR}: no test separates it from the first."] if near.any(axis=None) else []
    notes += ["Empty: not compared."] if ranks.isna().any(axis=None) else []
    places = _functions(findings.trials, ranks.index, len(order))
    rows = "function, a column for each dimension d" if places else "problem"
    table = Table(
        "rank-map",
        f"Rank of each optimizer on each {rows}, by its chance to end lower.",
        ranks.map(lambda rank: "" if pd.isna(rank) else f"{rank:g}").astype(object),
        bold=best,
        marks=near.map(lambda beside: NEAR if beside else ""),
        shades=(ranks - 1) / max(len(order) - 1, 1),
        note=" ".join(notes),
        data=findings.final.standings,
    )
    heads = style.names(order, HEAD)
    if places:
        return _by_function(table, places, heads)
    if findings.display.upright:
        short = style.names(ranks.index, UPRIGHT_HEAD)
        table = table.arranged(lambda frame: frame.rename(index=short, columns=heads).T)
        return table.arranged(lambda frame: frame.rename_axis(index="optimizer", columns=None))
    return table.arranged(lambda frame: frame.rename(columns=heads).rename_axis("problem"))


def _functions(trials: Trials, problems: Iterable[str], optimizers: int) -> dict[tuple[str, int], str]:
    """Return the problem of each function and dimension of a suite whose map has a row a function; {} for any other."""
    if not trials.many:
        return {}
    features = {label: trials.known[label].features for label in problems}
    suites = {str(of_problem.get("suite", "")) for of_problem in features.values()}
    places = {}
    for label, of_problem in features.items():
        function = str(of_problem.get("function", ""))
        name = f"{of_problem.get('suite', '')} {function}" if len(suites) > 1 else function
        places[name, trials.dimensions.get(label, 0)] = label
    dimensions = {dimension for _, dimension in places}
    named = all("function" in of_problem for of_problem in features.values())
    whole = len(places) == len(features) and named and 0 not in dimensions
    fits = len(dimensions) > 1 and optimizers * len(dimensions) <= MOST_BLOCKS
    return places if whole and fits else {}


def _by_function(table: Table, places: Mapping[tuple[str, int], str], names: Mapping[str, str]) -> Table:
    """Return a table of problems by optimizers as one of functions by optimizers and dimensions."""
    functions, dimensions = list(dict.fromkeys(name for name, _ in places)), sorted({size for _, size in places})
    heads = {(label, size): f"{name}, d = {size}" for label, name in names.items() for size in dimensions}
    cells = {
        (function, head): (places[function, size], label)
        for (label, size), head in heads.items()
        for function in functions
        if (function, size) in places
    }

    def arrange(frame: pd.DataFrame) -> pd.DataFrame:
        empty = {"O": "", "b": False, "f": float("nan")}[frame.dtypes.iloc[0].kind]
        columns = {
            head: [frame.at[cells[function, head]] if (function, head) in cells else empty for function in functions]
            for head in heads.values()
        }
        return pd.DataFrame(columns, index=pd.Index(functions, name="function"))

    return table.arranged(arrange)


def pair_matrix(findings: Findings) -> Table:
    """Return the chance that a run of the row ends lower than one of the column, the best optimizers in their order."""
    order, pairs = findings.final.ranked[:MOST_PAIRED], findings.final.overall
    wide = pairs.pivot(index="first", columns="second", values="probability").reindex(
        index=findings.trials.optimizers, columns=findings.trials.optimizers
    )
    chances = wide.fillna(1 - wide.T).loc[order, order]
    tests = pairs[pairs["significant"]]
    clear = pd.DataFrame(False, index=order, columns=order)
    for first, second in zip(tests["first"], tests["second"], strict=True):
        if first in clear.index and second in clear.index:
            clear.at[first, second] = clear.at[second, first] = True
    texts = chances.map(lambda chance: "" if pd.isna(chance) else f"{chance:.2f}").astype(object)
    left = len(findings.trials.optimizers) - len(order)
    of_best = f" The {len(order)} best; the file has the {left} others." if left else ""
    return Table(
        "pair-matrix",
        "The chance that a run of the optimizer of the row ends lower than one of that of the column, averaged over "
        f"problems.{of_best}",
        texts.rename_axis(index="optimizer", columns=None),
        bold=clear,
        shades=1 - chances,
        note="Bold: the pair differs significantly on these problems (Holm).",
        data=pairs,
    )


def turned(table: Table, findings: Findings) -> Table:
    """Return a table of problems by optimizers with the optimizers as rows, best first, where there are many.

    Columns that are no optimizers are left out.
    """
    if not findings.display.upright:
        return table
    order = [label for label in findings.final.ranked if label in table.frame]

    def turn(frame: pd.DataFrame) -> pd.DataFrame:
        return frame.reindex(columns=order).T.rename_axis("optimizer")

    note = table.note.replace("the row", "the column").replace("a row", "a column")
    return replace(table.arranged(turn), note=note)


def _beside_first(final: Final) -> pd.DataFrame:
    """Return flags, problems by optimizers, of those that no test separates from a first one of the problem."""
    best = table_of(final.matrix, "best").astype(bool)
    pairs = final.pairs[(final.pairs["lower"] == "") & final.pairs["testable"].astype(bool)]  # else nothing is tested
    pairs = pairs[pairs[["n_first", "n_second"]].min(axis=1) > 0]
    row = best.index.get_indexer(pd.Index(pairs["problem"]))
    first, second = (best.columns.get_indexer(pd.Index(pairs[name])) for name in ("first", "second"))
    first_ones = best.to_numpy()
    near = first_ones.copy()
    for column, rival in ((first, second), (second, first)):
        beside = first_ones[row, column]
        near[row[beside], rival[beside]] = True
    return pd.DataFrame(near, index=best.index, columns=best.columns)


def ranking_table(findings: Findings) -> Table:
    """Return the chances, mean ranks and first places with their intervals, best first."""
    table = findings.final.ranking.set_index("optimizer").loc[findings.final.ranked]
    problems = int(table["problems"].iloc[0])
    shown = pd.DataFrame(
        {
            "chance": table["chance"],
            "mean rank": table["mean_rank"],
            "first": table["first"],
            "separable": table["separable"],
            "worse": table["worse"],
        },
        index=table.index,
    )
    if findings.final.subject:  # of rivals, nothing but their pair with it is tested
        shown = shown.drop(columns=["separable", "worse"])
    return Table(
        "ranking",
        f"The ranking over {count(problems, 'problem')}.",
        shown,
        decimals=2,
        note="Chance: that a run of it ends lower than a run of a rival, in the mean over rivals and problems. "
        "First: problems on which it is ranked first, unless half of the optimizers or more share that place"
        + ("." if findings.final.subject else TESTED),
        data=table.reset_index(),
    )
