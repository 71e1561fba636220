"""The examples, built and installed beside the built wheel in one fresh environment, do what their READMEs promise."""

import json
import os
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from bench import load_results

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "examples"
OPTIMIZER, PROBLEM, TOPIC, STUDY = (EXAMPLES / kind for kind in ("optimizer", "problem", "topic", "study"))
TIMES = ["wall_s", "cpu_s", "objective_s", "memory_mb"]


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


@pytest.fixture(scope="session")
def wheels(tmp_path_factory):
    """The wheels of this project and of the example packages, by the names of their distributions."""
    folder = tmp_path_factory.mktemp("wheels")
    uv = [sys.executable, "-m", "uv"]
    succeed(*uv, "build", "--out-dir", folder, ROOT)  # the sdist, and the wheel from it
    for source in (OPTIMIZER, PROBLEM, TOPIC):
        succeed(*uv, "build", "--wheel", "--out-dir", folder, source)
    return {wheel.name.partition("-")[0]: wheel for wheel in sorted(folder.glob("*.whl"))}


@pytest.fixture(scope="session")
def programs(wheels, tmp_path_factory):
    """The programs of a fresh environment that holds all wheels and nothing of this checkout."""
    place = tmp_path_factory.mktemp("stranger") / "venv"
    uv = [sys.executable, "-m", "uv"]
    succeed(*uv, "venv", "--python", sys.executable, place)
    succeed(*uv, "pip", "install", "--python", place, *wheels.values(), "pytest")
    return place / ("Scripts" if os.name == "nt" else "bin")


# The packages


@pytest.mark.slow
def test_the_wheel_holds_the_marks_of_typed_packages(wheels):
    assert list(wheels) == ["backlash_bench", "hill_climber", "water_filling", "worst_runs"]
    held = zipfile.ZipFile(wheels["backlash_bench"]).namelist()
    for package in ("bench", "optimizers", "problems"):
        assert f"{package}/py.typed" in held
    assert "bench/examples/optimizer/.github/workflows/tests.yml" in held
    assert {name.partition("/")[0].partition("-")[0] for name in held} == {
        "bench", "optimizers", "problems", "backlash_bench"
    }  # fmt: skip


@pytest.mark.slow
def test_the_sdist_holds_what_a_build_needs_and_no_more(wheels):
    (sdist,) = wheels["backlash_bench"].parent.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        held = {name.split("/")[1] for name in archive.getnames() if "/" in name}
    assert held == {
        "bench", "optimizers", "problems", "examples", "pyproject.toml", "PKG-INFO", "README.md", "LICENSE",
        "CHANGELOG.md", "CITATION.cff", "docs", ".gitignore",
    }  # fmt: skip


@pytest.mark.slow
def test_the_optimizer_is_listed_with_its_package(programs, tmp_path):
    listed = json.loads(succeed(programs / "bench", "list", "--json", "optimizers", cwd=tmp_path))
    mine = next(each for each in listed if each["name"] == "hill-climber")
    assert mine["package"] == "hill-climber 0.1.0"
    assert mine["parameters"][0]["default"] == 0.2
    unmet = {each["name"]: each["error"] for each in listed if "error" in each}
    families = {name.partition(":")[0] for name in unmet}
    assert families == {"mealpy", "minion", "nevergrad", "optuna", "pymoo"}  # the extras are not installed there
    for name, sentence in unmet.items():
        assert f"pip install 'backlash-bench[{name.partition(':')[0]}]'" in sentence


@pytest.mark.slow
def test_bench_run_takes_the_problems(programs, tmp_path):
    assert "water-filling-2 … water-filling-8" in succeed(programs / "bench", "list", "problems", cwd=tmp_path)
    succeed(programs / "bench", "run", PROBLEM / "study.toml", "--output", "out", "--no-report", cwd=tmp_path)
    assert re.search(r"cma-es +30 +0 +30", succeed(programs / "bench", "status", "out", cwd=tmp_path))
    frame = load_results(tmp_path / "out")
    assert (frame["capacity_bits"] == -frame["fun"]).all()


