"""What counts of a file: a change of what it does is another hash, a change of how it reads is not."""

import pytest

from bench.plugins.syntax import facts

CODE = '''"""What it is."""

import math

STEP = 0.5


class Walk:
    """A class."""

    size: int = 3
    """Its size."""

    def move(self, x, by=1.0):
        """Move."""
        if x > 0 and by:
            return x + by * STEP, f"{x:.2f}"
        return [math.sin(x), -1, b"a", None, ...]
'''


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("STEP = 0.5", "STEP = 0.5  # of the box"),
        ('"""What it is."""', '"""What it is, at length."""'),
        ('"""What it is."""\n', ""),
        ('        """Move."""\n', ""),
        ('    """Its size."""\n', ""),
        ("\n\n\n", "\n"),
        ("\n", "\r\n"),
        ("x + by * STEP, f", "(x + (by * STEP)), f"),
        ("0.5", "5e-1"),
        ('b"a"', "b'a'"),
        ("[math.sin(x), -1,", "[\n            math.sin(x),\n            -1,"),
        ('"""What it is."""', '# coding: latin-1\n"""What it is."""'),
    ],
)
def test_a_change_of_comments_docstrings_and_layout_keeps_the_hash(old, new):
    assert old in CODE
    assert facts(CODE.replace(old, new).encode()).digest == facts(CODE.encode()).digest


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("STEP = 0.5", "STEP = 0.25"),
        ("by=1.0", "by=1"),
        ("by=1.0", "by=2.0"),
        ("x > 0", "x >= 0"),
        ("x + by", "x - by"),
        ("x + by * STEP", "(x + by) * STEP"),
        ("and", "or"),
        ("None", "True"),
        ("-1", "1"),
        ('b"a"', '"a"'),
        (".2f", ".3f"),
        ("math.sin(x), -1", "-1, math.sin(x)"),
        ("size: int = 3", "size: float = 3"),
        ("import math", "import cmath as math"),
        ("class Walk:", "class Walk(dict):"),
        ("def move", "@staticmethod\n    def move"),
    ],
)
def test_a_change_of_what_it_does_is_another_hash(old, new):
    assert old in CODE
    assert facts(CODE.replace(old, new).encode()).digest != facts(CODE.encode()).digest


def test_every_version_of_python_makes_the_same_hash():
    assert facts(CODE.encode()).digest == "f88d6cc043e8f7bd"


@pytest.mark.parametrize(
    "content", [b"def", b"a = 1\0", b"\xff\xfe", b"x = " + b"(" * 300 + b")" * 300, b"-" * 9999 + b"1"]
)
def test_a_file_that_is_no_python_counts_by_its_bytes(content):
    assert facts(content) == facts(content, python=False)
    assert facts(content) != facts(content + b" ")
    assert facts(content).imports == ()


def test_imports_are_found_wherever_they_stand():
    code = b"""
import a, b.c as d
from e import f, g as h
from i import *
def late():
    try:
        import j
    except ImportError:
        from k.l import m
    import_module("n.o"); importlib.import_module(name); importlib.import_module(".p"); __import__("q")
"""
    found = ["a", "b.c", "e", "e.f", "e.g", "i", "i.*", "j", "k.l", "k.l.m", "n.o", "q"]
    assert sorted(facts(code).imported("")) == found


@pytest.mark.parametrize(
    ("code", "found"),
    [
        ("from . import x", ["a.b", "a.b.x"]),
        ("from .c import x", ["a.b.c", "a.b.c.x"]),
        ("from .. import x", ["a", "a.x"]),
        ("from ..c.d import x", ["a.c.d", "a.c.d.x"]),
        ("from ... import x", []),
        ("from .... import x", []),
    ],
)
def test_relative_imports_start_at_the_package_of_the_module(code, found):
    assert list(facts(code.encode()).imported("a.b")) == found
    assert list(facts(code.encode()).imported("")) == []


def test_exports_are_the_plain_texts_of_all():
    assert facts(b"__all__ = ['a', 'b']").exports == ("a", "b")
    assert facts(b"__all__ = ['a', *others]").exports == ()
    assert facts(b"__all__ = 3").exports == ()
