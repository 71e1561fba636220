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


def is_bag(definition):
    """Return whether a class holds values by name, and is no contract such as that of problems."""
    signs = map(ast.unparse, (*definition.decorator_list, *definition.bases))
    return any(re.match("(dataclass|NamedTuple|TypedDict|OptionGroup)", sign) for sign in signs)


def fields(definition, others):
    """Return the names of the fields that a class declares, or inherits from one of the others by its name."""
    inherited = [fields(others[base], others) for base in map(ast.unparse, definition.bases) if base in others]
    declared = [each for each in definition.body if isinstance(each, ast.AnnAssign)]
    return {each.target.id for each in declared if "ClassVar" not in ast.unparse(each.annotation)}.union(*inherited)


def test_bench_has_at_most_22_rooms_in_10_layers():
    rooms = {Path(name).parts[1].removesuffix(".py") for name in MODULES if name.startswith("bench/")}
    assert len(rooms - {"__init__", "__main__"}) <= 22
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    (layers,) = (each["layers"] for each in contracts["contracts"] if each["id"] == "bench")
    assert len(layers) <= 10


def test_a_module_has_at_most_500_lines():
    assert not {name for name, text in MODULES.items() if text.count("\n") > 500}


def test_a_function_has_at_most_12_parameters():
    assert not {place for place, node in definitions(FUNCTION) if parameters(node) > 12}


def test_a_bag_has_at_most_10_fields():
    bags = [node for _, node in definitions(ast.ClassDef) if is_bag(node)]
    assert len(bags) > 100
    others = {node.name: node for node in bags}
    assert not {node.name for node in bags if len(fields(node, others)) > 10}


def test_a_type_is_left_open_only_where_it_is_unknown():
    assert sum(len(re.findall(r"\bAny\b", text)) for text in MODULES.values()) <= 300
