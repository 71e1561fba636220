import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest
import typer
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.layout_engine import ConstrainedLayoutEngine

from bench.cli import app
from bench.contract import objective
from bench.plugins import registry
from tests.bench.objectives import LOOPS
from tests.bench.reports import make as make
from tests.bench.reports import read as read

INSTALLED = Path(__file__).parent / "installed"


@pytest.fixture(scope="package", autouse=True)
def testing_plugins():
    """Put the tests' own plug-in package on the path of this process and of every worker and command it starts.

    Other folders' tests, which the same process may run, do not see it.
    """
    sys.path.append(str(INSTALLED))
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [before, str(INSTALLED)]))
    registry.entries.cache_clear()
    yield
    sys.path.remove(str(INSTALLED))
    os.environ.pop("PYTHONPATH")
    if before is not None:
        os.environ["PYTHONPATH"] = before
    registry.entries.cache_clear()


@pytest.fixture(scope="package")
def bench(testing_plugins):
    """Return a function that runs the command line in a process of its own."""

    def run(*arguments, cwd=None, **environment):
        done = subprocess.run(
            [sys.executable, "-m", "bench", *map(str, arguments)],
            capture_output=True, text=True, cwd=cwd, env=os.environ | environment, timeout=300, check=False,
        )  # fmt: skip
        assert "Traceback" not in done.stderr + done.stdout, done.stderr
        return done

    return run


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Return a function that installs a package of one module with entry points of one group, and returns its folder.

    Values of entry points name what the module has.
    """

    def installed(module, group, values, code="", place="installed"):
        folder = tmp_path / place
        information = folder / f"{module}-1.0.dist-info"
        information.mkdir(parents=True)
        (folder / f"{module}.py").write_text(code)
        (information / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
        lines = [f"{name} = {module}:{value}" for name, value in values.items()]
        (information / "entry_points.txt").write_text("\n".join([f"[{group}]", *lines, ""]))
        monkeypatch.syspath_prepend(folder)
        registry.entries.cache_clear()
        return folder

    yield installed
    registry.entries.cache_clear()


BUILT = {}  # the command line by the commands in it: typer takes half a second to read their annotations


def build(application, build=typer.main.get_command):
    """Return the command line of typer's application, built only where its commands are others than before."""
    commands = tuple((info.name, info.callback) for info in application.registered_commands)
    key = (application, commands, tuple(info.typer_instance for info in application.registered_groups))
    if key not in BUILT:
        BUILT[key] = build(application)
    return BUILT[key]


@pytest.fixture
def bench_here(monkeypatch, capsys):
    """Return a function that runs the command line in this process, which spares its start and the imports."""
    commands, groups = app.app.registered_commands, app.app.registered_groups
    monkeypatch.setattr("typer.main.get_command", build)

    def run(*arguments, cwd="."):
        monkeypatch.chdir(cwd)
        monkeypatch.setattr(sys, "argv", ["bench", *map(str, arguments)])
        monkeypatch.setattr(app.app, "registered_commands", [*commands])  # without those that plug-ins added before
        monkeypatch.setattr(app.app, "registered_groups", [*groups])
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            app.main()
        done = subprocess.CompletedProcess(sys.argv, ended.value.code or 0, *capsys.readouterr())
        assert "Traceback" not in done.stderr + done.stdout, done.stderr
        return done

    return run


SHADOWS = ("json", "numpy", "random", "typing", "bench")


@pytest.fixture
def shadows(tmp_path, monkeypatch):
    """The working folder, with files of the names of modules, each of which notes its import and fails."""
    monkeypatch.delitem(sys.modules, "stride", raising=False)  # of another test's folder
    monkeypatch.setattr(sys, "path", [*sys.path])  # to which the folder of the file is added
    for name in SHADOWS:
        imported = str(tmp_path / f"{name}.imported")
        (tmp_path / f"{name}.py").write_text(f"open({imported!r}, 'w').close()\nraise ImportError('a shadow')\n")
    (tmp_path / "stride.py").write_text("STEP = 0.1\n")
    (tmp_path / "beside.py").write_text("""if True:
        import json, random

        import numpy as np

        from bench import FunctionProblem
        from stride import STEP

        def stroll(objective, rng, step=STEP):
            x = objective.initial(1)
            while True:
                x = objective.repair(x + step * rng.standard_normal(x.shape))
                objective(x)

        ball = FunctionProblem(lambda x: (x * x).sum(axis=1), [-STEP, -STEP], [1.0, 1.0], name="ball")
    """)
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    for name in ("beside", "stride"):  # other tests have files of these names
        sys.modules.pop(name, None)


@pytest.fixture(scope="package")
def small_study(testing_plugins):
    """Two problems, three optimizers, three trials: fast, and every value is known to depend on its seed."""
    from bench import Study

    return Study.from_dict(
        {"name": "small", "trials": 3, "budget": 60, "seed": 5, "problems": [{"names": ["sphere-2", "sphere-3"]}],
         "optimizers": [{"name": "hill-climber"}, {"name": "scatter", "agents": 7}, {"name": "early"}]}
    )  # fmt: skip


SVG = b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><g id="a"/></svg>'
UNDRAWN = [
    (FigureCanvasSVG, "print_svg", lambda self, file, **_: file.write(SVG)),
    (FigureCanvasPdf, "print_pdf", lambda self, file, **_: file.write(b"%PDF-1.4")),
    (ConstrainedLayoutEngine, "execute", lambda self, figure: None),
]
DRAWN = [(owner, name, getattr(owner, name)) for owner, name, _ in UNDRAWN]


@contextmanager
def matplotlib_with(methods):
    with pytest.MonkeyPatch.context() as monkeypatch:
        for method in methods:
            monkeypatch.setattr(*method)
        yield


@pytest.fixture(scope="module", autouse=True)
def undrawn():
    """Have matplotlib write this picture for every figure, whose drawing takes half of the time of a report."""
    with matplotlib_with(UNDRAWN):
        yield


@pytest.fixture(scope="session")
def drawn():
    """Return a context in which figures are drawn."""
    return lambda: matplotlib_with(DRAWN)


@pytest.fixture
def draws(drawn):
    """Have the figures of a test drawn."""
    with drawn():
        yield


@pytest.fixture(params=["compiled", "interpreted", "numpy"])
def scanner(request):
    """Have objectives look at points by each of their loops: a small budget is not worth loading numba."""
    loops = {"compiled": objective.scanner(10**9, 1), "interpreted": objective._scan, "numpy": objective._scan_batch}
    LOOPS[:] = [loops[request.param]]
    yield
    LOOPS.clear()
