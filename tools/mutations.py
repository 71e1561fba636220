"""Change the code in small ways, one at a time, and print which changes the fast tests find.

``python tools/mutations.py`` changes a copy of this tree in 60 places of analysis, storage, execution, scoring, study
and the swarms, and runs the tests of the folder that mirrors the module: first the files named after it or its folder.
``--of COMMIT`` takes the places from another commit, ``--only`` those of paths that begin so.
"""

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from itertools import chain, zip_longest
from pathlib import Path
from time import monotonic

ROOT = Path(__file__).resolve().parents[1]
SWARMS = [f"optimizers/{name}.py" for name in ("alo", "da", "goa", "gwo")]
PACKAGES = [*([f"bench/{name}"] for name in ("analysis", "storage", "execution", "trial/scoring", "study")), SWARMS]
EACH, SEED = 10, 61  # mutations of a package
LONGEST_S = 1800  # of the tests without a mutation; with one, three times as long is an endless loop
KINDS = "comparison", "sum", "constant", "not"
CHANGED = {
    ast.Lt: ("<", "<="), ast.LtE: ("<=", "<"), ast.Gt: (">", ">="), ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="), ast.NotEq: ("!=", "=="), ast.Add: ("+", "-"), ast.Sub: ("-", "+"),
}  # fmt: skip


def git(*arguments):
    """Return what git prints of this tree."""
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True).stdout


def mutations(path, text):
    """Return the mutations of a file by kind: (path, line, how many lines before it are the same, what it becomes)."""
    lines, kinds = text.splitlines(), {kind: [] for kind in KINDS}

    def note(kind, row, start, end, old, new):
        line, before = lines[row - 1].encode(), lines[: row - 1].count(lines[row - 1])
        if old in (part := line[start:end].decode()):
            changed = line[:start] + part.replace(old, new, 1).encode() + line[end:]
            kinds[kind].append((path, line.decode(), before, changed.decode()))

    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.expr) or node.lineno != node.end_lineno:
            continue
        match node:
            case ast.Compare(left, [op], [right]) if type(op) in CHANGED:
                note("comparison", node.lineno, left.end_col_offset, right.col_offset, *CHANGED[type(op)])
            case ast.BinOp(left, ast.Add() | ast.Sub() as op, right):
                note("sum", node.lineno, left.end_col_offset, right.col_offset, *CHANGED[type(op)])
            case ast.Constant(int() | float() as value) if not isinstance(value, bool):
                old = ast.get_source_segment(text, node)
                note("constant", node.lineno, node.col_offset, node.end_col_offset, old, repr(value + 1))
            case ast.UnaryOp(ast.Not()):
                note("not", node.lineno, node.col_offset, node.end_col_offset, "not ", "")
    return kinds


def chosen(commit):
    """Return the mutations of a commit, the same ones each time: of each package of the kinds in turn."""
    rng, choice = random.Random(SEED), []
    for package in PACKAGES:
        paths = git("ls-tree", "-r", "--name-only", commit, *package).split()
        files = [mutations(path, git("show", f"{commit}:{path}")) for path in paths if path.endswith(".py")]
        pools = [list(chain.from_iterable(file[kind] for file in files)) for kind in KINDS]
        for pool in pools:
            rng.shuffle(pool)
        choice += list(filter(None, chain.from_iterable(zip_longest(*pools))))[:EACH]
    return choice


def finders(tree, path, limit):
    """Return which tests of a copy fail: those of the module, else the others of its folder, else "" for none."""
    folder, name, levels = tree / "tests" / Path(path).parent, Path(path).stem, {"module": [], "folder": []}
    for file in sorted(folder.rglob("test_*.py")):
        levels["module" if name in f"{file.stem} {file.parent.name}" else "folder"].append(file)
    environment = os.environ | {"PYTHONPATH": str(tree)}  # before the tree in which the package is installed
    for level in filter(levels.get, levels):
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *map(str, levels[level])]
        try:
            done = subprocess.run(command, cwd=tree, env=environment, capture_output=True, timeout=limit, check=False)
        except subprocess.TimeoutExpired:
            return f"{level} (time)"
        if done.returncode not in (0, 5):  # 5: all of them are slow
            return level
    return ""


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--of", default="HEAD", metavar="COMMIT")
parser.add_argument("--only", default="", metavar="PATH")
arguments = parser.parse_args()
levels, limits = [], {}
with tempfile.TemporaryDirectory() as name:
    tree = Path(name)
    for file in git("ls-files").splitlines():
        (tree / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / file, tree / file)
    for path, line, before, changed in chosen(arguments.of):
        text = (tree / path).read_text(encoding="utf-8") if (tree / path).exists() else ""
        lines = text.split("\n")
        places = [place for place, here in enumerate(lines) if here == line]
        if not path.startswith(arguments.only) or before >= len(places):
            continue
        if (folder := Path(path).parent) not in limits:
            begun, failing = monotonic(), finders(tree, path, LONGEST_S)
            limits[folder] = 0 if failing else 60 + 3 * (monotonic() - begun)
            print(f"tests/{folder} {'FAILS' if failing else 'passes'} without a mutation", flush=True)
        if not limits[folder]:
            continue
        lines[places[before]] = changed
        (tree / path).write_text("\n".join(lines), encoding="utf-8")
        levels.append(finders(tree, path, limits[folder]))
        (tree / path).write_text(text, encoding="utf-8")
        print(f"{levels[-1] or 'SURVIVED'}: {path}\n  {line.strip()}\n  {changed.strip()}", flush=True)
print(f"{sum(map(bool, levels))} of {len(levels)} mutations are found")
