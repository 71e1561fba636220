"""Changes of installed packages, and of objects of a session, are named."""

import pytest

from bench import Study, run
from bench.execution.runner import plan
from bench.plugins.packing import pack

OPTIMIZER = """
import {name}

def mine(objective, rng):
    objective(objective.lower + {name}.SHARE * (objective.upper - objective.lower))
    objective.stop("done")
"""


def install(site, name, version, share, more="", drags=""):
    """Write an installed package, as pip does."""
    package, about = site / name, site / f"{name}-{version}.dist-info"
    package.mkdir(parents=True, exist_ok=True)
    for old in site.glob(f"{name}-*.dist-info"):
        for file in old.iterdir():
            file.unlink()
        old.rmdir()
    about.mkdir()
    (package / "__init__.py").write_text(f"{drags}\nSHARE = {share}\n")
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    (about / "RECORD").write_text(f"{name}/__init__.py,sha256={share}{more},1\n")


@pytest.mark.parametrize(
    ("name", "change", "named"),
    [
        ("pack_upgraded", {"version": "1.1", "share": 0.75}, "pack_upgraded"),
        ("pack_reinstalled", {"version": "1.0", "share": 0.75}, "pack_reinstalled"),
        ("pack_dragged", None, "pack_below"),
    ],
)
def test_a_package_that_changed_is_named(name, change, named, tmp_path, monkeypatch):
    site = tmp_path / "site-packages"
    install(site, "pack_below", "1.0", 0.25)
    drags = "from pack_below import SHARE as BELOW" if change is None else ""
    install(site, name, "1.0", "BELOW" if drags else 0.25, drags=drags)
    monkeypatch.syspath_prepend(site)
    (tmp_path / "mine.py").write_text(OPTIMIZER.format(name=name))
    study = Study.from_dict(
        {"name": "s", "trials": 1, "budget": 20, "problems": ["sphere-2"],
         "optimizers": [{"name": f"{tmp_path}/mine.py:mine"}]}
    )  # fmt: skip
    assert run(study, tmp_path / "out", n_jobs=1, verify=False).failed == 0
    assert plan(study, tmp_path / "out").notes == []
    install(site, "pack_below", "1.1", 0.75) if change is None else install(site, name, **change)
    [note] = plan(study, tmp_path / "out").notes
    assert note == f"mine changed ({named}) and is version 2 now: 1 trial to make; the 1 of version 1 are kept"


BEFORE = """
import functools
import numpy as np

K, TABLE, NAMES = 2, np.arange(3.0), {"a": 1}

def helper(x):
    return x * K

def below(x, power=2):
    return helper(x) ** power

def make(c):
    def inner(x, *, offset=0.5):
        return x + c + offset
    return inner

class Base:
    scale = 1.0

    def of(self, x):
        return x * self.scale

class Own(Base):
    def __init__(self, width=3.0):
        self.width = width

    @property
    def wide(self):
        return self.width * 2

    @staticmethod
    def fixed(x):
        return x + 1

    def __call__(self, x):
        return below(self.of(x)) + TABLE.sum() + NAMES["a"] + self.fixed(self.wide)

def decorated(f):
    @functools.wraps(f)
    def wrapper(x):
        return f(x) * 7
    return wrapper

thing = (Own(), make(1), decorated(below), functools.partial(below, power=3), lambda x: x - 4)
thing[2].level = 6
"""

SESSIONS = {
    "global number": ("K, TABLE, NAMES = 2,", "K, TABLE, NAMES = 3,"),
    "global array": ("np.arange(3.0)", "np.arange(1, 4.0)"),
    "global dict": ('{"a": 1}', '{"a": 2}'),
    "body": ("return x * K", "return x / K"),
    "default": ("power=2", "power=4"),
    "keyword default": ("offset=0.5", "offset=0.6"),
    "enclosed variable": ("make(1)", "make(2)"),
    "attribute of a base class": ("scale = 1.0", "scale = 2.0"),
    "method of a base class": ("x * self.scale", "x + self.scale"),
    "state": ("width=3.0", "width=5.0"),
    "property": ("self.width * 2", "self.width * 3"),
    "static method": ("return x + 1", "return x + 2"),
    "decorator": ("f(x) * 7", "f(x) * 8"),
    "partial": ("power=3", "power=5"),
    "lambda": ("x - 4", "x - 5"),
    "attribute of a function": ("level = 6", "level = 9"),
}


def digest(source):
    found = {"__name__": "__main__"}
    exec(source, found)
    return pack(found["thing"]).digest


@pytest.mark.parametrize("name", SESSIONS)
def test_an_object_of_a_session_that_changed_is_another_one(name):
    before, after = SESSIONS[name]
    assert BEFORE.count(before) == 1
    assert digest(BEFORE.replace(before, after)) != digest(BEFORE)


def test_an_object_of_a_session_with_another_comment_is_the_same():
    assert digest(f"# a comment\n\n{BEFORE}") == digest(BEFORE) == digest(BEFORE.replace("\ndef ", "\n\ndef "))


def test_a_changed_object_is_named_as_such(tmp_path):
    def study(share):
        def mine(objective, rng):
            objective(objective.lower + share * (objective.upper - objective.lower))
            objective.stop("done")

        return Study.from_dict({"name": "s", "trials": 1, "budget": 20, "problems": ["sphere-2"], "optimizers": [mine]})

    assert run(study(0.25), tmp_path / "out", n_jobs=1, verify=False).failed == 0
    assert plan(study(0.25), tmp_path / "out").notes == []
    [note] = plan(study(0.75), tmp_path / "out").notes
    assert note.startswith("mine changed (its own code or data) and is version 2 now")


def test_two_objects_with_one_content_are_warned_of(tmp_path):
    functions = []
    for k in (1, 2):
        functions.append(lambda objective, rng: objective(objective.initial(k)))  # noqa: B023 - as beginners write it
    named = [{"name": each, "label": name} for name, each in zip(("first", "second"), functions, strict=True)]
    with pytest.warns(UserWarning, match="python:second has the same code and data as python:first"):
        Study.from_dict({"name": "s", "problems": ["p"], "optimizers": named})
