"""Packages whose plug-ins end the process, cannot be read or are no commands: one sentence, and the rest works."""

import os
import subprocess
import sys

import pytest

WORKS = ["list", "studies"]
PLUGINS = {
    "exits": ("[bench.commands]\nmine = mine:command\n", "import sys\nsys.exit(0)\n"),
    "ends": ("[bench.commands]\nmine = mine:command\n", "raise GeneratorExit\n"),
    "malformed": ("[bench.commands]\nmine\n", ""),
    "other": ("[console_scripts]\nthis is no entry point\n", ""),
    "value": ("[bench.commands]\nmine = not a module\n", ""),
    "number": ("[bench.commands]\nmine = mine:command\n", "command = 3\n"),
    "annotated": ("[bench.commands]\nmine = mine:command\n", "def command(x: 'Undefined'): pass\n"),
    "built-in": ("[bench.commands]\nrun = mine:command\n", "def command():\n    print('mine')\n"),
}


def called(place, kind, *arguments):
    """Return what the command line does beside a package of this kind."""
    entries, code = PLUGINS[kind]
    information = place / "mine-1.0.dist-info"
    information.mkdir(exist_ok=True)
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n")
    (information / "entry_points.txt").write_text(entries)
    (place / "mine.py").write_text(code)
    path = os.pathsep.join(filter(None, [str(place), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        [sys.executable, "-m", "bench", *map(str, arguments)],
        env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert "Traceback" not in done.stderr
    return done


@pytest.mark.parametrize("kind", PLUGINS)
@pytest.mark.sampled(2)
def test_a_broken_package_stops_no_command_of_the_harness(kind, tmp_path):
    done = called(tmp_path, kind, *WORKS)
    assert done.returncode == 0
    assert "quick" in done.stdout


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("exits", "the plug-in 'mine' of bench.commands (mine:command) failed to load: SystemExit: 0"),
        ("ends", "failed to load: GeneratorExit"),
        ("number", "the plug-in 'mine' of bench.commands is no function but a int"),
        ("annotated", "the command 'mine' cannot be called: "),
    ],
)
@pytest.mark.sampled(2)
def test_the_broken_command_itself_ends_with_2_and_a_sentence(kind, said, tmp_path):
    done = called(tmp_path, kind, "mine")
    assert done.returncode == 2
    assert said in " ".join(done.stderr.split())


def test_a_command_that_a_plug_in_ends_in_its_midst_is_no_success(tmp_path):
    PLUGINS["midst"] = ("[bench.commands]\nmine = mine:command\n", "import sys\ndef command():\n    sys.exit(0)\n")
    done = called(tmp_path, "midst", "mine")
    assert done.returncode == 2
    assert "a plug-in called sys.exit, so the command ended before it was done" in done.stderr
