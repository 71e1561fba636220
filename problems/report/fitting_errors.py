"""Table 7.2: the mean fitting error in rpm, and how it compares with the published one."""

from __future__ import annotations

import re
from importlib.resources import files

import pandas as pd

from bench import Results, Study
from bench.analysis import comparison_matrix, in_study_order, pairwise_tests, summarise
from bench.report import Section, Table
from bench.report.words import count, listing

SWARMS = ("alo", "goa", "da", "gwo")  # the columns of Table 7.2
EXTRA = "cma-es"
ORDER = ("gwo", "alo", "da", "goa")  # from the best to the worst, as published
NEAR = 0.35  # an independent implementation lands within about a third of the published means
PUBLISHED_TRIALS, PUBLISHED_BUDGET = 30, 60_000


def sections(results: Results) -> list[Section]:
    """Return the section on Table 7.2, none without one of its algorithms or with errors in another unit than rpm."""
    columns, rows = algorithms(results.study), datasets(results.study)
    if not set(SWARMS) & set(columns) or not rows:
        return []
    means, table = table_7_2(results, columns, rows)
    if "thesis" not in results.study.name.lower():
        return [Section("Fitting error (thesis Table 7.2)", items=(table,))]
    beside = compare(means, published())
    return [
        Section(
            "Fitting error (thesis Table 7.2)",
            (*in_words(means, beside), conditions(results.study)),
            (table, side_by_side(means, beside)) if len(beside) else (table,),
        )
    ]


def algorithms(study: Study) -> dict[str, str]:
    """Return the label of each of the thesis's algorithms in the study, by plug-in name; the first of several."""
    labels: dict[str, str] = {}
    for entry in study.optimizers:
        labels.setdefault(entry.name, entry.label)
    return {name: labels[name] for name in (*SWARMS, EXTRA) if name in labels}


def datasets(study: Study) -> dict[str, int]:
    """Return the dataset number of each problem label that is a signature-NN in rpm."""
    numbers = {entry.label: re.fullmatch(r"signature-(\d+)", entry.name) for entry in study.problems}
    in_rpm = {entry.label for entry in study.problems if entry.options.get("unit") == "rpm"}
    return {label: int(match[1]) for label, match in numbers.items() if match and label in in_rpm}


def published() -> pd.DataFrame:
    """Return the thesis's Table 7.2: mean RMSE in rpm over 30 runs, datasets 3 to 20 by algorithm."""
    with files("problems.report").joinpath("table_7_2.csv").open(encoding="utf-8") as file:
        return pd.read_csv(file, index_col="dataset")


def table_7_2(results: Results, columns: dict[str, str], rows: dict[str, int]) -> tuple[pd.DataFrame, Table]:
    """Return the mean errors by dataset and plug-in name, and the table with the thesis's marks.

    As in the thesis, bold and italics compare the swarms alone.
    """
    frame = in_study_order(results.frame, results.study)
    frame = frame[frame["problem"].isin(list(rows)) & frame["optimizer"].isin(list(columns.values()))]
    swarms = frame[frame["optimizer"] != columns.get(EXTRA)]
    frame, swarms = (part.assign(**_used_categories(part)) for part in (frame, swarms))
    means = comparison_matrix(summarise(frame), pairwise_tests(frame)).mean
    marked = comparison_matrix(summarise(swarms), pairwise_tests(swarms))
    bold, italic = marked.best, marked.alike
    named = {label: name for name, label in columns.items()}
    means, bold, italic = (_by_dataset(part, named, rows) for part in (means, bold, italic))
    shown = [part.rename(columns=str.upper) for part in (means, bold, italic)]
    table = Table(
        "table-7-2",
        "Mean fitting error in rpm by dataset (thesis Table 7.2).",
        shown[0],
        bold=shown[1],
        italic=shown[2],
        decimals=3,
        note="Bold: the lowest mean of the four swarms. Italics: an exact Kolmogorov-Smirnov test at 0.05 cannot "
        "tell it from the best swarm’s distribution. CMA-ES, where present, is shown beside them and not marked.",
    )
    return means, table


