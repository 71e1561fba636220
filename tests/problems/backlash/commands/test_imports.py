"""Start-up: the command line imports every command for its help, so none may import a numerical library for it."""

import subprocess
import sys

import pytest

from bench.plugins import catalogue
from problems.backlash.commands.data import data

HEAVY = {"numpy", "scipy", "pandas", "numba", "matplotlib", "joblib", "pooch", "requests"}


def imported(code):
    code = f"import sys\n{code}\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    return set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split())


@pytest.mark.parametrize("command", ["calibrate", "data", "estimate", "simulate"])
def test_a_command_imports_no_numerical_library(command):
    assert not HEAVY & imported(f"import problems.backlash.commands.{command}")


def test_a_single_estimate_imports_neither_scipy_stats_nor_joblib():
    code = "import problems.backlash.sensor.batch, problems.backlash.sensor.formatting\n"
    code += "sys.modules = [name.replace('scipy.stats', 'stats') for name in sys.modules]"
    assert not {"stats", "joblib", "matplotlib"} & imported(code)


def test_a_command_with_sub_commands_is_listed_by_its_help():
    assert catalogue.first_line(data) == "Get the thesis authors' published recordings, and check them."
