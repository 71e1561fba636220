"""COCO's data archive, by a list and files of our own making: from a folder, and from a server on this machine."""

import hashlib
import io
import json
import tarfile
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from typer.testing import CliRunner

from bench import BenchError, Results
from bench.cli.app import app
from bench.formats.coco import published as archive
from tests.bench.formats.tables.test_reader import TABLE

SETS = ("2009/DIRECT_posik_noiseless.tgz", "2009/BIPOP-CMA-ES_hansen.tgz", "2012/BIPOP-CMA-ES_other.tgz")


@pytest.fixture(autouse=True)
def kept(tmp_path, monkeypatch):
    """The folder that keeps data sets; no test reaches the network."""
    monkeypatch.setenv(archive.VARIABLE, str(tmp_path / "kept"))
    monkeypatch.setattr(archive, "BASE_URL", "http://127.0.0.1:9/")
    return tmp_path / "kept"


@pytest.fixture
def published(tmp_path):
    """A folder as the archive's: a list of a suite's data sets, and the sets."""
    rows = []
    for number, path in enumerate(SETS):
        file = tmp_path / "published" / "bbob" / path
        file.parent.mkdir(parents=True, exist_ok=True)
        with tarfile.open(file, "w:gz") as packed:
            content = TABLE.replace("pso", f"pso-{number}").encode()
            member = tarfile.TarInfo("runs.csv")
            member.size = len(content)
            packed.addfile(member, io.BytesIO(content))
        rows.append((path, hashlib.sha256(file.read_bytes()).hexdigest(), 17))
    (tmp_path / "published" / "bbob" / archive.DEFINITION).write_text(repr([("_url_", "http://x"), *rows]))
    return tmp_path / "published"


