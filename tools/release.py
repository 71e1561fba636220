"""Build a release and try it: ``python tools/release.py [--rehearse]``, which ``nox -s release`` calls.

The steps, in order; the first that fails ends the release with one sentence and exit code 1:

1. ``version`` of pyproject.toml has a dated entry in CHANGELOG.md, and the checkout has no uncommitted changes.
2. sdist and wheel are built from the commit, twice in different folders, and have the same bytes; the wheel is built
   from the sdist.
3. ``twine check`` accepts both.
4. In fresh environments of the oldest and the newest supported Python, with the lowest and the newest packages that
   satisfy pyproject.toml, ``bench run quick --trials 3`` makes its trials and writes a report that can be read, and
   README's first minute ends with an answer.
5. Every package that is installed with it, extras included, has a licence that Apache-2.0 may be combined with.
6. A software bill of materials (CycloneDX) lists the packages of a plain installation.

``dist/`` then holds what is published, ``build/release/`` the licences and the bill of materials. A rehearsal goes on
where the changelog has no date yet or the checkout has changes; what is built is the commit.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DIST, NOTES = ROOT / "dist", ROOT / "build" / "release"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
UV = (sys.executable, "-m", "uv")

# Licences by the words that name them, the strictest first. Apache-2.0 may become part of a work under the third
# version of the GPL, not of one under the second alone (www.apache.org/licenses/GPL-compatibility.html).
REFUSED = r"AGPL|Affero|GPL-2\.0-only|GPLv2|proprietary|commercial"
EXTRAS_ONLY = r"(?<!L)GPL-3\.0|(?<!L)GPLv3|(?<!L)GPL-2\.0-or-later"
FREE = (
    r"MIT|BSD|Apache|ISC|PSF|Python Software Foundation|Zlib|CC0|Unlicense|HPND"
    r"|MPL|Mozilla Public License|LGPL|Lesser General Public|Permission is hereby granted, free of charge"
)


def main() -> None:
    """Make the release, or rehearse it."""
    parser = argparse.ArgumentParser(description="Build a release and try it.")
    parser.add_argument("--rehearse", action="store_true", help="go on without a date in the changelog or a commit")
    rehearse = parser.parse_args().rehearse
    for problem in (*changelog_problems(), *changes()):
        if not rehearse:
            stop(problem)
        print(f"rehearsal: {problem}")
    with tempfile.TemporaryDirectory(prefix="release-") as folder:
        place = Path(folder)
        artefacts = build(place)
        call(sys.executable, "-m", "twine", "check", "--strict", *artefacts)
        tried = [try_out(place, *each) for each in environments(artefacts)]
        licences(place, artefacts[-1])
        packages(place)
    print("\n".join([f"{PROJECT['name']} {PROJECT['version']}", *tried, *(str(each) for each in artefacts)]))


def stop(sentence: str) -> None:
    """End the release with one sentence."""
    sys.exit(f"release: {sentence}")


def call(*command: object, cwd: Path = ROOT, **environment: str) -> str:
    """Run a program and return what it printed; end the release where it fails."""
    words = [str(word) for word in command]
    print("+", *words, flush=True)
    done = subprocess.run(words, cwd=cwd, env=os.environ | environment, capture_output=True, text=True, check=False)
    if done.returncode:
        stop(f"{' '.join(words)} ended with {done.returncode}:\n{done.stdout[-4000:]}{done.stderr[-4000:]}")
    return done.stdout


# 1. What is released


def changelog_problems(root: Path = ROOT, version: str = PROJECT["version"]) -> Iterator[str]:
    """Yield a sentence where the changelog has no dated entry of a version."""
    text = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    if not re.search(rf"^## {re.escape(version)} - \d{{4}}-\d\d-\d\d$", text, re.MULTILINE):
        yield f"CHANGELOG.md has no line '## {version} - YYYY-MM-DD'; give the entry its version and date"


def changes() -> Iterator[str]:
    """Yield a sentence where the checkout differs from its commit."""
    if call("git", "status", "--porcelain"):
        yield "the checkout has uncommitted changes; commit them, as the commit alone is built"


# 2. Building


def build(place: Path) -> list[Path]:
    """Build sdist and wheel of the commit twice, compare their bytes, and return their paths in ``dist``."""
    epoch = call("git", "show", "--no-patch", "--format=%ct", "HEAD").strip()
    digests = []
    for name, mask in (("first", 0o022), ("second/below", 0o077)):  # neither may change a byte
        source, out = place / name, place / f"{name}-out"
        source.mkdir(parents=True)
        before = os.umask(mask)
        call("git", "archive", "--output", place / "source.tar", "HEAD")
        call("tar", "-x", "-f", place / "source.tar", cwd=source)
        call(*UV, "build", "--out-dir", out, source, SOURCE_DATE_EPOCH=epoch)
        os.umask(before)
        digests.append({file.name: digest(file) for file in out.iterdir() if file.suffix in (".gz", ".whl")})
    if digests[0] != digests[1]:
        stop(f"two builds of one commit differ: {digests[0]} and {digests[1]}")
    shutil.rmtree(DIST, ignore_errors=True)
    shutil.rmtree(NOTES, ignore_errors=True)
    DIST.mkdir()
    NOTES.mkdir(parents=True)
    return [Path(shutil.copy(place / "first-out" / name, DIST)) for name in sorted(digests[0], reverse=True)]


def digest(file: Path) -> str:
    """Return a file's SHA-256."""
    return hashlib.sha256(file.read_bytes()).hexdigest()


