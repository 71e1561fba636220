"""The code blocks of the site's pages, of the README and of CONTRIBUTING do what the pages say."""

import importlib.util
import os
import sys
from pathlib import Path

import pytest

import bench

ROOT = Path(__file__).resolve().parents[2]
_spec = importlib.util.spec_from_file_location("blocks", ROOT / "docs" / "blocks.py")
blocks = importlib.util.module_from_spec(_spec)
sys.modules["blocks"] = blocks  # dataclasses look their module up
_spec.loader.exec_module(blocks)

PAGES = {str(page.relative_to(ROOT)): page for page in blocks.PAGES}
IN_THE_CLONE = "docs/explanation/thesis.md"  # it reads the committed results
RUNNABLE = [name for name, page in PAGES.items() if any(block.reason is None for block in blocks.blocks(page))]


@pytest.mark.slow
@pytest.mark.parametrize("name", RUNNABLE)
def test_the_blocks_of_a_page_run(name, tmp_path, monkeypatch):
    if "BENCH_SITE" in os.environ and blocks.has_run(PAGES[name]):
        pytest.skip("the build of the site has run this page as it is")
    monkeypatch.setenv("MPLBACKEND", "agg")
    blocks.run(PAGES[name], ROOT if name == IN_THE_CLONE else tmp_path)


@pytest.mark.skipif("BENCH_SITE" not in os.environ, reason="'nox -s docs' installs a copy and runs the pages with it")
def test_the_pages_run_with_an_installed_copy():
    assert not Path(bench.__file__).is_relative_to(ROOT / "bench")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("```console\nfalse\n```\n", "'false' ended with 1"),
        ("```console\ntrue # exits with 3\n```\n", "ended with 0"),
        ("```python\nx = 1\n```\n\n```python\nassert x == 2\n```\n", "AssertionError"),
        ("```python\nprint(1.5, 'a')\n```\n\n```output\n1.5 b\n```\n", "but this was printed"),
    ],
)
def test_a_block_that_does_something_else_is_named(text, message, tmp_path, monkeypatch):
    monkeypatch.setattr(blocks, "ROOT", tmp_path)
    (tmp_path / "page.md").write_text(text, encoding="utf-8")
    with pytest.raises(blocks.BlockError, match=message) as raised:
        blocks.run(tmp_path / "page.md", tmp_path)
    assert str(raised.value).startswith("page.md:")


def test_files_are_written_output_is_compared_and_reasons_are_heeded(tmp_path, monkeypatch):
    monkeypatch.setattr(blocks, "ROOT", tmp_path)
    (tmp_path / "code.py").write_text("y = 2\n", encoding="utf-8")
    (tmp_path / "page.md").write_text(
        "```{code-block} toml\n:caption: deep/a.toml\nx = 1\n```\n\n"
        "```{literalinclude} code.py\n:caption: copy.py\n```\n\n"
        "```{code-block} toml\nnot = 'written'\n```\n\n"
        "% not run: it would fail\n```console\nfalse\n```\n\n"
        "```console\ncat deep/a.toml copy.py\nexit 3  # exits with 3\n```\n\n"
        "```output\nx = …\ny = 2\n```\n",
        encoding="utf-8",
    )
    blocks.run(tmp_path / "page.md", tmp_path)
    assert sorted(path.name for path in tmp_path.rglob("*") if path.is_file()) == [
        "a.toml", "code.py", "copy.py", "page.md"
    ]  # fmt: skip


def test_a_page_has_run_as_long_as_its_blocks_and_the_code_are_the_same(tmp_path, monkeypatch):
    page, code = tmp_path / "how-to" / "page.md", tmp_path / "bench" / "execution" / "made.py"
    for part, place in (("ROOT", tmp_path), ("DOCS", tmp_path)):
        monkeypatch.setattr(blocks, part, place)
    for path, text in ((page, "```console\necho a\n```\n"), (code, "x = 1\n")):
        path.parent.mkdir(parents=True)
        path.write_text(text, encoding="utf-8")
    assert not blocks.has_run(page)
    blocks.run_anew(page)
    assert (blocks.folder_of(page) / ".printed.json").read_text() == '{"0": "a\\n"}'
    page.write_text("A sentence.\n\n```console\necho a\n```\n", encoding="utf-8")
    assert blocks.has_run(page)
    code.write_text("x = 2\n", encoding="utf-8")
    assert not blocks.has_run(page)
    code.write_text("x = 1\n", encoding="utf-8")
    page.write_text("```console\nfalse\n```\n", encoding="utf-8")
    assert not blocks.has_run(page)