def _used_categories(frame: pd.DataFrame) -> dict[str, pd.Series]:
    return {column: frame[column].cat.remove_unused_categories() for column in ("problem", "optimizer")}


def _by_dataset(table: pd.DataFrame, named: dict[str, str], rows: dict[str, int]) -> pd.DataFrame:
    """Return a matrix of labels as dataset numbers by plug-in names, in the thesis's order."""
    table = table.rename(index=rows, columns=named).rename_axis(index="dataset").sort_index()
    return table[[name for name in (*SWARMS, EXTRA) if name in table]]


def compare(means: pd.DataFrame, reference: pd.DataFrame) -> pd.DataFrame:
    """Return dataset, algorithm, mean, published and difference ((mean - published) / published) of shared cells."""
    ours = means.rename_axis(index="dataset").melt(ignore_index=False, var_name="algorithm", value_name="mean")
    theirs = reference.melt(ignore_index=False, var_name="algorithm", value_name="published")
    cells = ours.reset_index().merge(theirs.reset_index(), on=["dataset", "algorithm"])
    return cells.assign(difference=(cells["mean"] - cells["published"]) / cells["published"])


def ordered(means: pd.DataFrame) -> int:
    """Return in how many rows GWO < ALO < DA < GOA holds."""
    better_to_worse = means[list(ORDER)].diff(axis=1).iloc[:, 1:]
    return int((better_to_worse > 0).all(axis=1).sum())


def in_words(means: pd.DataFrame, cells: pd.DataFrame) -> list[str]:
    """Return what the comparison found, in sentences."""
    known = cells.dropna()
    if known.empty:
        return ["No cell of the published Table 7.2 can be compared."]
    near = int((known["difference"].abs() <= NEAR).sum())
    typical, size = known["difference"].median(), known["difference"].abs().median()
    found = (
        f"Of {count(len(known), 'cell')} shared with the published Table 7.2, {near} lie within {NEAR:.0%} of the "
        f"published mean. The median relative difference is {typical:+.1%}, its median size {size:.1%}."
    )
    text = [found]
    if set(ORDER) <= set(means.columns):
        rows = published().reindex(means.index).dropna()
        text.append(
            f"The order {' < '.join(name.upper() for name in ORDER)} holds in {ordered(means)} of {len(means)} rows; "
            f"in the published table it holds in {ordered(rows)} of these."
        )
    missing = cells[cells["mean"].isna()]
    lost = [
        f"{str(name).upper()} on dataset {k}" for name, k in zip(missing["algorithm"], missing["dataset"], strict=True)
    ]
    if lost:
        text.append(f"Without a mean, as trials failed or are missing: {listing(lost)}.")
    return text


def conditions(study: Study) -> str:
    """Return how the study's conditions stand to the published ones."""
    asked = f"{PUBLISHED_TRIALS} trials of {PUBLISHED_BUDGET:,} evaluations"
    if (study.trials, study.budget) == (PUBLISHED_TRIALS, PUBLISHED_BUDGET):
        return f"Both are means over {asked}."
    return (
        f"The published means are over {asked}; these are over {count(study.trials, 'trial')} of "
        f"{count(study.budget, 'evaluation')}, so they need not agree."
    )


def side_by_side(means: pd.DataFrame, cells: pd.DataFrame) -> Table:
    """Return the table with each algorithm's mean, its published mean and their relative difference in percent."""
    columns: dict[str, pd.Series] = {}
    for name in [name for name in SWARMS if name in means]:
        own = cells[cells["algorithm"] == name].set_index("dataset")
        title = name.upper()
        columns[title] = own["mean"]
        columns[f"{title} published"] = own["published"]
        columns[f"{title} diff. %"] = 100 * own["difference"]
    frame = pd.DataFrame(columns).rename_axis(index="dataset")
    return Table(
        "table-7-2-published",
        "Mean fitting error in rpm beside the published one, and the relative difference in percent.",
        frame,
        decimals={column: 1 if column.endswith("%") else 3 for column in columns},
    )
