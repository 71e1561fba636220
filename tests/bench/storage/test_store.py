"""The store: what is committed stays, whoever reads; what is damaged is one sentence."""

import math
import sqlite3
import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest

from bench import BenchError, Study, load_results
from bench.contract.objective import Trace
from bench.storage.folder import Folder
from bench.storage.rows import COLUMNS, disagreement
from bench.storage.schema import schema
from bench.storage.store import Store
from bench.study.cell import Cell, record
from bench.trial.columns import named, packed
from bench.trial.trial import Trial
from tests.bench.storage.changes import forge

TRACE = Trace(np.array([1, 5, 40]), np.array([3.5, 0.1, -0.0]))


def trial(number, problem="sphere-2", optimizer="scatter"):
    return Trial(problem, optimizer, number, seed=1000 + number)


def finished(fun=0.1, **changes):
    return {"status": "ok", "fun": fun, "nfev": 40, "wall_s": 0.5, "cpu_s": 0.4, "objective_s": 0.2, "stop": "budget",
            "outside_box": 0, "x": {"x1": fun}, "metrics": {"radius": 1 / 3}, "trace": TRACE} | changes  # fmt: skip


LOST = {"status": "failed", "error": "RuntimeError: no"}


@pytest.fixture
def store(tmp_path):
    folder = Folder(tmp_path)
    entries = {"problems": ["sphere-2", "sphere-3"], "optimizers": ["scatter", "early"]}
    folder.claim(Study.from_dict({"name": "small"} | entries))
    return folder.store


def fill(store, *numbers, row=None):
    with store.writer() as writer:
        for number in numbers:
            writer.add(trial(number), packed(row or finished()))


def outside(path, query):
    """Ask as another program does, without this package."""
    with closing(sqlite3.connect(path)) as connection:
        return connection.execute(query).fetchall()


def test_every_digit_of_a_row_comes_back(store):
    values = [0.1 + 0.2, 5e-324, 1.7976931348623157e308, math.inf]
    with store.writer() as writer:
        for number, value in enumerate(values):
            writer.add(trial(number), packed(finished(value)))
    rows = list(store.rows())
    assert [row["fun"].hex() for row in rows] == [value.hex() for value in values]
    assert [named(row, "x")["x1"].hex() for row in rows] == [value.hex() for value in values]
    trace = store.traces()["sphere-2", "scatter", 0]
    assert trace.evaluations.tolist() == [1, 5, 40]
    assert [value.hex() for value in trace.values] == [value.hex() for value in TRACE.values]
    assert store.find("sphere-2", "scatter", 3) == (
        dict.fromkeys(COLUMNS) | packed(finished(values[3])) | trial(3).columns
    )


def test_rows_by_a_condition_and_in_the_order_of_cells(store):
    with store.writer() as writer:
        for number in (3, 1):
            for optimizer in ("scatter", "early"):
                writer.add(trial(number, optimizer=optimizer), packed(finished(float(number))))
        writer.add(trial(2), LOST)
    assert [(row["optimizer"], row["trial"]) for row in store.rows()] == [
        ("scatter", 1), ("scatter", 2), ("scatter", 3), ("early", 1), ("early", 3)
    ]  # fmt: skip
    assert [row["trial"] for row in store.rows("fun > 1 AND optimizer = 'early'")] == [3]
    assert [row["error"] for row in store.rows("status != 'ok'")] == [LOST["error"]]
    assert next(store.rows(columns=("trial", "fun"))) == {"trial": 1, "fun": 1.0}
    assert store.find("sphere-2", "scatter", 9) is None


def test_cells_count_by_status_and_keys_distinguish_finished_from_lost(store):
    fill(store, 0, 1)
    fill(store, 2, row=LOST)
    fill(store, 3, row=LOST | {"status": "timeout"})
    (cell,) = store.cells()
    assert (cell.done, cell.failed, cell.status) == (2, 2, {"ok": 2, "failed": 1, "timeout": 1})
    assert cell.wall_s == 1.0
    stored_keys, finished_keys = store.keys(), store.keys(finished_only=True)
    assert ("sphere-2", "scatter", 2) in stored_keys
    assert ("sphere-2", "scatter", 2) not in finished_keys


def test_a_lost_trial_is_replaced_and_a_finished_one_never(store):
    fill(store, 0, row=LOST)
    fill(store, 0, row=finished(0.5))
    with pytest.raises(BenchError, match="another run writes to the store"), store.writer() as writer:
        writer.add(trial(0), packed(finished(0.7)))
    assert [row["fun"] for row in store.rows()] == [0.5]


def test_what_is_put_at_once_is_committed_whole_or_not_at_all(store):
    fill(store, 0)
    with store.writer() as writer:
        with pytest.raises(BenchError), writer.transaction():  # noqa: PT012 - all of it is what is undone
            writer.put(packed(finished()) | trial(1).columns)
            writer.put(packed(finished()) | trial(0, problem="sphere-3").columns)
            raise BenchError("as merge does where trials differ")
        assert writer.find(1, 1) is None
        writer.add(trial(7, problem="sphere-3"), packed(finished()))
    assert [(row["problem"], row["trial"]) for row in store.rows()] == [("sphere-2", 0), ("sphere-3", 7)]