@pytest.fixture
def served(published, monkeypatch):
    """The same folder behind a server."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *args):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(published)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    monkeypatch.setattr(archive, "BASE_URL", f"http://127.0.0.1:{server.server_port}/")
    yield published
    server.shutdown()
    server.server_close()


@pytest.mark.parametrize("name", ["DIRECT", "direct", "2009/DIRECT", "2009/DIRECT_posik_noiseless", SETS[0]])
def test_a_data_set_is_found_by_its_algorithm_year_or_path(published, name):
    assert archive.find(f"bbob/{name}", published).path == SETS[0]


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("bbob/BIPOP-CMA-ES", "stands for 2 data sets; give one of bbob/2009/BIPOP-CMA-ES_hansen, bbob/2012/BIPOP"),
        ("bbob/DIRCT", "did you mean 'bbob/DIRECT'"),
        ("cec/DIRECT", "the archive has no suite 'cec'"),
        ("bbob-biobj/MOEA", "bi-objective results are not supported"),
        ("DIRECT", "is no name of a published data set, such as 'bbob/BIPOP-CMA-ES'"),
    ],
)
def test_another_name_is_refused(published, name, sentence):
    with pytest.raises(BenchError, match=sentence):
        archive.find(name, published)


def test_a_file_of_any_name_with_the_right_hash_is_copied(published, kept):
    (published / "bbob" / SETS[0]).rename(published / "some-name.tgz")
    assert archive.fetch("bbob/DIRECT", published) == kept / "bbob" / SETS[0]
    assert archive.fetch("bbob/DIRECT") == kept / "bbob" / SETS[0]  # from here on without the source


def test_a_file_with_another_hash_is_refused(published, kept):
    (published / "bbob" / SETS[0]).write_bytes(b"other")
    with pytest.raises(BenchError, match="has no file with the SHA-256 of bbob/2009/DIRECT_posik_noiseless"):
        archive.fetch("bbob/DIRECT", published)
    assert not (kept / "bbob" / "2009").exists()


def test_a_data_set_is_downloaded_once_and_checked(served, kept):
    assert archive.fetch("bbob/DIRECT").is_file()
    (served / "bbob" / SETS[0]).unlink()
    assert archive.fetch("bbob/DIRECT").is_file()
    (served / "bbob" / SETS[1]).write_bytes(b"other")
    with pytest.raises(BenchError, match="has another SHA-256 than the archive's list"):
        archive.fetch("bbob/2009/BIPOP-CMA-ES")
    assert not (kept / "bbob" / SETS[1]).exists()


def test_without_a_network_the_sentence_names_the_way_out(kept):
    with pytest.raises(BenchError, match=r"cannot be downloaded: the connection failed; 'bench import --from FOLDER'"):
        archive.fetch("bbob/DIRECT")


@pytest.mark.parametrize("text", ["[", "print(1)", "[('../x.tgz', '" + "0" * 64 + "', 1)]", "[('a.tgz', 'no', 1)]"])
def test_a_list_that_is_none_is_refused(published, text):
    (published / "bbob" / archive.DEFINITION).write_text(text)
    with pytest.raises(BenchError, match="is no list of an archive"):
        archive.data_sets("bbob", published)


def test_an_imported_set_is_kept(published):
    folder = archive.imported("bbob/DIRECT", published)
    assert Results(folder).environments[0]["imported"] == "bbob/2009/DIRECT_posik_noiseless"
    before = (folder / "trials.sqlite").stat().st_mtime_ns
    assert archive.imported("bbob/DIRECT") == folder
    assert (folder / "trials.sqlite").stat().st_mtime_ns == before


STUDY = """
name = "mine"
trials = 2
budget = 40
problems = [{name = "classical-sphere-d2-i1"}]
optimizers = [{name = "random-search"}]
"""


@pytest.mark.slow
def test_a_run_is_compared_with_a_published_set(published, tmp_path, monkeypatch):
    """The run's own report stays without it; a second one has both."""
    file = published / "bbob" / SETS[0]
    with tarfile.open(file, "w:gz") as packed:
        head, *rows = TABLE.splitlines(keepends=True)
        content = "".join([head, *(row for row in rows if row.startswith("pso,p,"))])
        content = content.replace("pso,p,", "DIRECT,classical-sphere-d2-i1,").encode()
        member = tarfile.TarInfo("runs.csv")
        member.size = len(content)
        packed.addfile(member, io.BytesIO(content))
    (published / "bbob" / archive.DEFINITION).write_text(
        repr([(SETS[0], hashlib.sha256(file.read_bytes()).hexdigest(), 17)])
    )
    (tmp_path / "mine.toml").write_text(STUDY)
    monkeypatch.chdir(tmp_path)

    def call(*words):
        return CliRunner().invoke(app, [*words])

    done = call("run", "mine.toml", "--jobs", "1")
    assert done.exit_code == 0, done.output
    report = ("report", "results/runs/mine", "--against", "bbob/DIRECT")
    refused = call(*report)  # before it is fetched: there is no network
    assert "'bench import --from FOLDER' takes it from a folder" in str(refused.exception)
    assert call("import", "coco:bbob/DIRECT", "--from", str(published), "-o", "direct").exit_code == 0
    done = call(*report, "--jobs", "1")
    assert done.exit_code == 0, done.output
    (second,) = (Path(line.removeprefix("report: ")) for line in done.output.splitlines() if "report: " in line)
    assert "imported" not in Path("results/runs/mine/report.html").read_text()
    assert second.parent.parent == Path("results/comparisons")
    page = second.read_text()
    assert "The folders share 1 problem; only those are compared." in page
    assert "The results of DIRECT were made elsewhere and imported." in page


def test_a_data_set_is_imported_by_its_name_and_listed_as_kept(published, kept, tmp_path):
    given = ["import", "coco:bbob/direct", "-o", str(tmp_path / "out")]
    found = CliRunner().invoke(app, [*given, "--from", str(published)])
    assert found.exit_code == 0, found.output
    assert Results(tmp_path / "out").environments[0]["imported"] == "bbob/2009/DIRECT_posik_noiseless"
    listed = CliRunner().invoke(app, ["list", "archives"]).output.splitlines()
    assert listed[0].rstrip() == "archives of bbob"
    assert listed[2].split() == ["coco:bbob/2009/DIRECT_posik_noiseless", "0.0", "MB,", "kept"]
    assert len([line for line in listed if "coco:" in line]) == 3
    records = json.loads(CliRunner().invoke(app, ["list", "archives", "bbob", "--json"]).output)
    assert [record["megabytes"] for record in records] == [0.017] * 3


def test_a_folder_without_a_list_is_one_sentence(tmp_path):
    given = ["import", "coco:bbob/DIRECT", "-o", str(tmp_path / "out"), "--from", str(tmp_path / "none")]
    assert "has no list" in str(CliRunner().invoke(app, given).exception)
