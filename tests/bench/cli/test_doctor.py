"""What ``bench doctor`` and ``bench --version`` print, and how doctor finds what is broken."""

import json
import os
import subprocess
import sys
from importlib.metadata import version

import pytest

import bench as package
from bench import Study, run
from bench.cli import doctor


@pytest.fixture
def states(bench_here, tmp_path):
    """Return a function that runs doctor and gives its exit code, and the findings by topic and name."""

    def found(*arguments):
        done = bench_here("doctor", "--json", *arguments, cwd=tmp_path)
        told = json.loads(done.stdout)
        assert told["sound"] == (done.returncode == 0)
        return done.returncode, {(each["topic"], each["name"]): each for each in told["findings"]}

    return found


@pytest.fixture
def without_the_broken_plugin(monkeypatch):
    known = doctor.registry.entries
    for_all = {group: {k: v for k, v in known(group).items() if k != "broken"} for group in doctor.GROUPS}
    monkeypatch.setattr(doctor.registry, "entries", for_all.get)


def test_the_version_is_that_of_the_package(bench_here):
    assert bench_here("--version").stdout.split() == ["backlash-bench", version("backlash-bench")]
    assert package.__version__ == version("backlash-bench")


def test_a_sound_installation_ends_with_zero(states, without_the_broken_plugin):
    code, found = states()
    assert code == 0
    assert found["packages", "numpy"]["found"] == version("numpy")
    assert found["extras", "xlsx"]["found"] == f"openpyxl {version('openpyxl')}"
    assert {"cores", "memory", "BLAS"} <= {name for topic, name in found if topic == "machine"}
    assert {each["state"] for each in found.values()} <= {"ok", "note"}


def test_a_plugin_that_does_not_load_is_broken_and_its_package_is_named(states):
    code, found = states()
    assert code == 1
    assert "testing_plugins_missing" in found["plug-ins", "broken"]["found"]
    assert found["plug-ins", "broken"]["remedy"] == "update or uninstall testing-plugins 1.0"


def test_the_mend_stands_under_the_table(bench_here, tmp_path):
    done = bench_here("doctor", cwd=tmp_path)
    assert done.returncode == 1
    assert "broken: plug-ins, broken: update or uninstall testing-plugins 1.0" in done.stdout
    assert done.stdout.splitlines()[-1] == "1 broken"


@pytest.mark.usefixtures("without_the_broken_plugin")
@pytest.mark.parametrize(
    ("present", "topic", "state", "remedy"),
    [
        ({"tomli-w": None}, ("packages", "tomli-w"), "broken", "pip install 'backlash-bench'"),
        ({"typer": "0.1"}, ("packages", "typer"), "broken", "pip install 'backlash-bench'"),
        ({"openpyxl": None}, ("extras", "xlsx"), "note", "pip install 'backlash-bench[xlsx]'"),
        ({"cmaes": None}, ("extras", "optuna"), "note", "pip install 'backlash-bench[optuna]'"),
        ({"minionpy": "2.0"}, ("extras", "minion"), "broken", "pip install 'backlash-bench[minion]'"),
    ],
)
def test_packages_that_are_missing_or_of_a_wrong_version(states, monkeypatch, present, topic, state, remedy):
    def told(name):
        if name in present and present[name] is None:
            raise doctor.PackageNotFoundError(name)
        return present.get(name) or version(name)

    monkeypatch.setattr(doctor, "version", told)
    code, found = states()
    assert (found[topic]["state"], found[topic]["remedy"]) == (state, remedy)
    assert code == (state == "broken")


@pytest.mark.usefixtures("without_the_broken_plugin")
def test_extras_that_are_not_installed_are_one_line_under_the_table(bench_here, states, monkeypatch, tmp_path):
    def found(name):
        if name in ("openpyxl", "pyarrow"):
            raise doctor.PackageNotFoundError(name)
        return version(name)

    monkeypatch.setattr(doctor, "version", found)
    missing = [name for (topic, name), each in states()[1].items() if topic == "extras" and each["state"] == "note"]
    assert {"parquet", "xlsx"} <= set(missing)
    printed = bench_here("doctor", cwd=tmp_path).stdout
    assert [line for line in printed.splitlines() if "pip install" in line] == [
        f"note: extras that are not installed: pip install 'backlash-bench[{','.join(missing)}]'"
    ]


@pytest.mark.usefixtures("without_the_broken_plugin")
def test_a_cache_that_cannot_be_written_is_broken(states, monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file" / "below"))
    code, found = states()
    assert code == 1
    assert found["caches", "compiled code"]["remedy"] == "set NUMBA_CACHE_DIR to a folder that can be written"


@pytest.mark.usefixtures("without_the_broken_plugin")
def test_the_store_of_a_folder_is_checked(states, tmp_path, bench_here):
    study = {
        "name": "tiny", "trials": 2, "budget": 20,
        "problems": [{"name": "sphere-2"}], "optimizers": [{"name": "scatter"}],
    }  # fmt: skip
    run(Study.from_dict(study), tmp_path / "out", jobs=1)
    code, found = states(tmp_path / "out")
    assert (code, found["store", str(tmp_path / "out")]["state"]) == (0, "ok")
    (tmp_path / "out" / "trials.sqlite").write_bytes(b"nothing of the kind")
    assert states(tmp_path / "out")[0] == 1
    code, found = states(tmp_path / "nowhere")
    assert code == 1
    assert "holds no study.toml" in found["store", str(tmp_path / "nowhere")]["remedy"]


def test_doctor_runs_where_a_foreign_module_stops_every_other_command(tmp_path):
    (tmp_path / "optimizers.py").write_text("")
    command = [sys.executable, "-m", "bench"]
    there = {"cwd": tmp_path, "env": os.environ | {"PYTHONPATH": str(tmp_path)}, "capture_output": True}
    done = subprocess.run([*command, "doctor"], **there, text=True)
    assert done.returncode == 1
    assert "broken: names, optimizers: the module 'optimizers' found at" in done.stdout
    assert "Traceback" not in done.stderr
    assert subprocess.run([*command, "--version"], **there).returncode == 0