# 4. Trying it out


def environments(artefacts: list[Path]) -> Iterator[tuple[str, Path, str]]:
    """Yield Python version, artefact and resolution of every trial installation."""
    sdist, wheel = artefacts
    for version in (versions()[0], versions()[-1]):
        yield version, wheel, "lowest-direct"
        yield version, wheel, "highest"
        yield version, sdist, "highest"


def versions() -> list[str]:
    """Return the supported versions of Python, from the classifiers."""
    found = (re.fullmatch(r"Programming Language :: Python :: (3\.\d+)", each) for each in PROJECT["classifiers"])
    return [match[1] for match in found if match]


def try_out(place: Path, version: str, artefact: Path, resolution: str) -> str:
    """Install an artefact into a fresh environment and run the quick study; return a line for the summary."""
    kind = "sdist" if artefact.suffix == ".gz" else "wheel"
    name = f"Python {version}, {kind}, {resolution}"
    home = place / name.replace(" ", "-")
    made = subprocess.run([*UV, "venv", "--python", version, str(home)], capture_output=True, check=False)
    if made.returncode:
        return f"skipped: {name}: there is no Python {version} here, and uv could not get one"
    # Where a library has no wheel for this Python, an older version of it is no version that anybody would install.
    own = [] if kind == "sdist" else ["--only-binary", ":all:"]
    # "lowest-direct" means the requirements that are named here, and not those of the artefact.
    call(*UV, "pip", "install", "--python", home, "--resolution", resolution, *own, artefact, *PROJECT["dependencies"])
    if resolution == "lowest-direct" and version == versions()[0]:
        require_lowest(home)
    call(python(home).with_name("bench"), "--version", cwd=home)
    call(python(home).with_name("bench"), "run", "quick", "--trials", "3", "--output", "out", cwd=home)
    trials = int(call(python(home), "-c", READ, cwd=home))
    (home / "minute.py").write_text(first_minute(), encoding="utf-8")
    answer = call(python(home), "minute.py", cwd=home).partition("\n")[0]
    used = ", ".join(installed(home, "numpy", "numba", "pandas", "typer"))
    return f"passed: {name}: {trials} trials, {used}; README's first minute: {answer}"


