"""The table of medians with their tests, a row a problem, and the files of all runs and tests."""

from __future__ import annotations

import pandas as pd

from bench import analysis
from bench.analysis.matrix import table
from bench.analysis.pairwise import seen_from
from bench.report.parts import File, Table, Typography
from bench.report.wording import row_texts
from bench.topics.findings import CROWD, FIRST, Findings
from bench.topics.runs.words import table_note

TESTS = ["a12", "p", "p_holm"]


def comparison(findings: Findings) -> Table:
    """Return the medians of the optimizers that are shown, a row a problem, beside their tests against the leader."""
    final, shown = findings.final, findings.display.shown
    medians = table(final.summary, "median").reindex(columns=shown).rename_axis("problem")
    cells = cells_of(findings)
    marks = {
        (problem, optimizer): f"{a12:.2f}{'*' if lower else ''}"
        for problem, optimizer, a12, lower in zip(
            *(cells[name] for name in ("problem", "optimizer", "a12", "lower")), strict=True
        )
        if pd.notna(a12)
    }
    ranks = table(final.chances, "rank").reindex(index=medians.index)
    first = ranks.eq(ranks.min(axis=1), axis=0).mul(ranks.min(axis=1) < ranks.max(axis=1), axis=0)
    texts = [row_texts(row) for row in medians.to_numpy(dtype=float)]
    return Table(
        "comparison",
        "The median of the best objective value, a row a problem.",
        medians,
        Typography(
            texts=pd.DataFrame(texts, medians.index, medians.columns, dtype=object),
            bold=first[shown],
            marks=pd.DataFrame({o: [marks.get((p, o), "") for p in medians.index] for o in shown}, index=medians.index),
            lost=(table(findings.trials.coverage, "failed") > 0).reindex_like(medians),
        ),
        note=table_note(findings.leader, bool(final.subject), bool(findings.trials.precisions)),
        data=cells,
        latex=True,
    )


def cells_of(findings: Findings) -> pd.DataFrame:
    """Return one row a cell: its runs, its values, its rank, and the test of the leader against it.

    ``a12`` is the chance that a run of the leader ends lower, and ``p_holm`` is p adjusted within the problem.
    """
    final = findings.final
    pairs = seen_from(final.pairs.astype({"first": object, "second": object}), findings.leader)
    tests = pairs[["problem", "second", *TESTS, "lower"]].rename(columns={"second": "optimizer"})
    cells = final.summary.merge(final.chances[["problem", "optimizer", "chance", "rank"]], on=["problem", "optimizer"])
    above = analysis.regret(final.measured_summary, findings.trials.unbeaten, ("median",))
    above = above[["problem", "optimizer", "median"]].rename(columns={"median": "median_above_optimum"})
    for more in (above, tests):
        cells = cells.merge(
            more.astype({"problem": object, "optimizer": object}), how="left", on=["problem", "optimizer"]
        )
    return cells.assign(leader=findings.leader)


def files(findings: Findings) -> tuple[File, ...]:
    """Return all runs and all tests of the study."""
    final = findings.final
    every = [
        File("tables/trials.csv", "All runs, one row a run.", findings.results.frame),
        File(
            "tables/tests.csv",
            f"The tests of {final.pairs_words} on every problem; of more than {CROWD} optimizers, of the first {FIRST} "
            "with each other one, and the clearest pair.",
            final.pairs,
        ),
        File("tables/ranking.csv", "The order of the optimizers over all problems.", final.order),
    ]
    if len(feasible := findings.trials.feasible):
        about = "The share of runs that found a feasible point, and when they did."
        every.append(File("tables/feasibility.csv", about, feasible))
    return tuple(every)
