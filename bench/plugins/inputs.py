"""Name what trials were made from, and compare it with what is there now, as a build tool does."""

from __future__ import annotations

import ast
import os
import warnings
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from threading import Lock

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from bench.helpers.text import short_hash
from bench.plugins import packing, registry
from bench.plugins.observing import Observed, Signature, hash_of, listing, matching, names_of, signature, variable

Inputs = dict[str, tuple[str, Signature]]
"""The state of each input, with the signature of a file, by kind and name, such as ``"file:mine.py"``.

A file within the working folder is named from there on. The state of a Python file is a hash of its syntax, without
comments and docstrings; of another file, of its content; of a package, its version and a hash of its list of files.
"""


def named(observed: Observed, labels: Collection[str] = ()) -> Inputs:
    """Return what a process read as inputs, without what others than those of these labels use alone."""
    found: Inputs = {}
    for owner, read in observed.items():
        if owner and labels and owner not in labels:
            continue
        for place, (content, now) in read.get("files", {}).items():
            found[f"file:{_name(place)}"] = _state(place, content), now
        packages = read.get("packages", {})
        counted = {_distribution(top) for top in packages if _counts(top, packages)}
        for name in sorted({*read.get("libraries", {})} | counted):
            found[f"package:{name}"] = _installed(name), []
        for kind in ("folder", "pattern", "variable", "object"):
            for name, state in read.get(f"{kind}s", {}).items():
                found[f"{kind}:{_name(name) if kind in ('folder', 'pattern') else name}"] = state, []
    return found


def conflicts(recorded: Inputs, other: Inputs) -> list[str]:
    """Return the names of inputs that both have, in other states; what one alone has read is no conflict."""
    return [name for name, (state, _) in other.items() if name in recorded and recorded[name][0] != state]


@dataclass
class Present:
    """What trials would be made from now, looked up once.

    Attributes:
        modules: the files of the modules that plug-ins load now, by the label of a problem or an optimizer and name.
        folder: that which names of files begin at; "" for the working folder.
        strict: whether what is missing counts as changed, as for a run; results may be read on another machine.
    """

    modules: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    folder: str = ""
    strict: bool = True
    _states: dict[tuple[str, str], str | None] = field(default_factory=dict)

    def changed(self, recorded: Inputs, label: str = "") -> list[str]:
        """Return the names of inputs that are others now."""
        found = []
        for name, (state, known) in recorded.items():
            if (name, state) not in self._states:
                self._states[name, state] = _now(name, state, known, self.folder)
            now = self._states[name, state]
            if now not in (None, state) and (now or self.strict):
                found.append(name)
        return [*found, *hidden(recorded, self.modules.get(label, {}))]


def hidden(recorded: Inputs, modules: Mapping[str, str]) -> list[str]:
    """Return the names of recorded modules that Python finds elsewhere now, as where another file comes first.

    ``modules`` has the files of the modules that are loaded now.
    """
    files = {os.path.abspath(name[5:]) for name in recorded if name.startswith("file:")}
    found = []
    for dotted, file in modules.items():
        inside = dotted.replace(".", os.sep)
        for other in files if file not in files else ():
            ends = (f"{os.sep}{inside}.py", f"{os.sep}{inside}{os.sep}__init__.py")
            is_top = not os.path.exists(os.path.join(os.path.dirname(other), "__init__.py")) or other.endswith(ends[1])
            if other.endswith(ends) and ("." in dotted or is_top):
                found.append(f"file:{_name(file)}")
    return found


def is_data(name: str) -> bool:
    """Return whether an input is a file that holds no code in Python."""
    return name.startswith(("file:", "object:")) and not name.endswith(".py")


def shown(name: str) -> str:
    """Return an input's name for people."""
    kind, _, name = name.partition(":")
    if kind in ("folder", "pattern"):
        return f"the files {'in ' if kind == 'folder' else ''}{name or '.'}"
    return f"the variable {name}" if kind == "variable" else "its own code or data" if kind == "object" else name


