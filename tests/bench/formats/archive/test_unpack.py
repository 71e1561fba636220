import hashlib
import stat
import zipfile
from importlib import import_module

import pandas as pd
import pytest

from bench import BenchError, load_results, run
from bench.formats.archive import pack, unpack

reading = import_module("bench.formats.archive.unpack")  # whose name in the package is the function's

SUMS = "SHA256SUMS"


def write(path, content, *, listed=False, kinds=None):
    """Write an archive; with ``listed``, its checksums agree with its content, as a forger's do."""
    if listed:
        digests = {name: hashlib.sha256(each).hexdigest() for name, each in content.items() if name != SUMS}
        content = content | {SUMS: "".join(f"{each}  {name}\n" for name, each in digests.items()).encode()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, each in content.items():
            entry = zipfile.ZipInfo(name)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (kinds or {}).get(name, stat.S_IFREG | 0o644) << 16
            archive.writestr(entry, each)
    return path


def assert_refused(path, match, **options):
    target = path.parent / "there"
    with pytest.raises(BenchError, match=match) as refused:
        unpack(path, target, **options)
    assert "\n" not in str(refused.value)
    assert [each.name for each in path.parent.iterdir()] == [path.name]


def test_what_was_packed_is_unpacked(packed, content, whole, tmp_path):
    found = unpack(packed, tmp_path / "there")
    files = {each.relative_to(found.path).as_posix(): each for each in found.path.rglob("*") if each.is_file()}
    assert {name: each.read_bytes() for name, each in files.items()} == content
    assert (found.files, found.trials) == (len(content), 120)
    assert found.sentence == "all 120 trials are as they were written"
    pd.testing.assert_frame_equal(load_results(found.path), load_results(whole.path), check_exact=True)


def test_an_unpacked_folder_is_packed_to_the_same_bytes(packed, tmp_path):
    unpack(packed, tmp_path / "there")
    again = pack(tmp_path / "there", tmp_path / "again.zip")
    assert again.path.read_bytes() == packed.read_bytes()


def test_an_empty_folder_is_filled_and_any_other_is_kept(packed, tmp_path):
    (tmp_path / "empty").mkdir()
    unpack(packed, tmp_path / "empty")
    with pytest.raises(BenchError, match=r"empty is there already; give a new folder"):
        unpack(packed, tmp_path / "empty")
    assert (tmp_path / "empty" / "study.toml").exists()


NAMES = [
    "../out.csv", "/tmp/out.csv", "tables/../../out.csv", "tables\\..\\out.csv", "C:out.csv", "tables//out.csv",
    "tables/a/out.csv", "code.py", ".lock", "tables/.hidden", "tables/\u202etxt.csv", "tables/a\nb.csv",
]  # fmt: skip
SUM_LINES = ["", "0" * 64, f"{'0' * 63}  study.toml", f"{'0' * 64} *study.toml", f"{'0' * 64}  study.toml"]


def changed(name, old=b"e", new=b"f"):
    return lambda content: content | {name: content[name].replace(old, new, 1)}


def added(name, content=b""):
    return lambda whole: whole | {name: content}


@pytest.mark.parametrize(
    ("change", "listed", "sentence"),
    [
        *(
            (changed(name), False, f"{name} was changed")
            for name in ("trials.sqlite", "study.toml", "tables/cells.csv")
        ),
        *(
            (
                lambda content, name=name: {n: c for n, c in content.items() if n != name},
                False,
                f"{name} is mis|no {name}",
            )
            for name in ("trials.sqlite", "study.toml", "tables/cells.csv", SUMS)
        ),
        *(
            (lambda content, line=line: content | {SUMS: content[SUMS] + line.encode() + b"\n"}, False, "is malformed")
            for line in SUM_LINES
        ),
        (added("tables/more.csv"), False, "tables/more.csv was added"),
        *((added(name), True, "which is no file of an archive") for name in NAMES),
        (added("tables/Cells.csv"), True, "'tables/Cells.csv' twice"),
        (added("tables/more.csv", bytes(300_000_000)), True, "times its size, as no results do"),
        (changed("trials.sqlite", b"RuntimeError", b"rUNTIMEError"), True, "1 of 120 trials are damaged"),
        (added("study.toml", b"name = 3"), True, "a.zip: "),
        (changed("study.toml", b'"scatter"', b'"hill-climber"'), True, "study.toml was changed: the trials beside it"),
    ],
)
def test_what_was_changed_added_or_removed_is_named_and_nothing_unpacked(change, listed, sentence, content, tmp_path):
    assert_refused(write(tmp_path / "a.zip", change(content), listed=listed), sentence)


def test_a_list_that_fills_the_memory_is_not_read(content, tmp_path, monkeypatch):
    monkeypatch.setattr(reading, "LARGEST_LIST", 10)
    assert_refused(write(tmp_path / "a.zip", content), "SHA256SUMS is too large to be a list of files")


@pytest.mark.parametrize("kind", [stat.S_IFLNK, stat.S_IFDIR, stat.S_IFIFO, stat.S_IFCHR])
def test_links_folders_and_devices_are_refused(content, tmp_path, kind):
    path = write(
        tmp_path / "a.zip", content | {"report.html": b"/etc/passwd"}, listed=True, kinds={"report.html": kind}
    )
    assert_refused(path, r"'report.html', which is a link, a folder or a device")


def test_the_size_is_limited(content, tmp_path):
    path = write(tmp_path / "a.zip", content, listed=True)
    assert_refused(path, r"or 1e-06 GB; --limit raises the size", limit_gb=1e-6)


def test_damaged_bytes_are_noticed_wherever_a_file_is_changed(packed, content, tmp_path):
    """One byte is changed at each of 60 places: the archive is refused, or all files are as they were."""
    whole = packed.read_bytes()
    for place in range(5, len(whole), len(whole) // 60):
        (tmp_path / "a.zip").write_bytes(whole[:place] + bytes([whole[place] ^ 0x55]) + whole[place + 1 :])
        try:
            found = unpack(tmp_path / "a.zip", tmp_path / f"{place}")
        except BenchError:
            assert not (tmp_path / f"{place}").exists()
        else:
            assert all((found.path / name).read_bytes() == each for name, each in content.items())


@pytest.mark.slow
def test_an_unpacked_folder_is_verified_and_reported(bench_here, tmp_path, small_study):
    run(small_study.override(trials=1), tmp_path / "out", n_jobs=1)
    pack(tmp_path / "out", tmp_path / "a.zip")
    unpack(tmp_path / "a.zip", tmp_path / "there")
    again = bench_here("verify", tmp_path / "there", "--trials", "1", "--jobs", "1")
    assert (again.returncode, "6 of 6 trials of 6 cells are the same bit by bit" in again.stdout) == (0, True)
    assert "study small" in bench_here("status", tmp_path / "there").stdout
    assert bench_here("report", tmp_path / "there", "--jobs", "1").returncode == 0
    assert (tmp_path / "there" / "report.html").exists()
    assert bench_here("pack", tmp_path / "there", "-o", tmp_path / "again.zip").returncode == 0  # with all its files
