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
from jinja2 import Environment, PackageLoader, StrictUndefined

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

PAGES = Environment(
    loader=PackageLoader(__package__, ""), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
    keep_trailing_newline=True,
)  # fmt: skip
PAGES.filters |= {"plain": plain, "paragraph": lambda text: " ".join(text.split())}
PAGES.globals |= {"count": count, "joined": joined, "table": table}


def write_atlas(atlas: Atlas, methods: Sequence[Method], output: Path, *, trials: int, budget: int, seed: int) -> Path:
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
        for name, frame in frames(atlas).items():
            frame.to_csv(temporary / f"{name}.csv", index=False, lineterminator="\n", encoding="utf-8")
        if atlas.similarity is not None:
            with style.context():
                drawn = similarity_map(_named(atlas.similarity, atlas.surveyed))
                drawn.savefig(temporary / MAP_FILE, metadata={"Date": None})
        pages = {INDEX: index_page(atlas, methods, f"{size}; seed {seed}")}
        pages |= {f"{method.name}.md": method_page(atlas, method, size) for method in methods}
        for name, text in pages.items():
            (temporary / name).write_text(text, encoding="utf-8", newline="\n")
    return output / INDEX


def _named(searches: Similarity, surveyed: Sequence[Surveyed]) -> Similarity:
    """Return the similarity with labels as names, where they are unique, and methods in place of clusters."""
    implementations = [seen.implementation for seen in surveyed if not seen.failed]
    times = Counter(entry.label for entry in implementations)
    names = [entry.label if times[entry.label] == 1 else entry.key for entry in implementations]
    methods = list(dict.fromkeys(entry.method for entry in implementations))
    colours = pd.Series([methods.index(entry.method) + 1 for entry in implementations], index=names)
    return replace(searches, places=searches.places.set_axis(names), clusters=colours)


def check_output(output: Path) -> None:
    """Raise BenchError for a folder that is neither new, nor empty, nor holds an atlas and nothing else."""
    present = names_in(output)
    expected = {f"{name}.csv" for name in TABLES} | {INDEX, MAP_FILE}
    if MARK in present:
        try:
            expected |= {f"{method}.md" for method in pd.read_csv(output / MARK)["method"]}
        except (OSError, ValueError, KeyError) as error:
            raise BenchError(f"{output} cannot be read as an atlas, which would be replaced: {error}") from error
    if foreign := sorted(present - expected):
        raise BenchError(f"{output} holds other files than an atlas, such as {foreign[0]}; give a new one by --output")


def frames(atlas: Atlas) -> dict[str, pd.DataFrame]:
    """Return the tables of an atlas with all digits, by name."""
    rows, medians, times = [], [], []
    for seen in atlas.surveyed:
        entry = seen.implementation
        names = {"method": entry.method, "label": entry.label}
        rows.append(names | {
            "optimizer": entry.name, "options": json.dumps(dict(entry.options)), "code": seen.code,
            "group": atlas.groups.get(entry.key, ""), "evaluations": seen.evaluations,
            "centre_bias": centre_bias(seen.measures), "on_bounds": seen.clamped,
            "repeatable": seen.repeatable, "without_effect": json.dumps(dict(seen.dead)), "failed": seen.failed,
        })  # fmt: skip
        times.append(names | {"microseconds_an_evaluation": seen.microseconds})
        medians += [
            names | {"problem": problem} | dict(zip(MEASURES, np.median(values, axis=0).tolist(), strict=True))
            for problem, values in seen.measures.items()
        ]
    tables = {"implementations": rows, "medians": medians, "times": times}
    made = {name: pd.DataFrame(rows_of) for name, rows_of in tables.items()}
    return made | {"pairs": atlas.pairs, "tests": atlas.tests}


