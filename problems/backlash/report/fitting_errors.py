"""Table 7.2: the mean fitting error in rpm, compared with the published one."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from importlib.resources import files
from math import comb
from pathlib import Path

import pandas as pd

from bench import Study
from bench.analysis import ALPHA, comparison_matrix, pairwise_tests, summarise, table
from bench.report import Table, Typography
from bench.reproduce.section import judged
from bench.reproduce.table import PaperTable, read
from bench.reproduce.verdict import DIFFERS, Judgement, sentences, unjudged
from bench.topics import StoredResults
from problems.backlash.report import words

SWARMS = ("alo", "goa", "da", "gwo")  # the columns of Table 7.2
EXTRA = "cma-es"
ORDER = ("gwo", "alo", "da", "goa")  # from the best to the worst, as published
PUBLISHED_AGENTS = 300


def compared(results: StoredResults, frame: pd.DataFrame) -> tuple[list[str], list[Table]]:
    """Return Table 7.2 beside the printed one, with sentences; none without its algorithms or in another unit."""
    study = results.study
    columns, rows = algorithms(study), datasets(study)
    swarms = [columns[name] for name in SWARMS if name in columns]
    if not swarms or not rows:
        return [], []
    pairs = pairwise_tests(part(frame, rows, swarms))
    known = re.search("thesis|published", study.name.lower())
    judgements = judged(of_study(study, columns, rows), results) if known else []
    means, table = table_7_2(frame, pairs, columns, rows, judgements)
    beside = [*sentences(judgements), *unjudged(judgements)] if judgements else []
    said = [*order(means), *swarm_tests(pairs, study), *(f"{line[0].upper()}{line[1:]}." for line in beside)]
    return said, [table]


def algorithms(study: Study) -> dict[str, str]:
    """Return the label of each of the thesis's algorithms in the study, by plug-in name.

    Of several, the first with the thesis's 300 agents, or the first.
    """
    likely = sorted(study.optimizers, key=lambda entry: entry.options.get("agents") != PUBLISHED_AGENTS)
    labels = {entry.name: entry.label for entry in reversed(likely)}
    return {name: labels[name] for name in (*SWARMS, EXTRA) if name in labels}


def datasets(study: Study) -> dict[str, int]:
    """Return the dataset number of each problem label that is a signature-NN or published-NN in rpm."""
    numbers = {entry.label: re.fullmatch(r"(?:signature|published)-(\d+)", entry.name) for entry in study.problems}
    in_rpm = {entry.label for entry in study.problems if entry.options.get("unit") == "rpm"}
    return {label: int(match[1]) for label, match in numbers.items() if match and label in in_rpm}


def paper() -> PaperTable:
    """Return the thesis's Table 7.2 as it is printed: mean RMSE in rpm over 30 runs, datasets 3 to 20 by algorithm."""
    return read(Path(str(files("problems.backlash.report").joinpath("table_7_2.csv"))))


def of_study(study: Study, columns: dict[str, str], rows: dict[str, int]) -> PaperTable:
    """Return the printed cells of a study's algorithms and datasets, named as the study names them."""
    named = {name.upper(): label for name, label in columns.items()}
    problems = {str(rows[entry.label]): entry.name for entry in study.problems if entry.label in rows}
    cells = [cell for cell in paper().cells if cell.optimizer in named and cell.function in problems]
    settings = {**paper().settings, "optimizers": named, "functions": problems}
    return replace(paper(), cells=tuple(cells), settings=settings)


def published() -> pd.DataFrame:
    """Return the means of Table 7.2, datasets 3 to 20 by plug-in name."""
    cells = [(int(cell.function), cell.optimizer.lower(), cell.numbers["mean"].value) for cell in paper().cells]
    table = pd.DataFrame(cells, columns=["dataset", "optimizer", "mean"])
    return table.pivot(index="dataset", columns="optimizer", values="mean")[list(SWARMS)].rename_axis(columns=None)