def large(recorded: Iterable[Inputs]) -> dict[str, tuple[str, Signature]]:
    """Return the hashes of files that are no Python, by path, with the signatures by which a process knows them."""
    files = {name: known for inputs in recorded for name, known in inputs.items() if name.startswith("file:")}
    return {os.path.abspath(name[5:]): known for name, known in files.items() if known[1] and not name.endswith(".py")}


def _name(place: str) -> str:
    here = f"{os.getcwd()}{os.sep}"
    return Path(place.removeprefix(here)).as_posix()


def _now(name: str, state: str, known: Signature, folder: str) -> str | None:
    """Return the state of an input as it is now, None where that cannot be known here."""
    kind, _, name = name.partition(":")
    if kind == "package":
        return _installed(name)
    if kind == "variable":
        return variable(os.environ.get(name))
    if kind == "object":
        held = packing.held.get(name)
        return held.digest if held else None
    place = os.path.join(folder, name)
    if kind == "folder":
        return listing(place)
    if kind == "pattern":
        return names_of(matching(place))
    try:
        now = signature(place)
    except OSError:
        return ""
    return state if known and now == known else _state(place, hash_of(place))


# files


def _state(place: str, content: str) -> str:
    """Return the state of a file that held what has this hash."""
    if not place.endswith(".py") or not content:
        return content
    if content not in _syntax and (now := hash_of(place)):
        with suppress(OSError):
            _syntax[now] = syntax(Path(place).read_bytes())
    return _syntax.get(content, f"{content} as bytes")  # what was read is no longer there


_syntax: dict[str, str] = {}  # hashes of the syntax by those of the content


_parsing = Lock()  # as some versions of Python count the depth of syntax trees for all threads together


def syntax(content: bytes) -> str:
    """Return the hash of a Python file's syntax, without comments and docstrings; of its bytes where it has none."""
    try:
        with _parsing, warnings.catch_warnings(action="ignore"):  # as of an escape that is none
            tree = ast.parse(content)
        for node in ast.walk(tree):
            for name, value in [*ast.iter_fields(node)]:
                if isinstance(value, list) and not (kept := [each for each in value if not _is_text(each)]):
                    delattr(node, name)  # as versions of Python differ in which empty fields there are
                elif isinstance(value, list):
                    setattr(node, name, kept)
        return short_hash(ast.dump(tree))
    except (SyntaxError, ValueError, RecursionError, MemoryError):  # ValueError: a NUL byte; then too deep nesting
        return short_hash(content)


def _is_text(item: object) -> bool:
    return isinstance(item, ast.Expr) and isinstance(item.value, ast.Constant) and isinstance(item.value.value, str)


# packages


def _counts(top: str, packages: Mapping[str, str]) -> bool:
    """Return whether a module counts: not those that this package requires, nor what these brought in."""
    chain, left = list[str](), dict(packages)
    while top:
        chain.append(top)
        top = left.pop(top, "")  # also where packages read each other
    # What brought the others in comes first: its name is as a rule its distribution's, which is quick to find.
    names = map(_distribution, reversed(chain))
    return all(name and canonicalize_name(name) not in _environment() for name in names)


def _distribution(top: str) -> str:
    """Return the name of the distribution that has a module, "" for none."""
    return next(iter(registry.distributions_of(top)), "")


@cache
def _environment() -> set[str]:
    """Return the names of the distributions that this package requires, directly or through others, without extras."""
    found, left = set[str](), [registry.DISTRIBUTION]
    while left:
        with suppress(PackageNotFoundError):
            needed = map(Requirement, distribution(left.pop()).requires or ())
            names = {canonicalize_name(each.name) for each in needed if "extra" not in str(each.marker)}
            left += names - found
            found |= names
    return found


def _installed(name: str) -> str:
    """Return the version of a distribution, with a hash of its list of files and their hashes; "" for none."""
    with suppress(PackageNotFoundError, ValueError):
        found = distribution(name)
        return f"{found.version} {short_hash(found.read_text('RECORD') or '')}"
    return ""
