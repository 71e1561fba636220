"""What travels by its value: its hash depends on code and data alone, and its copy works elsewhere."""

import functools
import subprocess
import sys
import threading
from dataclasses import MISSING, dataclass, field, fields
from typing import Literal

import numpy as np
import pytest

from bench import BenchError, FunctionProblem, Optimizer
from bench.plugins.packing import pack, unpack

SESSION = '''
from __future__ import annotations
import functools, sys
from dataclasses import dataclass
from typing import Literal
import numpy as np
import bench
from bench.plugins.packing import pack

W = np.arange(3.0)
K = {"b": 1, "a": frozenset(range(3))}

def helper(x):
    return x @ W

def f(x):
    """Say what it does."""
    return helper(x) + len(K) + (x[0] in {"p", "q", "r"})

@dataclass(frozen=True)
class Mine(bench.Optimizer):
    F: float = 0.5
    kind: Literal["a", "b"] = "a"

    def minimize(self, objective, rng):
        objective(objective.initial(1) * self.F)

class Called:
    def __init__(self):
        self.a = 3

    def __call__(self, x):
        return self.a * x.sum()

    method = __call__

things = [f, lambda x: x @ W, Mine, Mine(F=0.9), Called(), Called().method, functools.partial(f, x=1),
          bench.FunctionProblem(f, [0], [1]), np.random.default_rng(1)]
print(*(pack(each).digest for each in things))
'''


def digests(text, hash_seed):
    done = subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, check=True, env={"PYTHONHASHSEED": str(hash_seed)}
    )
    return done.stdout.split()


def test_the_same_session_again_has_the_same_hashes_and_a_changed_one_other_ones():
    first, again = digests(SESSION, 1), digests(f"# a comment\n\n{SESSION}", 2)
    assert first == again
    assert len({*first}) == len(first) == 9
    reads_w = digests(SESSION.replace("np.arange(3.0)", "np.arange(1, 4.0)"), 1)  # data that functions read
    assert [a != b for a, b in zip(first, reads_w, strict=True)] == [True, True, *[False] * 4, True, True, False]
    body = digests(SESSION.replace("objective.initial(1)", "objective.initial(2)"), 1)
    assert [a != b for a, b in zip(first, body, strict=True)] == [False, False, True, True, *[False] * 5]


def test_two_functions_of_one_line_differ_by_what_they_do_and_by_what_they_enclose():
    first, second = (lambda x: x + 1), (lambda x: x + 2)  # fmt: skip
    enclosing = [(lambda x, c=c: x + c) for c in (1, 2)]
    assert len({pack(each).digest for each in (first, second, *enclosing)}) == 4
    assert pack(first).digest == pack(lambda x: x + 1).digest


def test_a_copy_works_where_nothing_of_the_original_is(tmp_path):
    @dataclass(frozen=True)
    class Local(Optimizer):
        kind: 'Literal["a", "b"]' = "a"  # a text, which another process could not look up

        def minimize(self, objective, rng):
            """Do nothing."""

    scale = np.array([1.0, 2.0])
    (tmp_path / "f").write_bytes(pack(FunctionProblem(lambda x: x @ scale, [0, 0], [1, 1])).content)
    (tmp_path / "o").write_bytes(pack(Local).content)
    code = f"""
from pathlib import Path
import numpy as np
from bench.plugins.packing import unpack
from bench.contract.optimizer import build
problem, kind = (unpack(Path({str(tmp_path)!r}, name).read_bytes()) for name in "fo")
print(problem.evaluate(np.ones((1, 2))), build(kind, "Local", {{"kind": "b"}}).kind)
try:
    build(kind, "Local", {{"kind": "c"}})
except ValueError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["[3.] b", "parameter 'kind' of Local must be one of 'a', 'b', not 'c'"]


def test_a_copy_of_a_dataclass_knows_which_fields_have_no_default():
    @dataclass(frozen=True)
    class Local:
        a: int
        b: list = field(default_factory=list)

    copy = unpack(pack(Local).content)
    assert [each.default is MISSING for each in fields(copy)] == [True, True]
    assert copy(1).b == []


def test_what_is_imported_travels_by_name():
    assert len(pack(functools.partial(np.linalg.norm, ord=1)).content) < 300


def test_a_module_that_was_changed_in_the_session_is_refused_by_name(tmp_path, monkeypatch):
    (tmp_path / "cfg_of_session.py").write_text("K, NAME, _calls = 10, 'a', 0\n")
    monkeypatch.syspath_prepend(tmp_path)
    import cfg_of_session as cfg

    code = "import sys; from bench.plugins.packing import unpack; print(unpack(sys.stdin.buffer.read())(1))"

    def elsewhere():
        packed = pack(lambda x: x + cfg.K)
        return subprocess.run(
            [sys.executable, "-c", f"import sys; sys.path.append({str(tmp_path)!r}); {code}"],
            input=packed.content, capture_output=True,
        )  # fmt: skip

    assert elsewhere().stdout == b"11\n"
    cfg._calls = 3
    assert elsewhere().stdout == b"11\n"
    cfg.K = 1000
    assert b"cfg_of_session.K is 1000 in this session, but 10 in its file" in elsewhere().stderr


def test_what_a_function_has_as_an_attribute_is_compared():
    def counted(x):
        return x * counted.K

    counted.K = 3
    before = pack(counted).digest
    assert pack(counted).digest == before
    counted.K = 4
    assert pack(counted).digest != before


def test_what_cannot_travel_is_one_sentence():
    lock = threading.Lock()

    def locked(x):
        with lock:
            return x

    with pytest.raises(BenchError, match=r"^'locked' cannot be sent to other processes \(TypeError: cannot pickle"):
        pack(locked)


def test_what_has_no_hash_of_its_value_is_hashed_as_it_travels():
    class Odd:
        def __reduce_ex__(self, protocol):
            if protocol == 3:  # as joblib asks
                raise ValueError("not so")
            return str, ("odd",)

    assert unpack(pack(Odd()).content) == "odd"
    assert len(pack(Odd()).digest) == 16


def test_functions_that_call_themselves_or_are_compiled_have_hashes():
    numba = pytest.importorskip("numba")

    def recursive(n):
        return n and recursive(n - 1)

    assert pack(recursive).digest == pack(recursive).digest
    compiled = [numba.njit(lambda x: x.sum() * 2), numba.njit(lambda x: x.sum() * 2), numba.njit(lambda x: x.sum())]
    first, again, other = (pack(lambda x, f=f: f(x)).digest for f in compiled)
    assert first == again != other
