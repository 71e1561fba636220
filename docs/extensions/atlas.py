"""Make the committed atlases of results/atlas and results/suites pages of this site."""

from __future__ import annotations

from pathlib import Path

from sphinx.application import Sphinx

from extensions.pages import write


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages when the build begins."""
    app.connect("builder-inited", lambda app: _write(Path(app.srcdir)))
    return {"parallel_read_safe": True}


def _write(source: Path) -> None:
    atlas, folder = source.parent / "results" / "atlas", source / "explanation" / "atlas"
    names = sorted(each.stem for each in atlas.glob("*.md") if each.stem != "README")
    pages = {name: (atlas / f"{name}.md").read_text(encoding="utf-8") for name in names}
    contents = "\n".join(name for name in names if name != "index")
    pages["index"] += f"\n```{{toctree}}\n:hidden:\n\n{contents}\n```\n"
    write(folder, pages)
    suites = (source.parent / "results" / "suites").glob("*.md")
    texts = {each.stem: each.read_text(encoding="utf-8") for each in suites if each.stem != "README"}
    write(source / "explanation" / "suites", texts)
