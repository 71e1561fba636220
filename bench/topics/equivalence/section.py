"""Practical equality: which optimizers differ by less than the study's region of practical equivalence."""

from __future__ import annotations

import pandas as pd

from bench.analysis.direction import ALPHA
from bench.analysis.equivalence import FEWEST, differences, probabilities
from bench.plots import style
from bench.plots.equivalence import equivalence_bars
from bench.plots.ranks import forest_names
from bench.report.parts import Figure, Part, Section, Table
from bench.report.wording import count, listing
from bench.topics.findings import Final, Findings
from bench.topics.topic import Topic

TITLE = "Practical equality"
SURE = 0.95  # a probability from which on the text names a pair


def beside_rope(findings: Findings) -> pd.DataFrame:
    """Return the differences of each pair on each problem beside the rope; none without a rope."""
    rope = findings.final.rope
    return differences(findings.trials.frame, rope) if rope else pd.DataFrame()


def section(findings: Findings) -> Section | None:
    """Return the section on practical equality; None where the study gives no rope."""
    if (chosen := findings.final.rope) is None:
        return None
    rope = chosen.words + " of the smaller median" * chosen.relative
    if len(findings.trials.optimizers) < 2:
        return Section(TITLE, ("There is only one optimizer, so none can be equal to another.",))
    table = findings.of(beside_rope)
    if table.empty:
        return Section(TITLE, ("No problem has trials of two optimizers, so none can be equal to another.",))
    if table["wide"].all():
        useless = f"The rope of {rope} is wider than the range of all values on every problem, so it shows nothing."
        return Section(TITLE, warnings=(useless,))
    meaning = f"Two optimizers count as practically equal where their medians differ by at most {rope}."
    text, warnings = [meaning, _each(findings.final, table)], []
    if wide := [str(label) for label in dict.fromkeys(table.loc[table["wide"], "problem"])]:
        where = f"{listing(wide)}, where every pair is equal by definition"
        warnings.append(f"The rope is wider than the range of all values on {where}.")
    items: list[Part] = [_counts(findings.final, table)]
    if table["problem"].nunique() > 1:
        models = probabilities(table)
        text.append(_across(models))
        items = [_figure(models), _models(models), *items]
    return Section(TITLE, tuple(text), tuple(items), tuple(warnings))


def _each(final: Final, table: pd.DataFrame) -> str:
    """Return how many cells are equivalent, beside those that are merely not separable."""
    joined = _with_tests(final, table)
    open_pairs = joined[~joined["significant"]]
    level = f"{100 * (1 - 2 * ALPHA / joined.groupby('problem', observed=True).size().max()):.4g}%"
    equal, close = int(open_pairs["equivalent"].sum()), int((joined["equivalent"] & joined["significant"]).sum())
    sentence = (
        f"Of {count(len(joined), 'pair')} of optimizers on a problem, {len(open_pairs):,} cannot be separated. "
        f"Equality is shown for {equal:,} of these, as the {level} interval of the difference of medians lies within "
        f"the rope; for {len(open_pairs) - equal:,} neither a difference nor equality is shown. A difference that lies "
        f"within the rope is shown for {count(close, 'pair')}."
    )
    few = int(joined["low"].isna().sum())
    return sentence + (f" Below {FEWEST} trials, as in {count(few, 'pair')}, nothing is shown." if few else "")


def _across(models: pd.DataFrame) -> str:
    """Return a sentence on the pairs that are decided across problems."""
    parts = []
    for pair in models.to_dict("records"):
        for column, words in (
            ("first_better", f"{pair['first']} is better than {pair['second']}"),
            ("equal", f"{pair['first']} and {pair['second']} are equal"),
            ("second_better", f"{pair['second']} is better than {pair['first']}"),
        ):
            if pair[column] >= SURE:
                parts.append(f"{words} ({min(pair[column], 0.999):.3g})")
    start = f"Across {count(int(models['problems'].max()), 'problem')}, by the Bayesian signed-rank test,"
    if not parts:
        return f"{start} no statement has a probability of {SURE:g} or more."
    return f"{start} these have a probability of {SURE:g} or more: {listing(parts)}."


def _with_tests(final: Final, table: pd.DataFrame) -> pd.DataFrame:
    """Return the table with the outcome of the test of each pair."""
    tests = final.pairs[["problem", "first", "second", "p_holm", "significant"]]
    return table.merge(tests, on=["problem", "first", "second"])


def _counts(final: Final, table: pd.DataFrame) -> Table:
    joined = _with_tests(final, table)
    equal, apart = joined["equivalent"], joined["significant"]
    kinds = {
        "separable": apart & ~equal, "separable, but equivalent": apart & equal, "equivalent": ~apart & equal,
        "neither shown": ~apart & ~equal,
    }  # fmt: skip
    grouped = joined[["first", "second"]].assign(**kinds).groupby(["first", "second"], sort=False)
    shown = grouped.sum().reset_index()
    return Table(
        "equivalence",
        "On how many problems each pair of optimizers is separable (the test of A12 = 0.5, Holm) and equivalent (the "
        "interval of the difference of medians lies within the rope).",
        shown,
        note="Neither shown: the trials show neither a difference nor equality. The file has every problem.",
        data=joined,
    )


def _models(models: pd.DataFrame) -> Table:
    heads = {"first_better": "first better", "equal": "equal", "second_better": "second better"}
    shown = models.rename(columns=heads | {f"{key}_h": f"{name} (h)" for key, name in heads.items()})
    return Table(
        "equivalence-probabilities",
        "Probability that the first optimizer is better by more than the rope, that both are equal, and that the "
        "second is better: by the Bayesian signed-rank test over these problems, and by the hierarchical model (h) "
        "on further problems of the kind.",
        shown,
        decimals=dict.fromkeys([*heads.values(), *(f"{name} (h)" for name in heads.values())], 3),
        note="–: fewer than three problems have a finite error of the difference.",
        data=models,
    )


def _figure(models: pd.DataFrame) -> Figure:
    left = 0.2 + style.text_width(forest_names(models))
    figure, (ax,) = style.grid(
        1, columns=1, width=style.page_width(), height=style.rows_height(len(models)), left=left, top=0.1, bottom=0.45
    )
    equivalence_bars(models, ax=ax)
    caption = (
        "Probability that the first of two optimizers is better by more than the rope (left), that both are "
        "practically equal (grey), and that the second is better (right), by the Bayesian signed-rank test."
    )
    return Figure("equivalence-bars", caption, figure, models)


TOPIC = Topic(TITLE, section, place=630)
