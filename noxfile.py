"""The project's sessions: ``nox -s tests``, ``tests-3.12`` and so on, ``lowest``, ``nightly``, ``lint``, ``types``,
``workflows``, ``docs``, ``benchmark`` and ``release``.

``tests`` runs on the interpreter that runs nox; ``tests-3.12`` on that version, which uv downloads where it is missing;
without uv the session is then skipped.
"""

import os
from pathlib import Path

import nox

nox.options.default_venv_backend = "uv|venv"  # uv, where it is installed, is ten times as fast as pip
os.environ["UV_COMPILE_BYTECODE"] = "1"  # as pip does: else each of the first processes compiles what it imports
nox.options.reuse_existing_virtualenvs = True
nox.options.error_on_missing_interpreters = False  # without uv, which gets missing ones, they are skipped
nox.options.sessions = ["lint", "types", "tests"]

PROJECT = nox.project.load_toml("pyproject.toml")
VERSIONS = nox.project.python_versions(PROJECT)  # from the classifiers in pyproject.toml
COVERED = {"bench/analysis": 95, "bench/storage": 90, "bench/execution": 75}  # percent of lines, at least


def group(name: str) -> list[str]:
    """Return the requirements of a dependency group of pyproject.toml."""
    return nox.project.dependency_groups(PROJECT, name)


def run_tests(session: nox.Session, *arguments: str) -> None:
    """Run pytest on every core, in the order of tests/conftest.py."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    workers = str(cores + 2)  # tests wait for processes that they start
    together = ("-n", workers, "--dist", "loadfile", "--no-loadscope-reorder")
    session.run("python", "-m", "pytest", *together, *arguments, *session.posargs)


@nox.session
def tests(session: nox.Session) -> None:
    """Run the tests that are not slow and name the slowest of them; arguments after -- go to pytest."""
    session.install("-e", ".", *group("test"))
    run_tests(session, "--durations=25")


@nox.session
def nightly(session: nox.Session) -> None:
    """Run the whole suite, slow tests too, and compare the coverage of the core packages with their floors."""
    session.install("-e", ".", *group("test"), *group("coverage"))
    packages = [f"--cov={package}" for package in COVERED]
    pages = "--ignore=tests/docs"  # 'nox -s docs' runs them
    run_tests(session, "-m", "slow or not slow", pages, *packages, "--cov-report=")
    for package, floor in COVERED.items():
        session.run("coverage", "report", f"--include={package}/*", "--skip-covered", f"--fail-under={floor}")


@nox.session(python=VERSIONS[0], venv_backend="uv")
def lowest(session: nox.Session) -> None:
    """Run the tests that are not slow with the lowest versions that pyproject.toml allows."""
    session.install("--resolution", "lowest-direct", "-e", ".", *PROJECT["project"]["dependencies"])
    session.install(*group("test"))  # of what is there already, the versions stay
    run_tests(session)


for version in VERSIONS:

    @nox.session(name=f"tests-{version}", python=version)
    def tests_on_version(session: nox.Session) -> None:
        """Run the tests on this version of Python; arguments after -- go to pytest."""
        tests(session)


@nox.session
def lint(session: nox.Session) -> None:
    """Check style, formatting, and that packages import only what their layer may."""
    session.install(*group("lint"))
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")
    session.run("lint-imports")
    session.run("biome", "ci")


@nox.session
def types(session: nox.Session) -> None:
    """Check types, strictly."""
    session.install("-e", ".", *group("types"))
    session.run("mypy")


@nox.session
def workflows(session: nox.Session) -> None:
    """Check the workflows, ours and those that 'bench new' writes; installing actionlint needs GitHub."""
    session.install(*group("workflows"))
    files = [str(file) for folder in (".github/workflows", "examples") for file in Path(folder).rglob("*.yml")]
    session.run("actionlint", *files)


@nox.session
def benchmark(session: nox.Session) -> None:
    """Reproduce the thesis's comparison, check it, and write its report; arguments after -- go to 'bench run'."""
    session.install("-e", ".")
    # Without bytecode files of this package, which uv does not write, each of the run's processes would compile it.
    command = "bench", "run", "thesis", "--check", "--verify", "1", *session.posargs
    session.run(*command, env={"PYTHONDONTWRITEBYTECODE": ""})


@nox.session
def performance(session: nox.Session) -> None:
    """Measure what the performance page shows, and write its JSON; "-- --quick" tries the scripts with small sizes."""
    session.install("-e", ".[suites]", *group("test"), "ioh")
    session.run("python", "performance", *session.posargs, env={"PYTHONDONTWRITEBYTECODE": ""})  # as for 'benchmark'


@nox.session
def release(session: nox.Session) -> None:
    """Build sdist and wheel, and try them in fresh environments; --rehearse goes on without a date in the changelog."""
    session.install(*group("release"))
    session.run("python", "tools/release.py", *session.posargs)


@nox.session
def docs(session: nox.Session) -> None:
    """Build the site into docs/_build/html, check it and run its code; "-- linkcheck" tries links to other sites."""
    session.install(".", *group("docs"), *group("test"))
    session.install("--force-reinstall", "--no-deps", ".")  # the copy of now, as users have it, runs the code blocks
    strict = "-W", "-n", "-E", "--keep-going"
    session.run("sphinx-build", *strict, "-b", "html", "docs", "docs/_build/html")
    every = ("-m", "slow or not slow")  # the code blocks of the pages, too
    side_by_side = ("-n", "2", "--dist", "worksteal")
    session.run("pytest", "tests/docs", *every, *side_by_side, env={"BENCH_SITE": "docs/_build/html"})
    if "linkcheck" in session.posargs:
        session.run("sphinx-build", *strict, "-b", "linkcheck", "docs", "docs/_build/linkcheck")
