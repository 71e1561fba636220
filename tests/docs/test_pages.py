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