def first_minute() -> str:
    """Return the first block of Python of README.md."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    return readme.partition("```python\n")[2].partition("```")[0]


READ = """
import bench, pathlib
frame, page = bench.load_results("out"), pathlib.Path("out/report.html").read_text(encoding="utf-8")
assert (frame["status"] == "ok").all()
assert all(part in page for part in ('id="part.answer"', *set(frame["optimizer"])))
print(len(frame))
"""


def python(home: Path) -> Path:
    """Return the interpreter of an environment."""
    return home / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def require_lowest(home: Path) -> None:
    """End the release where a lower bound of pyproject.toml is not what is installed, so that it was not tried."""
    found = dict(each.lower().split(" ") for each in installed(home))
    for name, bound in re.findall(r"^([a-z0-9-]+)>=([0-9.]+)", "\n".join(PROJECT["dependencies"]), re.MULTILINE):
        if not re.fullmatch(rf"{re.escape(bound)}(\.0)*", found[name]):
            stop(f"the lowest {name} that can be installed is {found[name]}; raise its bound in pyproject.toml")


def installed(home: Path, *names: str) -> list[str]:
    """Return the names and versions of some packages of an environment, by default of all from an index."""
    listed = [each.partition("==") for each in call(*UV, "pip", "freeze", "--python", home).splitlines()]
    return [f"{name} {version}" for name, mark, version in listed if mark and name in (names or (name,))]


# 5. and 6. What comes with it


def licences(place: Path, wheel: Path) -> None:
    """Write the licences of all packages that come with a plain installation and with the extras; refuse some."""
    rows = {}
    for name, extras in (("plain", ""), ("extras", f"[{','.join(PROJECT['optional-dependencies'])}]")):
        call(*UV, "venv", place / name)
        call(*UV, "pip", "install", "--python", place / name, f"{wheel}{extras}")
        found = json.loads(
            call(
                sys.executable,
                "-m",
                "piplicenses",
                "--python",
                python(place / name),
                "--from",
                "all",
                "--format",
                "json",
            )
        )
        rows[name] = {each["Name"]: (each["Version"], licence(each)) for each in found}
    lines = ["| package | version | licence | comes with |", "|-|-|-|-|"]
    for name, (version, text) in sorted(rows["extras"].items(), key=lambda row: row[0].lower()):
        extra = name not in rows["plain"]
        if problem := licence_problem(name, text, extra):
            stop(problem)
        lines.append(f"| {name} | {version} | {text} | {'extras' if extra else 'every installation'} |")
    (NOTES / "licences.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def packages(place: Path) -> None:
    """Write the bill of materials of a plain installation."""
    options = ("--output-reproducible", "--pyproject", ROOT / "pyproject.toml", "-o", NOTES / "sbom.cdx.json")
    call(sys.executable, "-m", "cyclonedx_py", "environment", *options, python(place / "plain"))


def licence(found: dict[str, str]) -> str:
    """Return the licence that a package states: an SPDX expression, else its classifier, else the first words."""
    texts = (found[f"License-{kind}"] for kind in ("Expression", "Classifier", "Metadata"))
    text = next((each for each in texts if each.strip() and each != "UNKNOWN"), "UNKNOWN")
    return " ".join(text.split()) if len(text) <= 100 else next(iter(re.findall(FREE, text)), "UNKNOWN")


def licence_problem(name: str, text: str, extra: bool) -> str:
    """Return why a package of that licence cannot come with this one, "" where it can."""
    choices = [judged(each, extra) for each in re.split(r"\bOR\b", text)]
    if "" in choices:
        return ""
    return (
        f"{name} has the licence {text!r}, {choices[0]}; leave the package out, or add its licence to tools/release.py"
    )


def judged(text: str, extra: bool) -> str:
    """Return what is wrong with a licence all of whose parts apply, "" where nothing is."""
    for part in re.split(r"\bAND\b|;", text):
        if re.search(REFUSED, part):
            return "which Apache-2.0 cannot be combined with"
        if re.search(EXTRAS_ONLY, part):
            if not extra:
                return "under which the whole would be; it may come with an extra only"
        elif not re.search(FREE, part):
            return "which is unknown"
    return ""


if __name__ == "__main__":
    main()
