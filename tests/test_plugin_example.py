"""A stranger's package, built and installed beside the built wheel in a fresh environment, is an optimizer like any."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = ROOT / "tests" / "plugin_example"


def call(*command, cwd=None):
    """Run a program as in a shell that knows nothing of this environment."""
    ours = ("PYTHONPATH", "VIRTUAL_ENV", "PYTHONDONTWRITEBYTECODE")
    clean = {key: value for key, value in os.environ.items() if key not in ours}
    done = subprocess.run(
        list(map(str, command)), cwd=cwd, env=clean, capture_output=True, text=True, timeout=400, check=False
    )
    assert "Traceback" not in done.stderr, done.stderr
    return done


def succeed(*command, cwd=None):
    done = call(*command, cwd=cwd)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """The programs of a fresh environment that holds both wheels and nothing of this checkout."""
    place = tmp_path_factory.mktemp("stranger")
    uv = [sys.executable, "-m", "uv"]
    for source in (ROOT, EXAMPLE):
        succeed(*uv, "build", "--wheel", "--out-dir", place / "wheels", source)
    succeed(*uv, "venv", "--python", sys.executable, place / "venv")
    wheels = sorted((place / "wheels").glob("*.whl"))
    assert [wheel.name.partition("-")[0] for wheel in wheels] == ["backlash_bench", "hill_climber"]
    succeed(*uv, "pip", "install", "--python", place / "venv", *wheels, "pytest")
    return place / "venv" / ("Scripts" if os.name == "nt" else "bin")


def test_it_is_listed_with_its_package(programs, tmp_path):
    listed = json.loads(succeed(programs / "bench", "list", "--json", "optimizers", cwd=tmp_path))
    mine = next(each for each in listed if each["name"] == "hill-climber")
    assert mine["package"] == "hill-climber 0.1.0"
    assert mine["parameters"][0]["default"] == 0.2
    unmet = {each["name"]: each["error"] for each in listed if "error" in each}
    assert set(unmet) == {"mealpy", "nevergrad", "pymoo"}  # the extras are not installed there
    for name, sentence in unmet.items():
        assert f"pip install 'backlash-bench[{name}]'" in sentence


def test_a_missing_extra_is_named_in_one_sentence(programs, tmp_path):
    done = call(programs / "bench", "solve", "signature-12", "mealpy:OriginalGWO", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.strip().endswith("pip install 'backlash-bench[mealpy]'")


def test_bench_check_clears_it(programs, tmp_path):
    said = succeed(programs / "bench", "check", "hill-climber", cwd=tmp_path)
    assert "passed: hill-climber, budget" in said
    assert "FAILED" not in said


def test_bench_run_takes_it_beside_the_built_ins(programs, tmp_path):
    succeed(programs / "bench", "run", EXAMPLE / "study.toml", "--output", "out", cwd=tmp_path)
    assert "hill-climber" in (tmp_path / "out" / "report.html").read_text()
    status = succeed(programs / "bench", "status", "out", cwd=tmp_path)
    assert re.search(r"hill-climber +10 +0 +10", status)


def test_the_author_s_own_tests_pass(programs, tmp_path):
    succeed(programs / "python", "-m", "pytest", "-q", "-p", "no:cacheprovider", EXAMPLE / "tests", cwd=tmp_path)


def test_the_readme_shows_the_whole_plugin():
    code = (EXAMPLE / "src" / "hill_climber.py").read_text(encoding="utf-8").partition("from dataclasses")[2]
    assert "from dataclasses" + code in (ROOT / "README.md").read_text(encoding="utf-8")
