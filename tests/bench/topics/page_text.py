"""The words and numbers of a whole page as text, to be compared with the text that is committed."""

import re
from difflib import unified_diff
from pathlib import Path

from bench.report import Table
from bench.topics.answer import section as answer
from bench.topics.page import chapters
from bench.topics.trust import section as trust
from bench.topics.write import lead

PAGES = Path(__file__).parent / "pages"
MOST = 40  # lines of a difference that a failure shows

# Simulated rates may move by a digit with another version of NumPy or SciPy, hashes with a layout of the store.
MOVING = (
    (r"[0-9a-f]{12,}", "HASH"),
    (r"the families are [^:]*:", "the families are …:"),
    (r"\n{3,}", "\n\n"),
    (r"[<>]?\d+% of ([\d,]+) simulated studies \(standard error [\d.]+%\)", r"…% of \1 simulated studies"),
    (r"(lower on any problem in|over all problems in) [<>]?\d+%", r"\1 …%"),
)


def page_text(findings):
    """Return the lines of the page of these findings: all but drawings and most single problems."""
    lines = [f"# {findings.study.title or findings.study.name}", "", lead(findings)]
    for chapter in chapters(findings):
        for section in chapter.sections():
            lines += section_lines(section)
            for file in section.files:
                lines += ["", f"File {file.path}: {file.about}"]
                lines += file.content.splitlines() if file.path.endswith(".md") else []
    text = "\n".join(lines) + "\n"
    for pattern, instead in MOVING:
        text = re.sub(pattern, instead, text)
    return text


def answer_text(findings):
    """Return the lines of the first two sections."""
    made = (answer.section(findings), trust.section(findings))
    lines = [line for section in made for line in (section_lines(section) if section else ())]
    return "\n".join(lines) + "\n"


def section_lines(section, level="##"):
    lines = ["", f"{level} {section.title}{' [folded]' * section.folded}", ""]
    lines += [f"lost: {section.lost}"] if section.lost else []
    for card in section.cards:
        lines += ["", f"[{card.tone}]", card.text]
    lines += [f"  {each.label}: {each.text}{f' -> {each.part}' * bool(each.part)}" for each in section.lines]
    lines += section.text
    for item in section.items:
        lines += table_lines(item) if isinstance(item, Table) else ["", f"Figure {item.name}: {item.caption}"]
    for each in section.sections:
        lines += section_lines(each, "###")
    return lines


def table_lines(table):
    """Return a table's caption, head, rows and note: ``*bold*``, ``/italic/``, ``!lost``, ``^mark``."""
    rows = [" | ".join(map(cell_text, row)) for row in table.rows]
    head = " | ".join(title for title, _ in table.header)
    return ["", f"Table {table.name}: {table.caption}", head, *rows, *([f"({table.note})"] if table.note else [])]


def cell_text(cell):
    text = f"*{cell.text}*" if cell.bold else f"/{cell.text}/" if cell.italic else cell.text
    return f"{'!' * cell.lost}{text}{f'^{cell.mark}' * bool(cell.mark)}"


def compare(name, text, update):
    """Fail with the lines that differ from those committed, or write them."""
    file = PAGES / f"{name}.txt"
    if update:
        file.write_text(text, encoding="utf-8")
    committed = file.read_text(encoding="utf-8") if file.exists() else ""
    if text != committed:
        changes = [*unified_diff(committed.splitlines(), text.splitlines(), "committed", "now", lineterm="", n=0)]
        rest = f"\n… and {len(changes) - MOST} more lines" if len(changes) > MOST else ""
        shown = "\n".join(line[:300] for line in changes[:MOST])
        raise AssertionError(f"the page {name} changed; where that is meant: pytest --update\n{shown}{rest}")
