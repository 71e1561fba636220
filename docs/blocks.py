"""Run the code blocks of a page, in order, in one folder.

| block | what happens |
|-|-|
| ``console`` | the shell runs each line; it must end with 0, or with N where the line ends with ``# exits with N`` |
| ``python`` | all blocks of a page run in one namespace |
| ``{code-block}`` or ``{literalinclude}`` with a ``:caption:`` | is written to the file of that name |
| ``output`` | equals what the block before it printed; ``…`` stands for what varies |
| others | are not run |

A line ``% not run: REASON`` above a block, or ``<!-- not run: REASON -->`` in a page for GitHub, leaves it out.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted(
    [
        *(page for part in ("tutorials", "how-to", "reference", "explanation") for page in (ROOT / "docs" / part).glob("*.md")),
        ROOT / "docs" / "index.md", ROOT / "README.md", ROOT / "CONTRIBUTING.md",
    ]
)  # fmt: skip
RUN = {"console", "python", "output", "{code-block}", "{literalinclude}"}
REASON = re.compile(r"^(?:% not run:|<!-- not run:)\s*(.*?)\s*(?:-->)?$")
EXIT = re.compile(r"\s+# exits with (\d+)$")


class BlockError(Exception):
    """A block that does not do what its page says; the message names page and line."""


@dataclass(frozen=True)
class Block:
    """A fenced block: its kind, text and first line, the file that it shows, and why it is not run (None: it is)."""

    kind: str
    text: str
    line: int
    file: str | None = None
    reason: str | None = None


def blocks(page: Path) -> list[Block]:
    """Return the blocks of a page that are run, or would be but for a reason that the page gives."""
    text = page.read_text(encoding="utf-8")
    lines, found = text.splitlines(), []
    for token in MarkdownIt().parse(text):
        kind, _, argument = token.info.strip().partition(" ")
        if token.type != "fence" or token.map is None or kind not in RUN:
            continue
        above = REASON.match(lines[token.map[0] - 1].strip()) if token.map[0] else None
        reason = None if above is None else above[1]
        content, file = token.content, None
        if kind.startswith("{"):
            options = dict(re.findall(r"^:([\w-]+): *(.*)\n", content, re.MULTILINE))
            file = options.get("caption")
            if file is None:
                continue
            content = re.sub(r"\A(:[\w-]+:.*\n)*\n*", "", content)
            if kind == "{literalinclude}":
                content = (page.parent / argument.strip()).resolve().read_text(encoding="utf-8")
        found.append(Block(kind, content, token.map[0] + 1, file, reason))
    return found


def run(page: Path, folder: Path) -> None:
    """Run a page's blocks in a folder; raises BlockError at the first one that fails."""
    namespace: dict[str, object] = {"__name__": "__main__"}
    printed = ""
    for block in blocks(page):
        where = f"{page.relative_to(ROOT)}:{block.line}"
        if block.reason is not None:
            printed = ""
        elif block.file is not None:
            (folder / block.file).parent.mkdir(parents=True, exist_ok=True)
            (folder / block.file).write_text(block.text, encoding="utf-8")
        elif block.kind == "console":
            printed = "".join(_shell(line, folder, where) for line in block.text.splitlines() if line.strip())
        elif block.kind == "python":
            printed = _python(block.text, namespace, folder, where)
        else:
            _compare(block.text, printed, where)


def _shell(line: str, folder: Path, where: str) -> str:
    """Run a line of shell; return what it printed on standard output."""
    programs = str(Path(sys.executable).parent)
    environment = {
        **os.environ, "PATH": programs + os.pathsep + os.environ["PATH"], "COLUMNS": "100", "MPLBACKEND": "agg",
        "BENCH_ARCHIVE": str(folder / "archive"), "BENCH_PUBLISHED_DATA": str(folder / "published"),
    }  # fmt: skip
    expected = EXIT.search(line)
    done = subprocess.run(
        ["bash", "-c", line], cwd=folder, env=environment, capture_output=True, text=True, encoding="utf-8", check=False
    )
    if done.returncode != (int(expected[1]) if expected else 0):
        raise BlockError(f"{where}: {line!r} ended with {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def _python(code: str, namespace: dict[str, object], folder: Path, where: str) -> str:
    """Run Python in a namespace; return what it printed."""
    out = io.StringIO()
    try:
        with contextlib.chdir(folder), contextlib.redirect_stdout(out):
            exec(compile(code, where, "exec"), namespace)
    except Exception as error:
        raise BlockError(f"{where}: {type(error).__name__}: {error}\n{out.getvalue()}") from error
    return out.getvalue()


def _compare(shown: str, printed: str, where: str) -> None:
    """Raise BlockError where the output that a page shows is not what was printed, but for spaces at line ends."""
    pattern = ".*?".join(re.escape(part) for part in _stripped(shown).split("…"))
    if not re.fullmatch(pattern, _stripped(printed), re.DOTALL):
        raise BlockError(f"{where}: the page shows\n{shown}\nbut this was printed:\n{printed}")


def _stripped(text: str) -> str:
    return "\n".join(line.rstrip() for line in text.strip().splitlines())
