"""What is noted of a run: the machine, the versions and the code as they were, and what differs from one to another."""

import json
import os
import shlex
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from bench.storage import provenance
from bench.storage.provenance import differences, machine, run

RECORD = {
    "packages": {"numpy": "2.4.6", "scipy": "1.17.1"},
    "python": "3.11.7",
    "system": "Linux-6.1.0-x86_64-with-glibc2.36",
    "host": "one",
    "processor": "Xeon",
    "cores": 2,
    "memory_gb": 8.0,
    "blas": [{"library": "openblas", "version": "0.3.30", "threads": 1}],
    "harness": "backlash-bench 0.1.0 (code 12ab34cd)",
    "git": {"commit": "6b3d6c0" + "0" * 33, "dirty": False},
}


class TestMachine:
    def test_it_is_the_same_every_time_and_json_holds_it(self):
        first, second = machine(), machine()
        assert first == second == json.loads(json.dumps(first))
        assert first.keys() == RECORD.keys()
        assert first["packages"]["numpy"] == version("numpy")
        assert first["cores"] >= 1
        assert 0 < first["memory_gb"] < 1e5
        assert all(each.keys() == {"library", "version", "threads"} for each in first["blas"])
        assert first["blas"] or sys.platform != "linux"  # numpy brings one there

    def test_the_memory_is_what_a_container_may_use(self, tmp_path, monkeypatch):
        whole = provenance.memory()
        for text, expected in (("1000000", 1_000_000), ("max", whole), (str(2**63), whole)):
            (tmp_path / "limit").write_text(f"{text}\n")
            monkeypatch.setattr(provenance, "CONTAINER_LIMITS", (tmp_path / "limit", tmp_path / "missing"))
            assert provenance.memory() == expected


@pytest.fixture
def git(tmp_path, monkeypatch):
    """Return a function that runs git in a checkout."""
    for name in [name for name in os.environ if name.startswith("GIT_")]:
        monkeypatch.delenv(name)
    (tmp_path / "notes.txt").write_text("old")

    def ask(*arguments):
        command = ["git", "-c", "user.name=n", "-c", "user.email=e@x", *arguments]
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)

    ask("init")
    ask("add", ".")
    ask("commit", "-m", "first")
    return ask


class TestOwnState:
    own_state = staticmethod(provenance.own_state.__wrapped__)

    def test_it_is_the_commit_and_whether_files_were_changed(self, git, tmp_path):
        clean = self.own_state(tmp_path / "own.py")
        assert clean == {"commit": clean["commit"], "dirty": False}
        assert len(clean["commit"]) == 40
        (tmp_path / "run.log").write_text("a run may write beside the code that it runs")
        assert self.own_state(tmp_path / "own.py") == clean
        (tmp_path / "notes.txt").write_text("new")
        assert self.own_state(tmp_path / "own.py") == clean | {"dirty": True}

    def test_the_variables_of_a_git_hook_do_not_mislead(self, git, monkeypatch, tmp_path):
        before = self.own_state(tmp_path / "own.py")
        monkeypatch.setenv("GIT_DIR", str(tmp_path / "nowhere"))
        monkeypatch.setenv("GIT_INDEX_FILE", str(tmp_path / "nowhere"))
        assert self.own_state(tmp_path / "own.py") == before

    def test_without_git_or_a_commit_nothing_is_recorded(self, git, monkeypatch, tmp_path):
        git("update-ref", "-d", "HEAD")
        assert self.own_state(tmp_path / "own.py") is None
        monkeypatch.setenv("PATH", str(tmp_path))
        assert self.own_state(tmp_path / "own.py") is None

    def test_an_installed_package_is_no_part_of_the_checkout_around_it(self, git, tmp_path):
        (tmp_path / "site-packages").mkdir()
        assert self.own_state(tmp_path / "site-packages" / "own.py") is None


class TestRun:
    def test_it_records_the_study_and_the_command(self, small_study, monkeypatch):
        monkeypatch.setattr(sys, "argv", ["/usr/bin/bench", "run", "my study.toml", "\udcff"])
        record = run(small_study, 4, "local", timeout=9.5, shard="1/2")
        assert shlex.split(record["command"]) == ["bench", "run", "my study.toml", "\N{REPLACEMENT CHARACTER}"]
        assert record["started"].endswith("+00:00")
        assert record["ended"] is None
        assert record["working_folder"] == str(Path.cwd())
        others = {"started", "ended", "command", "working_folder"}
        assert {key: value for key, value in record.items() if key not in others} == {
            "jobs": 4, "backend": "local", "study": small_study.identity(),
            "timeout": 9.5, "shard": "1/2", "sandbox": None, "trials": 3,
            "subject": "",
        }  # fmt: skip

    def test_a_module_s_command_can_be_typed_again(self, small_study, monkeypatch):
        monkeypatch.setattr(sys, "argv", ["/somewhere/bench/__main__.py", "run", "thesis"])
        assert run(small_study, 1, "local")["command"] == "python -m bench run thesis"

    def test_it_has_no_name_in_common_with_a_machine(self, small_study):
        assert not machine().keys() & run(small_study, 1, "local").keys()


class TestDifferences:
    @pytest.mark.parametrize(
        ("change", "phrases"),
        [
            ({}, []),
            ({"packages": {"numpy": "2.5.0", "scipy": "1.17.1"}}, ["numpy 2.4.6 → 2.5.0"]),
            ({"packages": {"numpy": "2.4.6", "mealpy": "3.0.2"}}, []),
            ({"python": "3.13.0", "processor": "EPYC"}, ["Python 3.11.7 → 3.13.0", "processor Xeon → EPYC"]),
            ({"system": "Linux-7.0-rc1-x86_64-with-glibc2.36", "host": "two", "cores": 64, "memory_gb": 1.0}, []),
            ({"system": "Linux-6.1.0-x86_64-with-glibc2.39"}, ["system Linux glibc2.36 → Linux glibc2.39"]),
            ({"system": "macOS-14.5-arm64"}, ["system Linux glibc2.36 → macOS-14.5-arm64"]),
            ({"blas": [{"library": "mkl", "version": "2025"}]}, ["BLAS openblas 0.3.30 → mkl 2025"]),
            ({"blas": [*RECORD["blas"], {"library": "openblas", "version": "0.3.31", "threads": 1}]}, []),
            ({"git": {"commit": "1a2b3c4d", "dirty": True}}, []),  # of which the code may be the same
            (
                {"harness": "backlash-bench 0.1.0 (code ffffffff)"},
                ["backlash-bench 0.1.0 (code 12ab34cd) → 0.1.0 (code ffffffff)"],
            ),
        ],
    )
    def test_they_are_short_phrases(self, change, phrases):
        assert differences(RECORD, RECORD | change) == phrases

    def test_what_a_record_of_an_older_version_lacks_is_not_compared(self):
        old = {key: RECORD[key] for key in ("packages", "python", "system", "processor", "cores")}
        old["git"] = {"commit": RECORD["git"]["commit"], "dirty": False}
        old["packages"] = old["packages"] | {"seaborn": "0.13.2", "gone": None}
        assert differences(old, RECORD) == differences(RECORD, old) == []
        assert differences({}, RECORD) == differences(RECORD, {}) == []