def test_a_row_that_is_refused_leaves_the_writer_usable(store):
    fill(store, 0)
    with store.writer() as writer:
        with pytest.raises(sqlite3.Error):
            writer.add(trial(1, problem="sphere-3"), LOST | {"seed": 1, "status": None})
        writer.add(trial(1, problem="sphere-3"), packed(finished()))
    assert len(list(store.rows())) == 2


def test_the_same_environment_has_one_number(store):
    with store.writer() as writer:
        one, two = writer.record("environments", {"host": "a"}), writer.record("environments", {"host": "b"})
        assert one != two
        assert writer.record("environments", {"host": "a"}) == one
        writer.change(two, {"host": "c"})
        writer.add(trial(0), packed(finished()), two)
        writer.add(trial(1), packed(finished()))
    assert store.records("environments") == {one: {"host": "a"}, two: {"host": "c"}}
    assert store.made() == {two: 1}


def test_removed_rows_are_gone_with_their_traces_and_can_be_made_again(store):
    with store.writer() as writer:
        for number in range(2):
            for optimizer in ("scatter", "early"):
                writer.add(trial(number, optimizer=optimizer), packed(finished()))
        writer.add(trial(2), LOST)
        assert writer.remove([1, 2], failed_only=True) == 1
        assert writer.remove([1, 3]) == 2
    assert {row["optimizer"] for row in store.rows()} == {"early"}
    assert {key[1] for key in store.traces()} == {"early"}
    fill(store, 0)
    assert store.find("sphere-2", "scatter", 0)["trace"] is not None


def test_texts_of_any_kind_are_data(store):
    label = "'; DROP TABLE results; --\u2028ä\U0001f600"
    row = finished(metrics={'"]}': 1.0, "NaN": math.nan}, error="\x00\x1b[31m'\"")
    with store.writer() as writer:
        cell = Cell(record(label=label, name="p"), record(label=label, name="o"), 40, 0)
        writer.select(label, {(label, label): cell})
        writer.add(trial(0, problem=label, optimizer=label), packed(row))
    assert store.find(label, label, 0)["error"] == row["error"]
    (read,) = store.rows()
    assert read["problem"] == label
    assert math.isnan(named(read, "metrics")["NaN"])
    with store.reader() as reader:
        assert list(named(next(reader.sound())[1], "metrics")) == ['"]}', "NaN"]


def test_outside_readers_have_all_of_a_trial_in_one_view(store):
    fill(store, 0, 1)
    fill(store, 2, row=LOST)
    rows = outside(
        store.path, "SELECT problem, optimizer, trial, seed, status, fun, length(trace) FROM trials ORDER BY trial"
    )
    assert rows == [
        ("sphere-2", "scatter", 0, 1000, "ok", 0.1, 48),
        ("sphere-2", "scatter", 1, 1001, "ok", 0.1, 48),
        ("sphere-2", "scatter", 2, 1002, "failed", None, None),
    ]


WRITE = """
import sys
from pathlib import Path
from bench.storage.store import Store
from bench.trial.trial import Trial

with Store(Path(sys.argv[1])).writer() as writer:
    for number in range(int(sys.argv[2])):
        writer.add(Trial("sphere-2", "scatter", number, number), {"status": "ok", "fun": float(number)})
        if number % 20 == 0:
            print(number, flush=True)
"""


