"""Write an atlas as a folder of Markdown pages, tables and a map.

The same versions, table and seed give the same bytes; times are in ``times.csv`` and on no page.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from bench.analysis.similarity import Similarity
from bench.atlas.compare import Atlas, centre_bias, findings
from bench.atlas.runs import DIMENSION, MEASURES, PROBLEMS, Surveyed
from bench.atlas.table import Method
from bench.errors import BenchError
from bench.helpers.atomic import names_in, replacing
from bench.helpers.markdown import code, plain, table
from bench.helpers.text import count, joined
from bench.plots import style
from bench.plots.similarity import similarity_map
from bench.report.wording import cell_text

INDEX, MARK, MAP_FILE = "index.md", "implementations.csv", "map.svg"
TABLES = ("implementations", "pairs", "tests", "medians", "times")
RULE = (
    "Two implementations are *different* where their trials differ on at least one function in at least one of four "
    "measures by an exact Kolmogorov-Smirnov test: the median value of the first generation, that of the next two, the "
    "mean of the logarithm of the best value so far, and the final best. p is adjusted by Holm's method over all "
    "{tests} tests of this atlas (pairs, functions and measures), at 5%. Implementations of one letter were not found "
    "different from each other."
)
PAIRS = (
    f"The columns count the functions, of {len(PROBLEMS)}, on which a pair differs in the first generation (start), in "
    "the next two, in the course of the best value and in the final best. The largest difference is that of median "
    "final bests, among the functions of the column final. The distance of two searches goes from 0 to 1; in brackets "
    "is that of two halves of the same trials."
)
MAP = (
    "Implementations near each other search alike, whatever their method; colours are those of methods. The map leaves "
    "out {stress:.0%} of the squared distances."
)


def write_atlas(found: Atlas, methods: Sequence[Method], output: Path, *, trials: int, budget: int, seed: int) -> Path:
    """Write the folder of an atlas and return the path of its first page.

    Args:
        found: what was compared.
        methods: its methods, in order.
        output: a new or empty folder, or that of an earlier atlas, which is replaced.
        trials: of each implementation on each function.
        budget: evaluations of a trial.
        seed: of the trials.

    Raises:
        BenchError: for a folder that holds other files, or cannot be written.
    """
    check_output(output)
    size = f"{count(trials, 'trial')} of {budget:,} evaluations on each of {len(PROBLEMS)} functions, d = {DIMENSION}"
    with replacing(output.resolve()) as temporary:
        temporary.mkdir(parents=True)
        for name, frame in frames(found).items():
            frame.to_csv(temporary / f"{name}.csv", index=False, lineterminator="\n", encoding="utf-8")
        if found.similarity is not None:
            with style.context():
                drawn = similarity_map(_named(found.similarity, found.surveyed))
                drawn.savefig(temporary / MAP_FILE, metadata={"Date": None})
        pages = {INDEX: index_page(found, methods, f"{size}; seed {seed}")}
        pages |= {f"{each.name}.md": method_page(found, each, size) for each in methods}
        for name, text in pages.items():
            (temporary / name).write_text(text, encoding="utf-8", newline="\n")
    return output / INDEX


def _named(found: Similarity, surveyed: Sequence[Surveyed]) -> Similarity:
    """Return the similarity with labels as names, where they are unique, and methods in place of clusters."""
    own = [each.implementation for each in surveyed if not each.failed]
    times = Counter(each.label for each in own)
    names = [each.label if times[each.label] == 1 else each.key for each in own]
    methods = list(dict.fromkeys(each.method for each in own))
    colours = pd.Series([methods.index(each.method) + 1 for each in own], index=names)
    return replace(found, places=found.places.set_axis(names), clusters=colours)


def check_output(output: Path) -> None:
    """Raise BenchError for a folder that is neither new, nor empty, nor holds an atlas and nothing else."""
    present = names_in(output)
    known = {f"{name}.csv" for name in TABLES} | {INDEX, MAP_FILE}
    if MARK in present:
        try:
            known |= {f"{each}.md" for each in pd.read_csv(output / MARK)["method"]}
        except (OSError, ValueError, KeyError) as error:
            raise BenchError(f"{output} cannot be read as an atlas, which would be replaced: {error}") from error
    if others := sorted(present - known):
        raise BenchError(f"{output} holds other files than an atlas, such as {others[0]}; give a new one by --output")


def frames(found: Atlas) -> dict[str, pd.DataFrame]:
    """Return the tables of an atlas with all digits, by name."""
    rows, medians, times = [], [], []
    for each in found.surveyed:
        own = each.implementation
        names = {"method": own.method, "label": own.label}
        rows.append(names | {
            "optimizer": own.name, "options": json.dumps(dict(own.options)), "code": each.code,
            "group": found.groups.get(own.key, ""), "evaluations": each.evaluations,
            "centre_bias": centre_bias(each.measures), "on_bounds": each.clamped,
            "repeatable": each.repeatable, "without_effect": json.dumps(dict(each.dead)), "failed": each.failed,
        })  # fmt: skip
        times.append(names | {"microseconds_an_evaluation": each.microseconds})
        medians += [
            names | {"problem": problem} | dict(zip(MEASURES, np.median(values, axis=0).tolist(), strict=True))
            for problem, values in each.measures.items()
        ]
    tables = {"implementations": rows, "medians": medians, "times": times}
    made = {name: pd.DataFrame(own) for name, own in tables.items()}
    return made | {"pairs": found.pairs, "tests": found.tests}


def index_page(found: Atlas, methods: Sequence[Method], size: str) -> str:
    """Return the first page: methods by libraries, what else was found, and the map."""
    own = {method.name: [each for each in found.surveyed if each.implementation.method == method.name]
           for method in methods}  # fmt: skip
    libraries = list(dict.fromkeys(each.implementation.library for each in found.surveyed))
    rows = [
        [f"[{plain(method.title)}]({method.name}.md)"]
        + [
            ", ".join(_cell(found, each) for each in own[method.name] if each.implementation.library == library)
            for library in libraries
        ]
        for method in methods
    ]
    several = found.pairs.groupby("method", sort=False)["different"].sum()
    counted = (
        f"{found.counted}. In {int((several == 0).sum())} of {count(len(several), 'method')} with several "
        "implementations, no pair is."
    )
    parts = [
        "# An atlas of implementations",
        f"{count(len(found.surveyed), 'implementation')} of {count(len(methods), 'method')}: {size}.",
        " ".join(
            filter(None, (RULE.format(tests=f"{len(found.tests):,}"), found.doubt, counted if len(several) else ""))
        ),
        table(["method", *map(plain, libraries)], rows),
    ]
    noted = [
        [plain(own.method), code(own.label), plain(said)]
        for each in found.surveyed
        for own in [each.implementation]
        for said in findings(each)
    ]
    if noted:
        parts += ["## Biases, parameters without effect, failures",
                  table(["method", "implementation", "finding"], noted)]  # fmt: skip
    if found.similarity is not None:
        parts += [
            "## The map",
            MAP.format(stress=found.similarity.stress),
            "![A map of all implementations by how alike they search, and a tree of their distances](map.svg)",
        ]
    versions = sorted({each.code for each in found.surveyed if each.code and not each.failed})
    parts += ["## Versions", "\n".join(f"- {plain(each)}" for each in versions)]
    return "\n\n".join(parts) + "\n"


def method_page(found: Atlas, method: Method, size: str) -> str:
    """Return the page of a method: its implementations, their differences, and median final bests."""
    own = [each for each in found.surveyed if each.implementation.method == method.name]
    alive = [each for each in own if not each.failed]
    pairs = found.pairs[found.pairs["method"] == method.name]
    parts = [f"# {plain(method.title)}", plain(f"{size}. {method.conditions}".strip())]
    parts += [table(
        ["implementation", "letter", "code", "evaluations", "finding"],
        [_implementation_row(found, each) for each in own],
    )]  # fmt: skip
    if len(pairs):
        parts += [
            "## Which of them differ",
            " ".join(filter(None, (PAIRS, found.doubt))),
            table(
                ["pair", "verdict", "start", "next", "course", "final", "largest difference", "distance"],
                [_pair_row(row) for row in pairs.to_dict("records")],
            ),
        ]
    parts += ["## Options, and what is documented", "\n".join(map(_documented, own))]
    known = {each.implementation.label for each in own if each.implementation.differs}
    if unexplained := _unexplained(pairs, known):
        parts.append(f"No documented difference is known here for {joined(unexplained)}.")
    if alive:
        parts += ["## Median final bests", table(
            ["function", *(code(each.implementation.label) for each in alive)],
            [
                [problem, *(cell_text(float(np.median(each.measures[problem][:, MEASURES.index("final")])))
                            for each in alive)]
                for problem in PROBLEMS
            ],
        )]  # fmt: skip
    return "\n\n".join(parts) + "\n"


def _cell(found: Atlas, each: Surveyed) -> str:
    short = each.implementation.label.rpartition(":")[2]
    return f"{code(short)} " + ("failed" if each.failed else f"**{found.groups[each.implementation.key]}**")


def _implementation_row(found: Atlas, each: Surveyed) -> list[str]:
    own = each.implementation
    evaluations = "–" if each.failed else cell_text(round(each.evaluations))
    finding = plain("; ".join(findings(each)))
    return [code(own.label), found.groups.get(own.key, "–"), plain(each.code), evaluations, finding]


def _documented(each: Surveyed) -> str:
    """Return what an implementation is, its options, and what is known of it, as an item of a list."""
    own = each.implementation
    options = ", ".join(f"{name} = {value!r}" for name, value in own.options.items()) or "default options"
    name = "" if own.label == own.name else f"{code(own.name)}, "
    source = f" ({plain(own.source)})" if own.source else ""
    return f"- {code(own.label)}: {name}{plain(options)}. {plain(own.differs)}{source}".rstrip()


def _pair_row(row: Mapping[Any, Any]) -> list[str]:
    first, second = row["first"], row["second"]
    largest = "–"
    if row["problem"]:
        lower = first if row["orders"] > 0 else second
        largest = f"{abs(row['orders']):.1f} orders of magnitude on {row['problem']}, {code(lower)} lower"
    distance = "–" if np.isnan(row["distance"]) else f"{row['distance']:.2f} ({row['floor']:.2f})"
    verdict = "**different**" if row["different"] else "not found different"
    return [f"{code(first)}, {code(second)}", verdict, *(str(row[each]) for each in MEASURES), largest, distance]


def _unexplained(pairs: pd.DataFrame, known: set[str]) -> list[str]:
    return [
        f"{code(row['first'])} against {code(row['second'])}"
        for row in pairs.to_dict("records")
        if row["different"] and not known & {row["first"], row["second"]}
    ]
