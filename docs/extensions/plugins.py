"""Write the reference pages of optimizers and problems, from ``bench list --json`` and the entry points."""

from __future__ import annotations

import inspect
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

from extensions.pages import code, plain, table, write

Record = Mapping[str, Any]
UNFOLDED = 40  # members of a family in one table


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages when the build begins."""
    app.connect("builder-inited", lambda app: _write(Path(app.srcdir) / "reference"))
    return {"parallel_read_safe": True}


def _write(reference: Path) -> None:
    optimizers = listed()
    own = {each["name"]: optimizer_page(each) for each in optimizers if not each["family"]}
    families = {each["family"] for each in optimizers} - {""}
    write(reference / "optimizers", own)
    write(
        reference / "families",
        {name: family_page(name, [each for each in optimizers if each["family"] == name]) for name in sorted(families)},
    )
    write(reference / "problems", {each["name"]: problem_page(each) for each in listed("problems")})
    studies = [(code(each["name"]), plain(each["about"])) for each in listed("studies")]
    about = (
        "# Installed studies\n\n`bench run NAME` runs one; a file of your own is [a study](../study.md) like these.\n\n"
    )
    write(reference / "studies", {"list": about + table(("study", "what it compares"), studies) + "\n"})


def listed(kind: str = "all") -> list[Record]:
    """Return the records that the command prints; of all kinds: the optimizers."""
    command = (sys.executable, "-P", "-m", "bench", "list", kind, "--json")  # not the checkout's
    records: list[Record] = json.loads(subprocess.run(command, capture_output=True, check=True, text=True).stdout)
    return records


def optimizer_page(record: Record) -> str:
    """Return the page of one optimizer: what it is, its papers, its parameters and its docstring."""
    from bench.plugins import registry

    kind = registry.load("optimizers", record["name"])
    parts = [
        f"# {record['name']}",
        plain(record["about"]),
        table(("", ""), [*(("paper", cited(paper)) for paper in record["paper"]), ("code", plain(record["code"]))]),
        f'```toml\n[[optimizers]]\nname = "{record["name"]}"\n```',
        "## Parameters",
        table(("parameter", "default", "values"), [parameter(each) for each in record["parameters"]]),
        "## Details",
        f"```{{eval-rst}}\n.. autoclass:: {kind.__module__}.{kind.__qualname__}\n   :no-index:\n```",
    ]
    return "\n\n".join(parts) + "\n"


def family_page(name: str, members: Iterable[Record]) -> str:
    """Return the page of a family of another library's optimizers: each member with its parameters and remarks."""
    members = list(members)
    first = members[0]
    install = f"`pip install '.[{first['extra']}]'` in the clone" if first["extra"] else "none: scipy is always there"
    shared = set.intersection(*(set(each["unmapped"]) for each in members))
    repeated = Counter(remark for each in members for remark in each["unmapped"] if remark not in shared)
    numbers = {remark: at for at, remark in enumerate((each for each, n in repeated.items() if n > 1 and each), 1)}
    rows = [_member(each, shared, numbers) for each in members]
    papers = sorted(set.intersection(*(set(each["paper"]) for each in members)))
    parts = [
        f"# {name}: {len(members)} optimizers",
        table(
            ("", ""),
            [
                ("installation", install),
                ("code", ", ".join(sorted({plain(each["code"]) for each in members}))),
                *(("paper", cited(paper)) for paper in papers),
                *(("of all members", plain(remark)) for remark in sorted(shared)),
            ],
        ),
        f"`bench list {name}:MEMBER` prints one with the ranges of its parameters, `bench list {name} --json` all.",
        "\n".join(f"{number}. {plain(remark)}" for remark, number in numbers.items()),
        *_members(rows),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _member(record: Record, shared: set[str], numbers: Mapping[str, int]) -> tuple[str, ...]:
    """Return the row of a member; a remark that several members have is there by its number."""
    own = [remark for remark in record["unmapped"] if remark and remark not in shared]
    remarks = [str(numbers[each]) if each in numbers else plain(each) for each in own]
    parameters = ", ".join(f"{code(one['name'])} = {code(one['default'])}" for one in record["parameters"])
    return code(record["name"]), plain(record["about"]), parameters, "; ".join(remarks)


def _members(rows: list[tuple[str, ...]]) -> list[str]:
    """Return the table of the members, or of a large family several that a reader opens."""
    head = ("name", "what it is", "parameters and defaults", "remarks")
    if len(rows) <= UNFOLDED:
        return [table(head, rows)]
    parts = [rows[at : at + UNFOLDED] for at in range(0, len(rows), UNFOLDED)]
    return [f":::{{dropdown}} {part[0][0]} to {part[-1][0]}\n{table(head, part)}\n:::" for part in parts]


def parameter(record: Record) -> tuple[str, str, str]:
    """Return the row of a parameter: name, default, and the values that it takes."""
    low, high = record["minimum"], record["maximum"]
    limits = [f"{word} {code(limit)}" for word, limit in (("from", low), ("to", high)) if limit is not None]
    return code(record["name"]), code(record["default"]), " ".join([code(record["kind"]), *limits])


def cited(paper: str) -> str:
    """Return a reference in which the DOI is a link."""
    text, found, doi = paper.partition(", doi:")
    return plain(text) + (f", [doi:{plain(doi)}](https://doi.org/{doi})" if found else "")


def problem_page(record: Record) -> str:
    """Return the page of a family of problems: its names, its functions and dimensions, and its sources."""
    from bench.plugins import registry

    name = record["name"]
    family = registry.load("problems", name)
    module = import_module(registry.entries("problems")[name].value.partition(":")[0])
    about = (inspect.getdoc(module) or "").replace("``", "`")
    names = list(family.names())
    parts = [f"# {name}", about, f"Names: {plain(record['about'])}."]
    grid = getattr(family, "grid", None)
    if grid is not None:
        parts += [_grid(grid), f'```toml\n[[problems]]\nsuite = "{name}"\n```']
    elif names:
        parts.append(", ".join(code(each) for each in names) + ".")
    return "\n\n".join(parts) + "\n"


def _grid(grid: Any) -> str:
    by_dimensions: dict[tuple[int, ...], list[str]] = {}
    for function, dimensions in grid.functions.items():
        by_dimensions.setdefault(tuple(dimensions), []).append(function)
    rows = [
        (", ".join(map(code, functions)), ", ".join(map(str, dimensions)))
        for dimensions, functions in by_dimensions.items()
    ]
    instances = f"instances 1 to {grid.instances}; others by name" if grid.instances else "no instances"
    return table(("functions", "dimensions"), rows) + f"\n\n{len(grid.functions)} functions, {instances}."
