"""Run the code blocks of a page, in order, in one folder.

| block | what happens |
|-|-|
| ``console`` | each line is a command; it must end with 0, or with N where the line ends with ``# exits with N`` |
| ``python`` | all blocks of a page run in one namespace |
| ``{code-block}`` or ``{literalinclude}`` with a ``:caption:`` | is written to the file of that name |
| ``output`` | equals what the block before it printed; ``…`` stands for what varies |
| ``toml`` | is well-formed |
| ``r``, ``julia``, ``bash`` | cannot be run here, and need a reason |
| others | are not run |

A line ``% not run: REASON`` above a block, or ``<!-- not run: REASON -->`` in a page for GitHub, leaves it out. There,
``<!-- file: NAME -->`` stands for a caption.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PARTS = ("", "tutorials", "how-to", "reference", "reference/api", "explanation")
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
PAGES += sorted(page for part in PARTS for page in (DOCS / part).glob("*.md"))
RUN = {"console", "python", "output", "toml", "r", "julia", "bash", "{code-block}", "{literalinclude}"}
REASON = re.compile(r"^(?:% not run:|<!-- not run:)\s*(.*?)\s*(?:-->)?$")
FILE = re.compile(r"^<!-- file: (.*) -->$")
BLOCKS = "blocks"
IN_PROCESSES = ("bench/execution", "bench/sandbox", "optimizers", "problems")  # what trials may import
EXIT = re.compile(r"\s+# exits with (\d+)$")


class BlockError(Exception):
    """A block that does not do what its page says; the message names page and line."""


@dataclass(frozen=True)
class Block:
    """A fenced block: its kind, text, first and last line, the file that it shows, why it is not run (None: it is)."""

    kind: str
    text: str
    line: int
    last: int
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
        above = lines[token.map[0] - 1].strip() if token.map[0] else ""
        reason, named = REASON.match(above), FILE.match(above)
        content, file = token.content, named and named[1]
        if kind.startswith("{"):
            options = dict(re.findall(r"^:([\w-]+): *(.*)\n", content, re.MULTILINE))
            file = options.get("caption")
            if file is None:
                continue
            content = re.sub(r"\A(:[\w-]+:.*\n)*\n*", "", content)
            if kind == "{literalinclude}":
                content = (page.parent / argument.strip()).resolve().read_text(encoding="utf-8")
        found.append(Block(kind, content, token.map[0] + 1, token.map[1], file, reason and reason[1]))
    return found


def runnable(page: Path) -> bool:
    """Return whether any block of a page is run."""
    return any(block.reason is None and block.kind in ("console", "python") for block in blocks(page))


def run(page: Path, folder: Path) -> dict[int, str]:
    """Run a page's blocks in a folder; raises BlockError at the first one that fails.

    Returns what blocks printed that the page does not show itself, by their number from 0.
    """
    namespace: dict[str, object] = {"__name__": "__main__"}
    printed, unshown = "", {}
    for number, block in enumerate(blocks(page)):
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
        elif block.kind == "toml":
            tomllib.loads(block.text)
        elif block.kind == "output":
            _compare(block.text, printed, where)
            unshown.popitem()
        else:
            raise BlockError(f"{where}: a block of {block.kind} cannot be run, and needs a reason")
        if printed.strip() and block.kind in ("console", "python") and not (block.reason or block.file):
            unshown[number] = printed
    return unshown


def folder_of(page: Path) -> Path:
    """Return the folder in which the build runs a page of the site."""
    return DOCS / "_generated" / page.relative_to(DOCS).with_suffix("")


def has_run(page: Path) -> bool:
    """Return whether the build has run the blocks of a page of the site as they are now, with the code as it is now."""
    if not page.is_relative_to(DOCS):
        return False
    mark = folder_of(page) / ".run.json"
    return mark.exists() and (noted := json.loads(mark.read_text())) == digests(page, noted)


def run_anew(page: Path) -> None:
    """Run a page of the site in its emptied folder, and note there what it printed and what it was made from.

    Call it in a process of its own: the code that a page uses is that which the process has imported.
    """
    folder = folder_of(page)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    printed = {at: text.replace(f"{folder}/", "") for at, text in run(page, folder).items()}
    (folder / ".printed.json").write_text(json.dumps(printed), encoding="utf-8")
    (folder / ".run.json").write_text(json.dumps(digests(page, [BLOCKS, *packages()])), encoding="utf-8")


def packages() -> Iterator[str]:
    """Yield the folders of this repository that hold the code of a run: those imported here or in its processes."""
    places = [ROOT.joinpath(*name.split(".")) for name in sys.modules if name.partition(".")[0] == "bench"]
    imported = {place if place.is_dir() else place.parent for place in places}
    for top in IN_PROCESSES:
        imported |= {path.parent for path in (ROOT / top).rglob("*.py")}
    yield from sorted(str(path.relative_to(ROOT)) for path in imported)


def digests(page: Path, parts: Iterable[str]) -> dict[str, str]:
    """Return the hash of each of the parts that a page is made from: its blocks, and the files of folders with code."""
    content = {BLOCKS: repr([(block.kind, block.text, block.file, block.reason) for block in blocks(page)]).encode()}
    for part in {*parts} - {BLOCKS}:
        files = sorted(path for path in (ROOT / part).glob("*.*") if path.is_file())
        content[part] = b"".join(path.name.encode() + path.read_bytes() for path in files)
    return {part: hashlib.sha256(text).hexdigest() for part, text in content.items()}


def _shell(line: str, folder: Path, where: str) -> str:
    """Run a line of shell, or in this process where it is nothing but a bench command; return what it printed."""
    expected = EXIT.search(line)
    words = list(shlex.shlex(line, posix=True, punctuation_chars=True))
    alone = words[:1] == ["bench"] and not any(set(word) <= set("();<>|&") for word in words) and "$" not in line
    with _environment(folder):
        code, out, error = _bench(shlex.split(line, comments=True)) if alone else _bash(line)
    if code != (int(expected[1]) if expected else 0):
        raise BlockError(f"{where}: {line!r} ended with {code}\n{out}{error}")
    return out


@contextlib.contextmanager
def _environment(folder: Path) -> Iterator[None]:
    """Work in a folder, find this environment's programs, and keep the user's own data out."""
    before = dict(os.environ)
    os.environ |= {
        "PATH": str(Path(sys.executable).parent) + os.pathsep + os.environ["PATH"], "COLUMNS": "80",
        "MPLBACKEND": "agg", "BENCH_ARCHIVE": str(folder / "archive"),
        "BENCH_PUBLISHED_DATA": str(folder / "published"),
    }  # fmt: skip
    try:
        with contextlib.chdir(folder):
            yield
    finally:
        os.environ.clear()
        os.environ |= before


def _bash(line: str) -> tuple[int, str, str]:
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, encoding="utf-8", check=False)
    return done.returncode, done.stdout, done.stderr


def _bench(words: list[str]) -> tuple[int, str, str]:
    """Run the command line in this process, which spares its start and imports: most of a page's time."""
    from bench.cli import app

    out, error, code = io.StringIO(), io.StringIO(), 0
    given, sys.argv = sys.argv, words
    before = signal.getsignal(signal.SIGTERM)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
            app.main()
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else int(bool(ended.code))
    finally:
        sys.argv = given
        signal.signal(signal.SIGTERM, before)
    return code, out.getvalue(), error.getvalue()


def _python(code: str, namespace: dict[str, object], folder: Path, where: str) -> str:
    """Run Python in a namespace; return what it printed."""
    out = io.StringIO()
    sys.path.insert(0, str(folder))  # as of a script in this folder
    try:
        with _environment(folder), contextlib.redirect_stdout(out):
            exec(compile(code, where, "exec"), namespace)
    except Exception as error:
        raise BlockError(f"{where}: {type(error).__name__}: {error}\n{out.getvalue()}") from error
    finally:
        sys.path.remove(str(folder))
    return out.getvalue()


def _compare(shown: str, printed: str, where: str) -> None:
    """Raise BlockError where the output that a page shows is not what was printed, but for spaces at line ends."""
    pattern = ".*?".join(re.escape(part) for part in _stripped(shown).split("…"))
    if not re.fullmatch(pattern, _stripped(printed), re.DOTALL):
        raise BlockError(f"{where}: the page shows\n{shown}\nbut this was printed:\n{printed}")


def _stripped(text: str) -> str:
    return "\n".join(line.rstrip() for line in text.strip().splitlines())
