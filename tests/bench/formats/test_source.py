"""Archives stay within their folder and within limits, and a format is recognised or named as unknown."""

import bz2
import gzip
import io
import lzma
import tarfile
import zipfile

import pytest

from bench import BenchError, Results
from bench.formats import unpacking
from bench.formats.importing import import_results
from tests.bench.formats.tables.test_reader import TABLE


def packed(folder, name="runs.csv", **about):
    """Write a tar archive with one member."""
    file = folder / "runs.tar.gz"
    with tarfile.open(file, "w:gz") as archive:
        member = tarfile.TarInfo(name)
        member.size = len(TABLE)
        for key, value in about.items():
            setattr(member, key, value)
        archive.addfile(member, io.BytesIO(TABLE.encode()))
    return file


def test_tar_and_zip_archives_are_read(tmp_path):
    import_results(packed(tmp_path, "deep/runs.csv"), tmp_path / "one")
    with zipfile.ZipFile(tmp_path / "runs.zip", "w") as archive:
        archive.writestr("deep/runs.csv", TABLE)
    import_results(tmp_path / "runs.zip", tmp_path / "two")
    assert Results(tmp_path / "one").frame["fun"].tolist() == Results(tmp_path / "two").frame["fun"].tolist()


@pytest.mark.parametrize("name", ["../evil.csv", "/etc/evil.csv", "a/../../evil.csv", "..\\evil.csv", "C:\\evil.csv"])
def test_a_path_that_leaves_the_archive_is_refused(tmp_path, name):
    place = tmp_path / "deep" / "deeper"
    place.mkdir(parents=True)
    with pytest.raises(BenchError, match="a path that leaves the archive"):
        import_results(packed(place, name), place / "out")
    assert [each.name for each in place.iterdir()] == ["runs.tar.gz"]
    assert not list(tmp_path.rglob("evil.csv"))


@pytest.mark.parametrize("kind", [tarfile.SYMTYPE, tarfile.LNKTYPE, tarfile.FIFOTYPE])
def test_links_and_devices_are_refused(tmp_path, kind):
    with pytest.raises(BenchError, match="which is a link, a folder or a device"):
        import_results(packed(tmp_path, type=kind, linkname="/etc/passwd"), tmp_path / "out")


def test_the_number_of_files_is_limited(tmp_path, monkeypatch):
    monkeypatch.setattr(unpacking, "MOST_FILES", 0)
    for each in (packed(tmp_path), tmp_path):
        with pytest.raises(BenchError, match="import a part of it at a time"):
            import_results(each, tmp_path / "out")


@pytest.mark.parametrize("size", [3, 40, -20])
def test_an_archive_that_is_cut_short_is_refused(tmp_path, size):
    with zipfile.ZipFile(tmp_path / "runs.zip", "w") as archive:
        archive.writestr("runs.csv", TABLE)
    for file in (packed(tmp_path), tmp_path / "runs.zip"):
        file.write_bytes(file.read_bytes()[:size])
        with pytest.raises(BenchError, match=f"{file.name} is damaged or cut short"):
            import_results(file, tmp_path / "out")


def test_a_zip_archive_whose_compressed_bytes_are_damaged_is_refused(tmp_path):
    file = tmp_path / "runs.zip"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("runs.csv", TABLE * 50)
    content = bytearray(file.read_bytes())
    content[38:60] = b"\xff" * 22  # behind the member's header of 30 bytes and its name
    file.write_bytes(content)
    with pytest.raises(BenchError, match=r"runs\.zip is damaged or cut short"):
        import_results(file, tmp_path / "out")


def test_an_unknown_format_and_several_formats_are_refused(tmp_path):
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / "notes.txt").write_text("hello")
    with pytest.raises(BenchError, match="holds no results in a known format"):
        import_results(tmp_path / "x", tmp_path / "out")
    (tmp_path / "x" / "runs.csv").write_text(TABLE)
    (tmp_path / "x" / "f1.info").write_text("")
    with pytest.raises(BenchError, match="holds results of coco and of csv; import one of them at a time"):
        import_results(tmp_path / "x", tmp_path / "out")
    with pytest.raises(BenchError, match="is neither a folder nor a file"):
        import_results(tmp_path / "nothing", tmp_path / "out")


def test_a_folder_with_content_is_not_overwritten(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "precious").write_text("")
    with pytest.raises(BenchError, match="is there already and not empty"):
        import_results(packed(tmp_path), tmp_path / "out")


def member(kind):
    """Return the header of a tar archive's member, whose content has a million bytes."""
    about = tarfile.TarInfo("runs.csv")
    about.type, about.size = kind, 1_000_000
    return about.tobuf(tarfile.USTAR_FORMAT)


@pytest.mark.parametrize("suffix", ["xz", "gz", "bz2"])
@pytest.mark.parametrize(
    "kind", [tarfile.REGTYPE, tarfile.XHDTYPE, tarfile.GNUTYPE_LONGNAME, b"5"], ids=["file", "pax", "name", "folder"]
)
def test_a_tar_archive_that_grows_as_no_results_do_is_not_unpacked(tmp_path, monkeypatch, suffix, kind):
    monkeypatch.setattr(unpacking, "HARMLESS", 100_000)
    file = tmp_path / f"runs.tar.{suffix}"
    opened = {"xz": lzma.open, "gz": gzip.open, "bz2": bz2.open}[suffix]
    with opened(file, "wb") as content:
        content.write(member(kind) + bytes(1_000_000) + bytes(1024))
    with pytest.raises(BenchError, match=r"unpacks to more than 200 times its size, as no results do"):
        import_results(file, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_an_honest_archive_may_grow(tmp_path):
    file = tmp_path / "runs.tar.xz"
    with tarfile.open(file, "w:xz") as archive:
        about = tarfile.TarInfo("runs.csv")
        about.size = len(TABLE)
        archive.addfile(about, io.BytesIO(TABLE.encode()))
    import_results(file, tmp_path / "out")
    assert len(Results(tmp_path / "out").frame)


def test_a_disk_that_cannot_be_written_is_no_damage_of_the_archive(tmp_path):
    file = packed(tmp_path)
    with pytest.raises(FileExistsError):
        unpacking.extract(file, unpacking.members_of(file), file)
