"""Table 7.2: the mean fitting error in rpm, compared with the published one."""

import re
from collections.abc import Iterable
from dataclasses import replace
from importlib.resources import files
from math import comb
from pathlib import Path

import pandas as pd

from bench import Study
from bench.analysis import ALPHA, comparison_matrix, pairwise_tests, summarise, table
from bench.report import Section, Table, leaders, speaker
from bench.reproduce.section import section
from bench.reproduce.table import PaperTable, read
from bench.topics import StoredResults

SAY = speaker(__package__)
TITLE = "Fitting error (thesis Table 7.2)"
SWARMS = ("alo", "goa", "da", "gwo")  # the columns of Table 7.2
EXTRA = "cma-es"
ORDER = ("gwo", "alo", "da", "goa")  # from the best to the worst, as published
PUBLISHED_TRIALS, PUBLISHED_BUDGET, PUBLISHED_AGENTS = 30, 60_000, 300


def sections(results: StoredResults, frame: pd.DataFrame) -> list[Section]:
    """Return the section on Table 7.2, none without one of its algorithms or with errors in another unit than rpm."""
    study = results.study
    columns, rows = algorithms(study), datasets(study)
    swarms = [columns[name] for name in SWARMS if name in columns]
    if not swarms or not rows:
        return []
    pairs = pairwise_tests(part(frame, rows, swarms))
    means, table = table_7_2(frame, pairs, columns, rows)
    text = swarm_tests(pairs, study)
    if not re.search("thesis|published", study.name.lower()):
        return [Section(TITLE, text, (table,))]
    judged = section(results, of_study(study, columns, rows), TITLE, "table-7-2-published")
    text = (*judged.text, *sentences(means), *unequal(study), *text)
    return [Section(TITLE, text, (table, *judged.items))]


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
    frame: pd.DataFrame, pairs: pd.DataFrame, columns: dict[str, str], rows: dict[str, int]
) -> tuple[pd.DataFrame, Table]:
    """Return the mean errors by dataset and plug-in name, and the table with the thesis's marks.

    As in the thesis, bold and italics compare the swarms alone, whose tests are ``pairs``. ``columns`` are from
    :func:`algorithms`, ``rows`` from :func:`datasets`.
    """
    summary = summarise(part(frame, rows, columns.values()))
    swarms = summary[summary["optimizer"] != columns.get(EXTRA)]
    matrix = comparison_matrix(swarms, pairs, statistic="mean", by="value")
    named = {label: name for name, label in columns.items()}
    means, bold, italic = (
        _by_dataset(part, named, rows)
        for part in (table(summary, "mean"), table(matrix, "best"), table(matrix, "alike"))
    )
    shown, bold, italic = (part.rename(columns=str.upper) for part in (means, bold, italic))
    marked = Table(
        "table-7-2",
        "Mean fitting error in rpm by dataset (thesis Table 7.2).",
        shown,
        bold,
        italic,
        decimals=3,
        note="Bold: the lowest mean of the four swarms. Italics: an exact Kolmogorov-Smirnov test at "
        f"{ALPHA:g} (raw p, as in the thesis) cannot distinguish it from the best swarm. CMA-ES, where "
        "present, is shown beside them and not marked.",
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


def _holders(means: pd.DataFrame, extreme: str) -> str:
    """Return in how many rows each algorithm has the "lowest" or the "highest" mean, as a clause."""
    whole = means.dropna().rename(columns=str.upper)
    means_of_rows = whole.min(axis=1) if extreme == "lowest" else whole.max(axis=1)
    return leaders(whole.eq(means_of_rows, axis=0), f"the {extreme} mean")


def sentences(means: pd.DataFrame) -> list[str]:
    """Return sentences on the order of the means, beside that of the published ones of the same datasets."""
    if not set(ORDER) <= set(means.columns):
        return []
    printed = published()
    swarms = means.loc[means.index.isin(printed.index), list(ORDER)]
    theirs = printed.loc[swarms.index, list(ORDER)]
    holders = [_holders(each, extreme) for extreme in ("lowest", "highest") for each in (swarms, theirs)]
    return [
        SAY("order", ORDER, ordered(swarms), len(swarms), ordered(theirs)),
        SAY("extremes", *holders, printed.idxmax(axis=1).value_counts()),
    ]


def other_conditions(study: Study) -> str:
    """Return a sentence on the study's trials and budget where they are not the published ones, else ""."""
    if (study.trials, study.budget.number) == (PUBLISHED_TRIALS, PUBLISHED_BUDGET):
        return ""
    return SAY("other_conditions", study, PUBLISHED_TRIALS, PUBLISHED_BUDGET)


def swarm_tests(pairs: pd.DataFrame, study: Study) -> tuple[str, ...]:
    """Return how many pairs of swarms a test distinguishes; the thesis distinguishes most.

    Whether this run agrees depends on its number of trials: with few of them no test can be significant.
    """
    if pairs.empty:
        return ()
    # The smallest exact p of two samples is that of complete separation: 2 of all arrangements.
    least = min(2 / comb(n + m, n) for n, m in zip(pairs["n_first"], pairs["n_second"], strict=True))
    if least > ALPHA:
        return (SAY("too_few", study.trials),)
    apart = int((pairs["ks_p"] <= ALPHA).sum())
    return (SAY("distinguished", ALPHA, apart, len(pairs), other_conditions(study)),)


def unequal(study: Study) -> tuple[str, ...]:
    """Return a sentence where the study gives CMA-ES another handling or start than the swarms, as the thesis does."""
    names = algorithms(study).values()
    options = [entry.options for entry in study.optimizers if entry.label in names]
    if len({(chosen.get("handling", "repair"), chosen.get("start", "random")) for chosen in options}) < 2:
        return ()
    return (SAY("unequal"),)
