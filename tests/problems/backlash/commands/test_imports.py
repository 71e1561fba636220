"""Start-up: the command line imports every command for its help, so none may import a numerical library for it."""

import subprocess
import sys

import pytest

HEAVY = {"numpy", "scipy", "pandas", "numba", "matplotlib", "joblib", "pooch", "requests"}


def imported(code):
    code = f"import sys\n{code}\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    return set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split())


@pytest.mark.parametrize("command", ["calibrate", "data", "estimate", "simulate"])
def test_a_command_imports_no_numerical_library(command):
    assert not HEAVY & imported(f"import problems.backlash.commands.{command}")
