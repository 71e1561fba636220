"""The limits that a change keeps, so that the code stays one that others can read."""

import ast
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MODULES = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for package in ("bench", "optimizers", "problems")
    for path in sorted((ROOT / package).rglob("*.py"))
}
FUNCTION = (ast.FunctionDef, ast.AsyncFunctionDef)

OPTIONS, CALL = "the options of a command", "a call from Python, whose keywords are public"
WIDE = {
    "bench/cli/run.py: command": OPTIONS,
    "bench/cli/solve.py: command": OPTIONS,
    "problems/backlash/commands/estimate.py: estimate": OPTIONS,
    "problems/backlash/commands/simulate.py: simulate": OPTIONS,
}
"""The functions that may have more parameters, and why."""

LARGE = {
    "bench/contract/problem.py: Problem": "the contract of problems",
    "bench/trial/columns.py: Measured": "the columns of a trial that a search fills in",
    "problems/backlash/joint/parameters.py: Joint": "the parameters of a joint's file",
}
"""The classes that may have more fields, and why."""


def definitions(kinds):
    """Yield the place and the node of every function or class."""
    for name, text in MODULES.items():
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, kinds):
                yield f"{name}: {node.name}", node


def parameters(function):
    """Return the number of a function's parameters but ``self`` and ``cls``."""
    arguments = function.args
    every = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
    return sum(argument.arg not in ("self", "cls") for argument in every)


def fields(definition):
    """Return the number of fields that a class declares."""
    declared = [each.annotation for each in definition.body if isinstance(each, ast.AnnAssign)]
    return sum("ClassVar" not in ast.unparse(annotation) for annotation in declared)


def test_bench_has_at_most_22_rooms_in_10_layers():
    rooms = {Path(name).parts[1].removesuffix(".py") for name in MODULES if name.startswith("bench/")}
    assert len(rooms - {"__init__", "__main__"}) <= 22
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    (layers,) = (each["layers"] for each in contracts["contracts"] if each["id"] == "bench")
    assert len(layers) <= 10


def test_a_module_has_at_most_500_lines():
    assert not {name for name, text in MODULES.items() if text.count("\n") > 500}


def test_a_function_has_at_most_12_parameters():
    assert {place for place, node in definitions(FUNCTION) if parameters(node) > 12} == WIDE.keys()


def test_a_class_declares_at_most_10_fields():
    assert {place for place, node in definitions(ast.ClassDef) if fields(node) > 10} == LARGE.keys()


def test_a_type_is_left_open_only_where_it_is_unknown():
    assert sum(len(re.findall(r"\bAny\b", text)) for text in MODULES.values()) <= 300
