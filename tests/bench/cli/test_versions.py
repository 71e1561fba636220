"""What ``bench --version`` prints, and what the Tab key completes."""

import os
import subprocess
import sys
from importlib.metadata import version

import pytest


@pytest.fixture
def printed(bench_here):
    """Return a function that gives the printed versions by name."""
    return lambda: dict(line.split("  ", 1) for line in bench_here("--version").stdout.splitlines())


def test_libraries_platform_and_extras_are_printed(printed):
    found = {name: value.strip() for name, value in printed().items()}
    assert found["numpy"] == version("numpy")
    assert found["extra parquet"] == f"pyarrow {version('pyarrow')}"
    assert "threads" in found["BLAS"]
    assert {"Python", "scipy", "numba", "cma", "pandas", "platform", "extra mealpy"} <= set(found)


def test_it_works_where_a_foreign_module_stops_every_other_command(tmp_path):
    (tmp_path / "optimizers.py").write_text("")
    there = {"cwd": tmp_path, "env": os.environ | {"PYTHONPATH": str(tmp_path)}, "capture_output": True, "text": True}
    assert subprocess.run([sys.executable, "-m", "bench", "--version"], **there).returncode == 0
    done = subprocess.run([sys.executable, "-m", "bench", "list"], **there)
    assert done.returncode == 2
    assert "the module 'optimizers' found at" in done.stderr
    assert "Traceback" not in done.stderr