def table_7_2(
    frame: pd.DataFrame,
    pairs: pd.DataFrame,
    columns: dict[str, str],
    rows: dict[str, int],
    judgements: Sequence[Judgement] = (),
) -> tuple[pd.DataFrame, Table]:
    """Return the mean errors by dataset and plug-in name, and the table with the thesis's marks.

    As in the thesis, bold and italics compare the swarms alone, whose tests are ``pairs``. ``columns`` are from
    :func:`algorithms`, ``rows`` from :func:`datasets`, ``judgements`` from :func:`bench.reproduce.section.judged`.
    """
    summary = summarise(part(frame, rows, columns.values()))
    swarms = summary[summary["optimizer"] != columns.get(EXTRA)]
    matrix = comparison_matrix(swarms, pairs, statistic="mean")
    named = {label: name for name, label in columns.items()}
    means, bold, italic = (
        _by_dataset(part, named, rows)
        for part in (table(summary, "mean"), table(matrix, "best"), table(matrix, "alike"))
    )
    shown = means.rename(columns=str.upper)
    printed = published().reindex(means.index).rename(columns=lambda name: f"{name.upper()} printed")
    for place, name in enumerate([name for name in SWARMS if name in means], start=1):
        shown.insert(2 * place - 1, f"{name.upper()} printed", printed[f"{name.upper()} printed"])
    marks = pd.DataFrame("", index=shown.index, columns=shown.columns)
    for each in judgements:
        if each.verdict == DIFFERS:
            marks.loc[int(each.cell.function), each.cell.optimizer] = "≠"
    marked = Table(
        "table-7-2",
        "Mean fitting error in rpm by dataset, beside the printed one (thesis Table 7.2).",
        shown,
        Typography(bold=bold.rename(columns=str.upper), italic=italic.rename(columns=str.upper), marks=marks),
        decimals=3,
        note="Bold: the lowest mean of the four swarms. Italics: an exact Kolmogorov-Smirnov test at "
        f"{ALPHA:g} (raw p, as in the thesis) cannot distinguish it from the best swarm."
        + (" ≠: it differs from the printed one (5% over the table)." if judgements else ""),
    )
    return means, marked


def part(frame: pd.DataFrame, problems: Iterable[str], optimizers: Iterable[str]) -> pd.DataFrame:
    """Return the trials of these problems and optimizers, which stay the categories of the frame even without any."""
    for column, labels in (("problem", set(problems)), ("optimizer", set(optimizers))):
        frame = frame[frame[column].isin(labels)]
        order = [label for label in frame[column].cat.categories if label in labels]
        frame = frame.assign(**{column: frame[column].cat.set_categories(order)})
    return frame


def _by_dataset(table: pd.DataFrame, named: dict[str, str], rows: dict[str, int]) -> pd.DataFrame:
    """Return a matrix of labels as dataset numbers by plug-in names, in the thesis's order."""
    table = table.rename(index=rows, columns=named).rename_axis(index="dataset").sort_index()
    return table[[name for name in (*SWARMS, EXTRA) if name in table]]


def ordered(means: pd.DataFrame) -> int:
    """Return in how many rows GWO < ALO < DA < GOA holds."""
    better_to_worse = means[list(ORDER)].diff(axis=1).iloc[:, 1:]
    return int((better_to_worse > 0).all(axis=1).sum())


def order(means: pd.DataFrame) -> list[str]:
    """Return a sentence on the order of the means, beside that of the published ones of the same datasets."""
    printed = published()
    if not set(ORDER) <= set(means.columns):
        return []
    swarms = means.loc[means.index.isin(printed.index), list(ORDER)]
    return [words.order(ORDER, ordered(swarms), len(swarms), ordered(printed.loc[swarms.index, list(ORDER)]))]


def swarm_tests(pairs: pd.DataFrame, study: Study) -> list[str]:
    """Return how many pairs of swarms a test distinguishes, or that no test of so few trials can."""
    if pairs.empty:
        return []
    # The smallest exact p of two samples is that of complete separation: 2 of all arrangements.
    least = min(2 / comb(n + m, n) for n, m in zip(pairs["n_first"], pairs["n_second"], strict=True))
    if least > ALPHA:
        return [words.too_few(study.trials)]
    return [words.distinguished(ALPHA, int((pairs["ks_p"] <= ALPHA).sum()), len(pairs))]
