"""bench data: the published recordings come whole, from a server, or not at all.

Three small files stand for the published ones; tests/problems/backlash/published has the real ones.
"""

import hashlib
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from urllib.parse import unquote

import pytest

from bench import BenchError
from problems.backlash.published import download as files

CONTENT = {
    "Speeddata3.xlsx": b"three" * 1000,
    "Speeddata4.xlsx": b"four" * 1000,
    "Noisy data/Low level of noise/Data_with_Noise_1.zip": b"zip" * 100_000,
}
NAMES = ["Speeddata3.xlsx", "Speeddata4.xlsx", "Data_with_Noise_1.zip"]
WHOLE = dict(zip(NAMES, CONTENT.values(), strict=True))
KNOWN = {
    name: files.PublishedFile(path, hashlib.sha256(CONTENT[path]).hexdigest())
    for name, path in zip(NAMES, CONTENT, strict=True)
}


class Handler(BaseHTTPRequestHandler):
    def do_GET(self):
        path = unquote(self.path).removeprefix("/at/")
        self.server.asked.append(path)
        if " " in self.path or path not in self.server.content:
            self.send_error(404)
            return
        self.send_response(200)
        self.send_header("Content-Length", str(len(CONTENT[path])))
        self.end_headers()
        self.wfile.write(self.server.content[path])

    def log_message(self, *arguments):
        pass


@pytest.fixture
def server(monkeypatch):
    """A server of the files; ``server.content`` is what it gives, ``server.asked`` what it was asked for."""
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as served:
        served.content, served.asked = dict(CONTENT), []
        served.address = f"http://127.0.0.1:{served.server_port}/at/"
        Thread(target=served.serve_forever, args=(0.01,), daemon=True).start()
        yield served
        served.shutdown()


def fetched(server, folder):
    """Return the names of the files that are downloaded into a folder, and the sentence of what goes wrong."""
    names = []
    try:
        files.download(KNOWN, folder, server.address, on_file=names.append)
    except BenchError as error:
        return names, str(error)
    return names, ""


def held(folder):
    """Every file below a folder, hidden and temporary ones too, by its name."""
    return {path.name: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_download_has_every_file_whole_and_a_second_one_asks_for_none(server, tmp_path):
    assert fetched(server, tmp_path) == (NAMES, "")
    assert held(tmp_path) == WHOLE
    assert server.asked == list(CONTENT)
    assert fetched(server, tmp_path) == ([], "")
    assert server.asked == list(CONTENT)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (b"four" * 999 + b"five", "Speeddata4.xlsx is not the published file, as its SHA-256 differs"),
        (b"four" * 10, "Speeddata4.xlsx cannot be downloaded from 127.0.0.1:"),
        (None, "the server answers 404; try again"),
    ],
    ids=["other bytes", "broken off", "gone"],
)
def test_a_download_that_fails_is_one_sentence_and_keeps_whole_files_alone(server, tmp_path, change, reason):
    server.content["Speeddata4.xlsx"] = change
    if change is None:
        del server.content["Speeddata4.xlsx"]
    names, said = fetched(server, tmp_path)
    assert names == NAMES[:1]
    assert reason in said
    assert held(tmp_path) == {"Speeddata3.xlsx": CONTENT["Speeddata3.xlsx"]}
    server.content = dict(CONTENT)
    assert fetched(server, tmp_path) == (NAMES[1:], "")
    assert held(tmp_path) == WHOLE


def test_without_a_connection_it_says_what_to_do(server, tmp_path):
    server.shutdown()
    server.server_close()
    assert (
        "the connection failed; try again, which goes on from here, or set BENCH_PUBLISHED_DATA to a"
        in fetched(server, tmp_path)[1]
    )
    assert held(tmp_path) == {}


def test_an_interrupted_download_leaves_nothing_half_written(server, monkeypatch, tmp_path):
    import pooch

    def stop(self, url, output_file, pooch, check_only=False):
        with open(output_file, "wb") as file:  # noqa: PTH123 - pooch's own signature
            file.write(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(pooch.HTTPDownloader, "__call__", stop)
    with pytest.raises(KeyboardInterrupt):
        files.download(KNOWN, tmp_path, server.address)
    assert held(tmp_path) == {}


def test_a_recording_is_read_only_where_it_is_there_and_whole(tmp_path, monkeypatch):
    (tmp_path / "Speeddata3.xlsx").write_bytes(b"torn")
    monkeypatch.setenv(files.VARIABLE, str(tmp_path))
    with pytest.raises(BenchError, match="is not the published recording, as its SHA-256 differs; get it anew"):
        files.require("Speeddata3.xlsx")
    with pytest.raises(BenchError, match=r"Speeddata4.xlsx is not in .*; get it with 'bench data fetch'"):
        files.require("Speeddata4.xlsx")
