"""Write a comparison of suites as a page and a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import pandas as pd

from bench.check.suites import VERDICTS, FunctionVerdict, by_function
from bench.errors import explained
from bench.helpers.atomic import replacing
from bench.helpers.markdown import code, plain, table
from bench.helpers.text import count, joined
from bench.plugins.loading import default_label

EQUAL = ("bits", "rounding")
WORDS = {
    "bits": "equal", "rounding": "equal to rounding", "transformed": "transformed", "different": "different",
    "missing": "–",
}  # fmt: skip


def summary(comparisons: Sequence[FunctionVerdict], suite: str) -> list[str]:
    """Return a sentence on each other implementation: on how many functions it agrees, and which those are."""
    sentences = []
    for other, of_other in _by_other(comparisons).items():
        groups = {
            word: [each.member.function for each in of_other if each.verdict in verdicts]
            for word, verdicts in {
                "equal": EQUAL, "equal up to a transformation": VERDICTS[2:3], "different": VERDICTS[3:4],
                "missing": VERDICTS[4:],
            }.items()
        }  # fmt: skip
        few = {word: joined(names) if len(names) <= len(of_other) / 2 else "" for word, names in groups.items()}
        counts = [
            f"{len(names)} {word}" + (f" ({few[word]})" if few[word] else "") for word, names in groups.items() if names
        ]
        sentences.append(
            f"{default_label(other)}, of {count(len(of_other), 'function')} of {suite}: {', '.join(counts)}"
        )
    return sentences


def versions(comparisons: Sequence[FunctionVerdict], suite: str) -> list[str]:
    """Return a line for each function with several versions: the implementations of each."""
    lines: dict[str, dict[str, list[str]]] = {}
    for each in by_function(comparisons):
        if each.letter:
            of_function = lines.setdefault(each.member.function, {"A": [suite]})
            of_function.setdefault(each.letter, []).append(default_label(each.other))
    return [
        f"{function}: " + "; ".join(f"{letter} {joined(names)}" for letter, names in sorted(each.items()))
        for function, each in lines.items()
        if len(each) > 1
    ]


def cells(comparisons: Sequence[FunctionVerdict]) -> tuple[list[str], list[list[str]]]:
    """Return the head of a table of functions by implementation, and its rows."""
    of = _by_other(comparisons)
    functions = {each.member.function: None for each in comparisons}
    words: dict[tuple[str, str], str] = {}
    for other, of_other in of.items():
        for each in of_other:
            version = f" ({each.letter})" if each.verdict in ("different", "transformed") and each.letter else ""
            words[other, each.member.function] = WORDS[each.verdict] + version
    return ["function", *map(default_label, of)], [
        [function, *(words[other, function] for other in of)] for function in functions
    ]


def _by_other(comparisons: Sequence[FunctionVerdict]) -> Mapping[str, list[FunctionVerdict]]:
    groups: dict[str, list[FunctionVerdict]] = {}
    for each in by_function(comparisons):
        groups.setdefault(each.other, []).append(each)
    return groups


def write(comparisons: Sequence[FunctionVerdict], suite: str, output: Path) -> Path:
    """Write ``SUITE.md`` and ``SUITE.csv`` into a folder, in place of those of an earlier comparison; return the page.

    Raises:
        BenchError: where they cannot be written.
    """
    with explained(f"{output} cannot be written"):
        output.mkdir(parents=True, exist_ok=True)
    rows = [{**asdict(each), **each.member._asdict(), "other": default_label(each.other)} for each in comparisons]
    columns = ["other", "function", "dimension", "instance", "verdict", "letter", "agree", "detail"]
    with replacing(output / f"{suite}.csv") as path:
        pd.DataFrame(rows, columns=columns).to_csv(path, index=False, lineterminator="\n")
    with replacing(output / f"{suite}.md") as path:
        path.write_text(_page(comparisons, suite), encoding="utf-8", newline="\n")
    return output / f"{suite}.md"


def _page(comparisons: Sequence[FunctionVerdict], suite: str) -> str:
    several = versions(comparisons, suite)
    dimensions = joined([str(size) for size in sorted({each.member.dimension for each in comparisons})])
    parts = [
        f"# {suite} in other implementations",
        f"The values of each function in {dimensions} dimensions, beside those of {code(suite)} at the same points.",
        "\n".join(f"- {plain(sentence)}" for sentence in summary(comparisons, suite)),
        table(*cells(comparisons)),
    ]
    if several:
        parts += [
            "## Versions",
            "Implementations of one letter agree to rounding; A is this suite.",
            "\n".join(f"- {plain(line)}" for line in several),
        ]
    apart = [each for each in by_function(comparisons) if each.verdict not in EQUAL]
    if apart:
        rows = [
            [code(default_label(each.other)), each.member.function, WORDS[each.verdict], plain(each.detail)]
            for each in apart
        ]
        parts += ["## What differs", table(["implementation", "function", "verdict", "detail"], rows)]
    return "\n\n".join(parts) + "\n"
