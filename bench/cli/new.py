"""bench new: write a package with an optimizer, a family of problems or a topic of reports, or a study.

The templates are the project's own examples, which its tests build, install and run: the example's name is replaced by
the new one.
"""

from __future__ import annotations

import keyword
import re
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from bench.helpers.atomic import replacing
from bench.helpers.console import print_line
from bench.helpers.errors import BenchError, nearest
from bench.helpers.shipped import shipped
from bench.plugins import registry

GENERATED = {"__pycache__", "dist", "results", ".pytest_cache"}
"""Folders that tests and builds of an example leave in it."""


@dataclass(frozen=True)
class Template:
    """An example: its name, its files by the new ones' paths, the group of its entry point, and what to do next."""

    example: str
    files: dict[str, str]  # a folder stands for all files in it; "{name}" for the new name
    group: str
    then: str


TEMPLATES = {
    "optimizer": Template(
        "hill-climber",
        {"": "optimizer", "gate.toml": "gate/gate.toml", ".github/workflows/gate.yml": "gate/workflow.yml"},
        "optimizers",
        "cd {path} && pip install . pytest && pytest && bench check {name}",
    ),
    "problem": Template(
        "water-filling",
        {"": "problem"},
        "problems",
        "cd {path} && pip install . pytest && pytest && bench check {name} && bench run study.toml",
    ),
    "topic": Template(
        "worst-runs",
        {"": "topic"},
        "report_sections",
        "cd {path} && pip install . pytest && pytest && bench run study.toml",
    ),
    "study": Template("smallest", {"": "study/smallest.toml"}, "studies", "bench run {path}"),
}


def command(
    kind: Annotated[str, typer.Argument(help="optimizer, problem, topic or study.")],
    name: Annotated[str, typer.Argument(help="Its name: lower-case words joined by hyphens, such as hill-climber.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder to write, or file of a study; default: NAME.")
    ] = None,
) -> None:
    """Write a package that installs and passes its tests (an optimizer, problems, a topic of reports), or a study.

    A package has its own tests and a workflow for GitHub; that of an optimizer also has a gate, which stops pull
    requests that make it worse (see 'bench gate').
    """
    path = create(kind, name, output)
    print_line(f"wrote {path}; next: {TEMPLATES[kind].then.format(path=path, name=name)}")


def create(kind: str, name: str, output: Path | None = None) -> Path:
    """Write the folder of a new package, or the file of a new study, and return its path.

    Raises:
        BenchError: for an unknown kind, a name that cannot be used, and a folder or file that exists or that cannot be
            written.
    """
    if kind not in TEMPLATES:
        raise BenchError(f"unknown kind {kind!r}{nearest(kind, TEMPLATES)}")
    template, single = TEMPLATES[kind], kind == "study"
    _refuse_odd(name)
    path = output or Path(f"{name}.toml" if single else name)
    if path.exists():
        raise BenchError(f"{path} exists already; choose another name, or give another --output")
    if name in registry.entries(template.group):
        package = registry.package(template.group, name)
        raise BenchError(f"{package} has the {kind} {name!r} already; choose another name")
    files = _texts(template)
    if not single:
        _refuse_taken(name, template, files)
    with replacing(path) as temporary:
        for file, text in files.items():
            target = temporary / _renamed(file, template, name)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(_renamed(text, template, name), encoding="utf-8", newline="\n")
    return path


def _refuse_odd(name: str) -> None:
    if not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name) or len(name) > 50:
        raise BenchError(
            f"the name {name!r} must be up to 50 lower-case letters, digits and single hyphens, and begin with a "
            "letter, such as hill-climber"
        )


def _refuse_taken(name: str, template: Template, files: dict[str, str]) -> None:
    """Refuse a name whose module or class has a meaning already."""
    module, kind = _module(name), _class(name)
    if keyword.iskeyword(module) or keyword.iskeyword(kind):
        raise BenchError(f"the name {name!r} is a keyword of Python; choose another name, such as my-{name}")
    if module in sys.stdlib_module_names or find_spec(module):
        raise BenchError(
            f"the name {name!r} gives a module {module!r}, and one of that name is installed already; choose another "
            f"name, such as my-{name}"
        )
    source = files[f"src/{_module(template.example)}.py"]
    if kind != _class(template.example) and re.search(rf"\b{kind}\b", source):
        raise BenchError(f"the name {name!r} gives a class {kind!r}, which means something else; choose another name")


def _texts(template: Template) -> dict[str, str]:
    """Return the texts of an example by the paths of the files to write, without what tests and builds leave there."""
    home = shipped("examples", "examples")
    texts = {}
    for target, source in template.files.items():
        place = home / source
        for file in [place, *sorted(place.rglob("*"))]:
            path = file.relative_to(place)
            if file.is_file() and not GENERATED & set(path.parts):
                texts[(Path(target) / path).as_posix()] = file.read_text(encoding="utf-8")
    if not texts:
        raise BenchError(f"the templates of 'bench new' are missing in {home}; install {registry.DISTRIBUTION} again")
    return texts


def _renamed(text: str, template: Template, name: str) -> str:
    for form in (str, _module, _class):
        text = text.replace(form(template.example), form(name))
    return text


def _module(name: str) -> str:
    return name.replace("-", "_")


def _class(name: str) -> str:
    return "".join(word.capitalize() for word in name.split("-"))