def test_what_another_process_commits_is_read_while_it_goes_on(store):
    command = [sys.executable, "-c", WRITE, store.path.parent, "400"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as writer:
        for line in writer.stdout:
            read = [row["trial"] for row in store.rows()]
            assert read[: int(line) + 1] == list(range(int(line) + 1))
            assert read == list(range(len(read)))
    assert writer.returncode == 0
    assert len(list(store.rows())) == 400


def test_a_missing_or_unmade_store_is_empty_and_reading_makes_none(tmp_path):
    store = Store(tmp_path)
    for _ in range(2):
        assert store.cells() == []
        assert store.records("environments") == store.made() == store.traces() == {}
        keys = store.keys()
        assert ("p", "o", 0) not in keys
        assert store.find("p", "o", 0) is None
        assert list(store.rows()) == []
        if not store.path.exists():
            assert not list(tmp_path.iterdir())
        store.path.touch()


def test_a_schema_that_changes_has_another_version():
    """Nothing else distinguishes an old store from a new one."""
    assert "PRAGMA user_version = 7\n" in schema()


def test_trials_that_were_made_twice_are_compared_without_their_times():
    one = packed(finished()) | trial(0).columns
    assert disagreement(one, one | {"wall_s": 9.0, "environment": 4}) == ""
    assert disagreement(one, one | {"fun": math.nextafter(0.1, 1)}) == "fun"
    assert disagreement(one, one | {"trace": b""}) == "trace"
    assert disagreement(one | {"calls": 3}, one | {"calls": 4}) == "calls"


def _garbage(path):
    path.write_bytes(b"not a database at all" * 500)


def _truncated(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def _holed(path):
    content = bytearray(path.read_bytes())
    content[4096:] = bytes(len(content) - 4096)
    path.write_bytes(content)


def _older(path):
    """Of the layout before this one, as far as it is looked at."""
    path.unlink()
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript("CREATE TABLE environments (record TEXT NOT NULL); PRAGMA user_version = 2")


def _foreign(path):
    path.unlink()
    outside(path, "CREATE TABLE trials (problem TEXT, optimizer TEXT, trial INTEGER, fun REAL)")


def _newer(path):
    outside(path, "PRAGMA user_version = 99")


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (_garbage, "cannot be used: file is not a database"),
        (_truncated, "cannot be used: database disk image is malformed"),
        (_holed, "cannot be used: database disk image is malformed"),
        (_older, "was written in layout 2, and this version reads layout 7; export it with the version"),
        (_foreign, "was written in layout 0"),
        (_newer, "was written in layout 99"),
    ],
)
def test_a_damaged_store_is_one_sentence_for_every_command(bench_here, damage, said, study_of_store, tmp_path):
    study, folder = study_of_store
    damage(folder.store.path)
    before = folder.store.path.read_bytes()
    for command in (
        ["status", folder.path],
        ["status", folder.path, "--check"],
        ["report", folder.path],
        ["export", folder.path, "--format", "csv"],
        ["merge", folder.path, "--output", tmp_path / "merged"],
        ["run", study, "--output", folder.path, "--jobs", "1"],
    ):
        done = bench_here(*command)
        assert done.returncode == 2, (command, done.stdout)
        assert done.stderr.startswith("bench: the store ")
        assert said in done.stderr
        assert done.stderr.count("\n") == 1
    assert folder.store.path.read_bytes() == before


@pytest.mark.parametrize("column", ["x", "metrics"])
@pytest.mark.parametrize("value", ["NULL", "x'0102'", "x'00000000000000000000000000000000'"])
def test_numbers_that_fit_their_digests_and_not_their_names_are_named(column, value, study_of_store):
    _, folder = study_of_store
    forge(folder.store.path, f"UPDATE results SET {column} = {value} WHERE trial = 3")
    with pytest.raises(BenchError, match=f"is damaged: '{column}' of a trial of scatter on sphere-2 cannot be read"):
        load_results(folder.path)


@pytest.mark.parametrize("trace", ["x'0102030405'", "7"])
def test_a_trace_that_fits_its_digest_and_is_none_is_named(trace, study_of_store):
    _, folder = study_of_store
    forge(folder.store.path, f"UPDATE results SET trace = {trace}")
    with pytest.raises(BenchError, match="is damaged: a trace cannot be read"):
        folder.store.traces()


@pytest.fixture
def study_of_store(tmp_path):
    """A study's file and folder with many rows, filled by hand."""
    folder = Folder(tmp_path / "out")
    text = """
        name = "tiny"
        trials = 300
        budget = 40
        problems = [{ name = "sphere-2" }]
        optimizers = [{ name = "scatter" }]
    """
    study = tmp_path / "tiny.toml"
    study.write_text(text)
    folder.path.mkdir()
    folder.claim(Study.load(study))
    with folder.store.writer() as writer:
        number = writer.record("environments", {"host": "here", "started": "2026-01-01T00:00:00+00:00"})
        for each in range(100):
            writer.add(trial(each), packed(finished()), number)
    return study, folder


ENDLESS = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT"
"""A query without an end."""
ROW = "i AS cell, i AS trial, x'' AS digest, NULL AS names, NULL AS environment, 'ok' AS status"


@pytest.mark.parametrize(
    "statements",
    [
        ["ALTER TABLE results RENAME TO r", f"CREATE VIEW results AS {ENDLESS} {ROW} FROM n"],
        ["DROP TABLE cells", f"CREATE VIEW cells AS {ENDLESS} i AS id, 'p' AS problem, 'o' AS optimizer FROM n"],
        ["CREATE TRIGGER t AFTER UPDATE ON committed BEGIN DELETE FROM results; END"],
        ["ALTER TABLE environments ADD COLUMN more AS (hex(zeroblob(1000000)))"],
        ["CREATE INDEX i ON results (hex(fun))"],
    ],
    ids=["endless rows", "endless labels", "trigger", "generated column", "index"],
)
def test_a_store_with_what_a_stranger_computes_in_it_is_not_read(statements, store):
    fill(store, 0)
    for statement in statements:
        outside(store.path, statement)
    for use in (store.check, store.cells, lambda: store.records("environments"), lambda: fill(store, 1)):
        with pytest.raises(BenchError, match="in another form than 'bench run' writes it, so nothing of it is read"):
            use()
