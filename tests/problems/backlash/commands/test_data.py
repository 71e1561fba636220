"""bench data: the published recordings come whole, from a server, or not at all."""

import hashlib
import sys
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from urllib.parse import unquote

import pytest

from bench import BenchError
from bench.cli import app
from problems.backlash.published import download as files

CONTENT = {
    "Speeddata3.xlsx": b"three" * 1000,
    "Speeddata4.xlsx": b"four" * 1000,
    "Noisy data/Low level of noise/Data_with_Noise_1.zip": b"zip" * 100_000,
}
NAMES = ["Speeddata3.xlsx", "Speeddata4.xlsx", "Data_with_Noise_1.zip"]


@pytest.fixture(autouse=True)
def registry(monkeypatch, tmp_path):
    """Three small files stand for the published ones, and an empty folder for the user's."""
    known = [files.PublishedFile(path, hashlib.sha256(content).hexdigest()) for path, content in CONTENT.items()]
    monkeypatch.setattr(files, "registry", lambda: {file.name: file for file in known})
    monkeypatch.setenv(files.VARIABLE, str(tmp_path / "kept"))
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")


@pytest.fixture
def server(monkeypatch):
    """A server of the files; ``server.content`` is what it gives, ``server.asked`` what it was asked for."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            path = unquote(self.path).removeprefix("/at/")
            self.server.asked.append(path)
            if " " in self.path or path not in self.server.content:
                self.send_error(404)
                return
            content = self.server.content[path]
            self.send_response(200)
            self.send_header("Content-Length", str(len(CONTENT[path])))
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *arguments):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as served:
        served.content, served.asked = dict(CONTENT), []
        monkeypatch.setattr(files, "BASE_URL", f"http://127.0.0.1:{served.server_port}/at/")
        Thread(target=served.serve_forever, args=(0.01,), daemon=True).start()
        yield served
        served.shutdown()


@pytest.fixture
def bench(monkeypatch, capsys):
    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["bench", "data", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            app.main()
        said = capsys.readouterr()
        return ended.value.code or 0, said.out, " ".join(said.err.split())

    return run


def held(folder):
    """Every file below a folder, hidden and temporary ones too, by its name."""
    return {path.name: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


WHOLE = dict(zip(NAMES, CONTENT.values(), strict=True))


def test_a_download_has_every_file_whole_and_a_second_one_asks_for_none(server, bench, tmp_path):
    code, said, _ = bench("fetch")
    assert code == 0
    assert said.splitlines()[0].startswith("The recordings are the thesis authors' own: https://github.com/Eliana")
    assert "EUPL-1.2" in said.splitlines()[1]
    assert said.splitlines()[2:5] == NAMES
    assert "has 3 of the 3 published files." in said
    assert held(tmp_path / "kept") == WHOLE
    assert server.asked == list(CONTENT)
    assert bench("fetch")[0] == 0
    assert server.asked == list(CONTENT)


def test_a_damaged_file_is_downloaded_anew_and_no_other(server, bench, tmp_path):
    bench("fetch")
    (tmp_path / "kept" / "Speeddata4.xlsx").write_bytes(b"torn")
    server.asked.clear()
    assert bench("fetch")[0] == 0
    assert server.asked == ["Speeddata4.xlsx"]
    assert held(tmp_path / "kept") == WHOLE


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (b"four" * 999 + b"five", "Speeddata4.xlsx is not the published file, as its SHA-256 differs"),
        (b"four" * 10, "Speeddata4.xlsx cannot be downloaded from 127.0.0.1:"),
        (None, "the server answers 404; try again"),
    ],
    ids=["other bytes", "broken off", "gone"],
)
def test_a_download_that_fails_is_one_sentence_and_keeps_whole_files_alone(server, bench, tmp_path, change, reason):
    server.content["Speeddata4.xlsx"] = change
    if change is None:
        del server.content["Speeddata4.xlsx"]
    code, _, said = bench("fetch")
    assert code == 2
    assert reason in said
    assert held(tmp_path / "kept") == {"Speeddata3.xlsx": CONTENT["Speeddata3.xlsx"]}
    server.content = dict(CONTENT)
    server.asked.clear()
    assert bench("fetch")[0] == 0
    assert server.asked == list(CONTENT)[1:]
    assert held(tmp_path / "kept") == WHOLE


def test_the_address_in_a_sentence_can_be_followed(server, bench):
    server.content["Noisy data/Low level of noise/Data_with_Noise_1.zip"] = b"no" * 150_000
    assert "/Noisy%20data/Low%20level%20of%20noise/Data_with_Noise_1.zip is not the published file" in bench("fetch")[2]


def test_without_a_connection_it_says_what_to_do(server, bench, tmp_path):
    server.shutdown()
    server.server_close()
    code, _, said = bench("fetch")
    assert code == 2
    assert "the connection failed; try again, which goes on from here, or set BENCH_PUBLISHED_DATA to a" in said
    assert held(tmp_path / "kept") == {}


def test_an_interrupted_download_leaves_nothing_half_written(server, monkeypatch, tmp_path):
    import pooch

    def stop(self, url, output_file, pooch, check_only=False):
        with open(output_file, "wb") as file:  # noqa: PTH123 - pooch's own signature
            file.write(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(pooch.HTTPDownloader, "__call__", stop)
    with pytest.raises(KeyboardInterrupt):
        files.download(tmp_path / "kept", files.BASE_URL)
    assert held(tmp_path / "kept") == {}


@pytest.fixture
def clone(tmp_path):
    for path, content in CONTENT.items():
        (tmp_path / "clone" / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "clone" / path).write_bytes(content)
    return tmp_path / "clone"


def test_a_whole_file_deeper_down_is_found_behind_a_damaged_one(clone):
    wanted = files.registry()["Data_with_Noise_1.zip"]
    (clone / wanted.name).write_bytes(b"torn")
    assert files.look_up(wanted, clone) == (clone / wanted.path, True)
    (clone / wanted.path).unlink()
    assert files.look_up(wanted, clone) == (clone / wanted.name, False)
    (clone / wanted.name).unlink()
    assert files.look_up(wanted, clone) == (None, False)


def test_a_folder_that_is_not_the_one_looked_in_is_said_to_need_the_variable(server, bench, tmp_path):
    assert files.VARIABLE not in bench("fetch")[1]
    said = bench("fetch", "--to", tmp_path / "other")[1]
    assert f"Set {files.VARIABLE} to it" in said
    assert held(tmp_path / "other") == WHOLE


def test_a_folder_that_cannot_be_written_is_one_sentence(server, tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(BenchError, match=r"Speeddata3.xlsx cannot be written: Not a directory"):
        files.download(tmp_path / "file" / "below", files.BASE_URL)


def test_a_folder_without_permission_is_not_told_as_a_lost_connection(monkeypatch, tmp_path):
    def refuse(*arguments, **options):
        raise PermissionError("as pooch words it, without a strerror")

    monkeypatch.setattr("pooch.core.make_local_storage", refuse)
    with pytest.raises(BenchError, match=r"Speeddata3.xlsx cannot be written: permission denied"):
        files.download(tmp_path / "kept", files.BASE_URL)


def test_verify_lists_what_is_damaged_or_missing_and_ends_with_1(server, bench, clone, tmp_path):
    bench("fetch")
    assert bench("verify")[:2] == (0, f"3 of the 3 published files in {tmp_path / 'kept'} are whole.\n")
    (tmp_path / "kept" / "Speeddata3.xlsx").write_bytes(b"torn")
    (tmp_path / "kept" / "Speeddata4.xlsx").unlink()
    code, said, _ = bench("verify")
    assert code == 1
    assert said.splitlines()[:2] == ["damaged: Speeddata3.xlsx", "missing: Speeddata4.xlsx"]
    assert "1 of the 3 published files" in said
    assert bench("verify", clone)[0] == 0


def test_a_problem_whose_file_is_missing_or_damaged_says_how_to_get_it(server, bench, clone, tmp_path, monkeypatch):
    with pytest.raises(BenchError, match=r"Speeddata3.xlsx is not in .*kept; get it with 'bench data fetch'"):
        files.require("Speeddata3.xlsx")
    bench("fetch")
    assert files.require("Speeddata3.xlsx") == tmp_path / "kept" / "Speeddata3.xlsx"
    (tmp_path / "kept" / "Speeddata3.xlsx").write_bytes(b"torn")
    with pytest.raises(BenchError, match="is not the published recording, as its SHA-256 differs; get it anew"):
        files.require("Speeddata3.xlsx")
    monkeypatch.setenv(files.VARIABLE, str(clone))  # whose files lie deeper
    assert files.require("Data_with_Noise_1.zip").is_relative_to(clone)