def index_page(atlas: Atlas, methods: Sequence[Method], size: str) -> str:
    """Return the first page: methods by libraries, what else was found, and the map."""
    libraries = list(dict.fromkeys(seen.implementation.library for seen in atlas.surveyed))
    rows = []
    for method in methods:
        alike = [seen for seen in atlas.surveyed if seen.implementation.method == method.name]
        cells = (
            ", ".join(_cell(atlas, seen) for seen in alike if seen.implementation.library == library)
            for library in libraries
        )
        rows.append([f"[{plain(method.title)}]({method.name}.md)", *cells])
    noted = [
        [plain(entry.method), code(entry.label), plain(finding)]
        for seen in atlas.surveyed
        for entry in [seen.implementation]
        for finding in findings(seen)
    ]
    return PAGES.get_template("index.md.j2").render(
        atlas=atlas, methods=methods, size=size, libraries=[plain(library) for library in libraries], rows=rows,
        several=atlas.pairs.groupby("method", sort=False)["different"].sum(), noted=noted,
        versions=sorted({seen.code for seen in atlas.surveyed if seen.code and not seen.failed}),
    )  # fmt: skip


def method_page(atlas: Atlas, method: Method, size: str) -> str:
    """Return the page of a method: its implementations, their differences, and median final bests."""
    of_method = [seen for seen in atlas.surveyed if seen.implementation.method == method.name]
    alive = [seen for seen in of_method if not seen.failed]
    pairs = atlas.pairs[atlas.pairs["method"] == method.name].to_dict("records")
    explained = {seen.implementation.label for seen in of_method if seen.implementation.differs}
    medians = [
        [problem, *(cell_text(float(np.median(seen.measures[problem][:, MEASURES.index("final")]))) for seen in alive)]
        for problem in PROBLEMS
    ]
    return PAGES.get_template("method.md.j2").render(
        atlas=atlas, method=method, size=size, problems=len(PROBLEMS),
        implementations=[_implementation_row(atlas, seen) for seen in of_method],
        pairs=[_pair_row(row) for row in pairs], documented=[_documented(seen) for seen in of_method],
        unexplained=[
            f"{code(row['first'])} against {code(row['second'])}"
            for row in pairs
            if row["different"] and not explained & {row["first"], row["second"]}
        ],
        alive=[code(seen.implementation.label) for seen in alive], medians=medians if alive else [],
    )  # fmt: skip


def _cell(atlas: Atlas, seen: Surveyed) -> str:
    short = seen.implementation.label.rpartition(":")[2]
    return f"{code(short)} " + ("failed" if seen.failed else f"**{atlas.groups[seen.implementation.key]}**")


def _implementation_row(atlas: Atlas, seen: Surveyed) -> list[str]:
    entry = seen.implementation
    evaluations = "–" if seen.failed else cell_text(round(seen.evaluations))
    finding = plain("; ".join(findings(seen)))
    return [code(entry.label), atlas.groups.get(entry.key, "–"), plain(seen.code), evaluations, finding]


def _documented(seen: Surveyed) -> str:
    """Return an implementation, its options and the findings on it as an item of a list."""
    entry = seen.implementation
    options = ", ".join(f"{name} = {value!r}" for name, value in entry.options.items()) or "default options"
    name = "" if entry.label == entry.name else f"{code(entry.name)}, "
    source = f" ({plain(entry.source)})" if entry.source else ""
    return f"- {code(entry.label)}: {name}{plain(options)}. {plain(entry.differs)}{source}".rstrip()


def _pair_row(row: Mapping[Any, Any]) -> list[str]:
    first, second = row["first"], row["second"]
    largest = "–"
    if row["problem"]:
        lower = first if row["orders"] > 0 else second
        largest = f"{abs(row['orders']):.1f} orders of magnitude on {row['problem']}, {code(lower)} lower"
    distance = "–" if np.isnan(row["distance"]) else f"{row['distance']:.2f} ({row['floor']:.2f})"
    verdict = "**different**" if row["different"] else "not found different"
    return [f"{code(first)}, {code(second)}", verdict, *(str(row[measure]) for measure in MEASURES), largest, distance]
