"""Loops are compiled at their first call and read from the disk by the next process; every work is cited."""

import subprocess
import sys
from pathlib import Path

import pytest

import optimizers
from bench.helpers.bibtex import parse

LOOPS = """
import math

from optimizers.common.base import compiled


@compiled
def outer(n):
    total = 0.0
    for i in range(n):
        total += inner(i + 1) / 0.0
    return total


@compiled
def inner(i):
    '''Return a square.'''
    return float(i * i)
"""

PROGRAM = """
import sys

import loops

assert "numba" not in sys.modules
assert (loops.inner.__name__, loops.inner.__doc__) == ("inner", "Return a square.")
assert loops.outer(3) == float("inf")  # by numpy's rules of division
assert loops.inner(3) == 9.0
print(sum(loops.outer.dispatcher.stats.cache_hits.values()), sum(loops.inner.dispatcher.stats.cache_hits.values()))
"""


@pytest.mark.slow
def test_a_function_is_compiled_at_its_first_call_and_read_from_the_disk_by_the_next_process(tmp_path):
    (tmp_path / "loops.py").write_text(LOOPS)
    run = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n{PROGRAM}"]
    hits = [subprocess.run(run, check=True, capture_output=True, text=True).stdout.split() for _ in range(2)]
    assert hits == [["0", "0"], ["1", "1"]]


def test_every_work_is_there_once_and_cited():
    home = Path(optimizers.__file__).parent
    keys = [work.key for work in parse((home / "references.bib").read_text(encoding="utf-8"))]
    assert len(keys) == len(set(keys))
    sources = "".join(path.read_text(encoding="utf-8") for path in home.iterdir() if path.suffix in (".py", ".toml"))
    assert [key for key in keys if f'"{key}"' not in sources] == []
