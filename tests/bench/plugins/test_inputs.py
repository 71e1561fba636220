"""What trials are made from, by name: what counts, in which state, and what changed of it since."""

import json
import os
import subprocess
import sys

import pytest

from bench.plugins.inputs import Present, conflicts, hidden, is_data, large, named, shown, syntax
from bench.plugins.observing import hash_of, listing, matching, names_of, signature, variable


def read(*paths):
    return {"": {"files": {str(path): [hash_of(str(path)), signature(str(path))] for path in paths}}}


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("def f(x):\n    return x + 1  # more\n", True), ('def f(x):\n    "Say it."\n    return x + 1\n', True),
        ("def f( x ):\n\n    return (x + 1)\n", True), ("def f(x):\n    return x + 2\n", False),
        ("def f(x):\n    return x - 1\n", False), ("def f(y):\n    return y + 1\n", False),
        ("def f(x):\n    return x + True\n", False), ("def f(x):\n    return x + 1.0\n", False),
    ],
)  # fmt: skip
def test_the_state_of_a_python_file_is_that_of_its_syntax(text, same):
    assert (syntax(text.encode()) == syntax(b"def f(x):\n    return x + 1\n")) is same


@pytest.mark.parametrize("content", [b"def (", b"\x00", b"(" * 10_000])
def test_what_is_no_python_is_compared_by_its_bytes(content):
    assert syntax(content) == syntax(content) != syntax(content + b" ")


def test_files_of_the_working_folder_are_named_from_there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text("A = 1")
    assert [*named(read(tmp_path / "mine.py"))] == ["file:mine.py"]
    monkeypatch.chdir(tmp_path.parent)
    assert [*named(read(tmp_path / "mine.py"))] == [f"file:{tmp_path.name}/mine.py"]


def test_a_file_is_read_again_only_where_its_signature_differs(tmp_path, monkeypatch):
    data = tmp_path / "data.bin"
    data.write_text("a")
    assert named(read(data))[f"file:{data}"][1] == []  # it may be written again with the same times
    monkeypatch.setattr("bench.plugins.observing._RACY", 0)
    recorded = named(read(data))
    monkeypatch.setattr("hashlib.sha256", lambda: pytest.fail("read again"))
    assert Present().changed(recorded) == []
    assert large([recorded]) == {str(data): recorded[f"file:{data}"]}
    monkeypatch.undo()
    os.utime(data, ns=(1, 1))
    assert Present().changed(recorded) == []
    data.write_text("b")
    assert Present().changed(recorded) == [f"file:{data}"]
    data.unlink()
    assert Present().changed(recorded) == [f"file:{data}"]
    assert Present(strict=False).changed(recorded) == []  # of results that are read where the file is not


def test_packages_that_the_harness_requires_and_what_they_drag_in_are_no_inputs():
    packages = {"numpy": "", "scipy": "numpy", "yaml": "numba", "pytest": "", "iniconfig": "pytest"}
    assert [*named({"": {"packages": packages}})] == ["package:iniconfig", "package:pytest"]
    assert "package:cma" in named({"": {"packages": packages, "libraries": {"cma": "named"}}})


def test_the_files_of_others_are_left_out():
    observed = {"": {"files": {"/a": ["1", []]}}, "q": {"files": {"/b": ["2", []]}}}
    assert [*named(observed, ("p", "o"))] == ["file:/a"]
    assert [*named(observed, ("q", "o"))] == ["file:/a", "file:/b"]


def test_what_one_alone_has_read_is_no_conflict():
    one, other = {"file:a": ("1", []), "file:b": ("2", [])}, {"file:b": ("2", [4]), "file:c": ("3", [])}
    assert conflicts(one, other) == []
    assert conflicts(one, other | {"file:a": ("9", [])}) == ["file:a"]


def test_a_module_that_is_found_elsewhere_hides_the_recorded_one(tmp_path):
    for folder in ("first", "second"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "helper.py").write_text("A = 1")
    recorded = named(read(tmp_path / "second" / "helper.py"))
    assert hidden(recorded, {"helper": str(tmp_path / "second" / "helper.py")}) == []
    assert hidden(recorded, {"helper": str(tmp_path / "first" / "helper.py")}) == [f"file:{tmp_path}/first/helper.py"]
    assert hidden(recorded, {"other": str(tmp_path / "first" / "other.py")}) == []


def test_variables_folders_and_patterns_have_states(tmp_path, monkeypatch):
    monkeypatch.setenv("BENCH_TEST", "1")
    (tmp_path / "a.csv").write_text("1")
    pattern = f"{tmp_path}/*.csv"
    read = {
        "variables": {"BENCH_TEST": variable("1")}, "folders": {str(tmp_path): listing(str(tmp_path))},
        "patterns": {pattern: names_of(matching(pattern))},
    }  # fmt: skip
    recorded = named({"": read})
    assert Present().changed(recorded) == []
    monkeypatch.delenv("BENCH_TEST")
    (tmp_path / "b.csv").write_text("1")
    assert [shown(name) for name in Present().changed(recorded)] == [
        f"the files in {tmp_path}", f"the files {pattern}", "the variable BENCH_TEST"
    ]  # fmt: skip


@pytest.mark.parametrize(("name", "expected"), [("file:a.csv", True), ("file:a.py", False), ("package:a", False)])
def test_data_are_what_is_no_code(name, expected):
    assert is_data(name) is expected


LATE = """
import json, sys
import numpy as np
from bench import FunctionProblem, Objective
from bench.plugins.observing import observe, observed, reading
observe()
with reading("problem", "p"):
    problem = FunctionProblem(lambda x: x[:, 0] + len(open(sys.argv[1]).read()), [0], [1], vectorized=True)
with reading("optimizer", "o"):
    open(sys.argv[2]).close()
    Objective(problem, 5, np.random.default_rng(0))([0.5])
print(json.dumps({part: [*read[""]["files"]] for part, read in observed().items()}))
"""


def test_what_a_problem_reads_while_it_is_evaluated_is_an_input_of_the_problem(tmp_path):
    files = [str(tmp_path / name) for name in ("data.txt", "late.py")]
    for file in files:
        (tmp_path / file).write_text(LATE)
    done = subprocess.run([sys.executable, files[1], *files], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == {"problem": files[:1], "optimizer": files[1:]}
