"""JSON and TOML of any content: the value, or a ValueError that says in a few words what is wrong."""

from pathlib import Path

import pytest

from bench.helpers.parsing import DEEPEST, parse_toml, read_text

MANY = 50_000


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * MANY,
        "a = " + "[" * MANY + "]" * MANY,
        "a = " + "{a = " * MANY,
        ".".join("a" * MANY) + " = 1",
        "[" + " . ".join("a" * MANY) + "]",
        "a = {" + "'a'.\"b\"." * MANY + "c = 1}",
        "a = " + "[" * (DEEPEST + 1) + "]" * (DEEPEST + 1),
    ],
)
def test_toml_that_is_nested_too_deeply_is_refused(text):
    with pytest.raises(ValueError, match=f"^it is nested more than {DEEPEST} levels deep$"):
        parse_toml(text)


def test_files_are_read_without_a_mark_of_their_encoding(tmp_path):
    (tmp_path / "a").write_bytes("\ufeffä".encode())
    assert read_text(tmp_path / "a") == "ä"
    (tmp_path / "b").write_bytes(b"\xff")
    with pytest.raises(ValueError, match=r"^it is not UTF-8 text$"):
        read_text(tmp_path / "b")


def test_what_is_no_regular_file_is_refused_before_it_is_read(tmp_path):
    for path in (Path("/dev/zero"), tmp_path):
        with pytest.raises(OSError, match="it is no regular file"):
            read_text(path)
