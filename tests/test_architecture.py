"""ARCHITECTURE.md is true: its layers are those that lint enforces, and it describes every key and file of a folder."""

import json
import re
import sqlite3
import tomllib
from pathlib import Path

import pytest

from bench import Study, run, write_report
from bench.check.verdict import Verdict
from bench.execution.verify import verify
from bench.trial.columns import COLUMNS

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
PROSE = re.sub(r"```.*?```", "", PAGE, flags=re.DOTALL)
DOCUMENTED = set(re.findall(r"`([^`\n]+)`", PROSE))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A study's folder with a report and a verification, of which no file is missing but those of checks and code."""
    path = tmp_path_factory.mktemp("runs") / "tiny"
    study = {
        "name": "tiny", "trials": 2, "budget": 30,
        "problems": [{"name": "signature-03"}], "optimizers": [{"name": "random-search"}],
    }  # fmt: skip
    run(Study.from_dict(study), path, n_jobs=1)
    verify(path, trials=1, n_jobs=1)
    write_report(path)
    return path


def test_the_layers_are_those_that_lint_enforces():
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    layers = next(each for each in contracts if each["id"] == "bench")["layers"]
    enforced = [{*re.split(r"[ :|]+", floor)} - {"__main__"} for floor in layers]
    drawing = re.search(r"```\noptimizers \| problems.*?\n(─.*?)```", PAGE, re.DOTALL)[1]
    floors = re.split(r"^─.*\n", drawing, flags=re.MULTILINE)[1:]
    drawn = [
        [name for line in floor.splitlines() for name in re.split(r"\s{2,}", line)[0].split(", ")] for floor in floors
    ]
    assert [sorted(floor) for floor in drawn] == [sorted(floor) for floor in enforced]


def test_every_file_of_a_folder_is_described(folder):
    named = {re.sub(r".*/", "", each) for each in DOCUMENTED}
    for file in folder.rglob("*"):
        if file.is_file() and not file.name.startswith("trials.sqlite-"):
            assert {file.name, f"*{file.suffix}"} & named, file


def test_every_table_and_column_of_the_store_is_described(folder):
    store = sqlite3.connect(folder / "trials.sqlite")
    for (table,) in store.execute("SELECT name FROM sqlite_master WHERE type IN ('table', 'view')").fetchall():
        columns = {column[1] for column in store.execute(f"PRAGMA table_info({table})")}
        assert {table} | columns <= DOCUMENTED | {column.name for column in COLUMNS}
    store.close()


@pytest.mark.parametrize("file", ["environment.json", "verification.json"])
def test_every_key_of_a_note_is_described(folder, file):
    noted = json.loads((folder / file).read_text(encoding="utf-8"))
    assert set(noted[0] if isinstance(noted, list) else noted) <= DOCUMENTED


def test_every_key_of_a_study_and_of_a_check_is_described(folder):
    assert set(tomllib.loads((folder / "study.toml").read_text(encoding="utf-8"))) <= DOCUMENTED
    assert set(Verdict.__dataclass_fields__) <= DOCUMENTED