@pytest.mark.slow
@pytest.mark.parametrize("package", [OPTIMIZER, PROBLEM, TOPIC], ids=["optimizer", "problem", "topic"])
def test_the_author_s_own_tests_pass(package, programs, tmp_path):
    succeed(programs / "python", "-m", "pytest", "-q", "-p", "no:cacheprovider", package / "tests", cwd=tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "name", "checks"),
    [
        ("optimizer", "my-swarm", ["check", "my-swarm", "--no-bias"]),
        ("problem", "my-field", ["list", "problems"]),
        ("topic", "my-topic", ["run", "my-topic/study.toml"]),
    ],
)
def test_a_new_package_builds_installs_and_passes_its_tests(kind, name, checks, programs, tmp_path):
    """What 'bench new' of the installed wheel writes; the folder of the fresh environment holds the templates."""
    uv = [sys.executable, "-m", "uv"]
    succeed(programs / "bench", "new", kind, name, cwd=tmp_path)
    succeed(*uv, "build", "--out-dir", "dist", name, cwd=tmp_path)
    wheels, sources = (list((tmp_path / "dist").glob(f"*.{end}")) for end in ("whl", "tar.gz"))
    assert (len(wheels), len(sources)) == (1, 1)
    succeed(*uv, "pip", "install", "--python", programs.parent, "--no-deps", *wheels)
    assert name in succeed(programs / "bench", *checks, cwd=tmp_path)
    succeed(
        programs / "python", "-m", "pytest", "-q", "-p", "no:cacheprovider", tmp_path / name / "tests", cwd=tmp_path
    )
    again = call(programs / "bench", "new", kind, name, "--output", "other", cwd=tmp_path)
    assert again.stderr == f"bench: {name} 0.1.0 has the {kind} {name!r} already; choose another name\n"


# Beside another package with a module of the same name

NEEDED = ("cloudpickle", "joblib", "numpy", "packaging", "tomli-w", "typer")
"""The packages that every command imports."""


@pytest.fixture
def alone(wheels, tmp_path):
    """Return a function that installs wheels, or this project's, into an environment that has nothing else."""
    place = tmp_path / "venv"
    uv = [sys.executable, "-m", "uv"]
    succeed(*uv, "venv", "--python", sys.executable, place)
    succeed(*uv, "pip", "install", "--python", place, *NEEDED)

    def install(*packages, command="install", options=("--no-deps", "--force-reinstall")):
        succeed(*uv, "pip", command, "--python", place, *options, *packages)

    install.programs = place / ("Scripts" if os.name == "nt" else "bin")
    install.own = wheels["backlash_bench"]
    return install


def other_package(folder, module):
    """Write the wheel of another package that has a module of that name, and return its path."""
    wheel, about = folder / f"other_{module}-1.0-py3-none-any.whl", f"other_{module}-1.0.dist-info"
    files = {
        f"{module}/__init__.py": "OTHER = True\n",
        f"{about}/METADATA": f"Metadata-Version: 2.1\nName: other-{module}\nVersion: 1.0\n",
        f"{about}/WHEEL": "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    files[f"{about}/RECORD"] = "".join(f"{name},,\n" for name in [*files, f"{about}/RECORD"])
    with zipfile.ZipFile(wheel, "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return wheel


@pytest.mark.slow
@pytest.mark.parametrize("module", ["bench", "optimizers"])
def test_a_package_that_replaced_a_module_is_named_until_this_one_is_installed_again(alone, module, tmp_path):
    alone(alone.own)
    assert call(alone.programs / "bench", "--help").returncode == 0
    alone(other_package(tmp_path, module))
    for arguments in (["--help"], ["list"], ["run", "quick"]):
        done = call(alone.programs / "bench", *arguments)
        assert done.returncode == 2
        assert done.stderr.count("\n") == 1
        assert f"the module '{module}' found at" in done.stderr
        assert "run 'pip install --force-reinstall" in done.stderr
    assert call(alone.programs / "bench", "--version").returncode == 0
    alone(alone.own)
    assert call(alone.programs / "bench", "--help").returncode == 0


# The study


@pytest.mark.slow
def test_the_study_gives_the_same_numbers_from_python_and_from_the_command_line(programs, tmp_path):
    printed = succeed(programs / "python", STUDY / "smallest.py", cwd=tmp_path)
    assert re.search(r"^engineering-spring( +[\d.e+-]+){2}$", printed, re.MULTILINE)
    assert (tmp_path / "results" / "runs" / "smallest" / "report.html").exists()
    succeed(programs / "bench", "run", STUDY / "smallest.toml", "--output", "other", "--no-report", cwd=tmp_path)
    frames = [load_results(tmp_path / each).drop(columns=TIMES) for each in ("results/runs/smallest", "other")]
    assert frames[0].equals(frames[1])
    assert len(frames[0]) == 60


# The tuning
