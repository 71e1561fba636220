"""Modules are loaded as they were read once, by every process that has taken them."""

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

from bench import BenchError
from bench.plugins import files
from bench.plugins.from_file import contents, fingerprint


@pytest.fixture
def mine(tmp_path, monkeypatch):
    """The files of an optimizer that imports a module and a package, which this process finds beside it."""
    (tmp_path / "mine.py").write_text("import taken_helper\ndef late():\n    import taken_package.inner")
    (tmp_path / "taken_helper.py").write_text("def step():\n    return 1")
    (tmp_path / "taken_package").mkdir()
    (tmp_path / "taken_package" / "inner.py").write_text("STEP = 1")
    monkeypatch.setattr(files, "taken", {})
    monkeypatch.setattr(files, "_finder", files._Finder())
    monkeypatch.setattr(sys, "meta_path", [*sys.meta_path])
    monkeypatch.syspath_prepend(tmp_path)
    yield contents([f"{tmp_path / 'mine.py'}:late"])
    for name in [name for name in sys.modules if name.startswith("taken_")]:
        del sys.modules[name]


def test_edited_and_removed_modules_are_loaded_as_they_were_read(mine, tmp_path):
    assert files.changed(mine) == []
    (tmp_path / "taken_helper.py").write_text("def step():\n    return 2")
    (tmp_path / "taken_package" / "inner.py").unlink()
    files.take(mine)
    assert importlib.import_module("taken_helper").step() == 1
    assert importlib.import_module("taken_package.inner").STEP == 1
    assert files.changed(mine) == [str(tmp_path / "taken_helper.py"), str(tmp_path / "taken_package" / "inner.py")]


def test_a_module_that_was_edited_has_the_path_of_a_copy_for_caches_by_date(mine, tmp_path):
    helper = tmp_path / "taken_helper.py"
    read = helper.read_text()
    helper.write_text("def step():\n    return 2")
    files.take(mine)
    module = importlib.import_module("taken_helper")
    path = module.step.__code__.co_filename
    assert (module.__file__, path != str(helper), Path(path).read_text()) == (str(helper), True, read)
    helper.write_text(read)
    del sys.modules["taken_helper"]
    assert importlib.import_module("taken_helper").step.__code__.co_filename == str(helper)


COMPILED = "from numba import njit\n@njit(cache=True)\ndef step(x):\n    return {} * x\n"
USE = """
import sys
from bench.plugins import files
from bench.plugins.from_file import contents
name, new = sys.argv[1:]
read = contents([name])
helper = next(module.path for shown, module in next(iter(read.values())).items() if "compiled" in shown)
if new:
    helper.write_text(new)
files.take(read)
sys.path.append(str(helper.parent))
import compiled_helper
print(compiled_helper.step(1.0))
"""


@pytest.mark.slow
def test_machine_code_of_the_old_content_is_never_taken_for_that_of_the_new_one(tmp_path):
    """The hash by which numba looks up machine code covers no constants, as those two versions differ in."""
    (tmp_path / "mine.py").write_text("import compiled_helper")
    (tmp_path / "compiled_helper.py").write_text(COMPILED.format(1))
    words = [sys.executable, "-c", USE, f"{tmp_path / 'mine.py'}:late"]
    printed = [
        subprocess.run([*words, new], capture_output=True, text=True, check=True).stdout.strip()
        for new in ("", COMPILED.format(2), "", "")
    ]
    assert printed == ["1.0", "1.0", "2.0", "2.0"]


def test_files_of_an_installed_optimizer_are_read_where_it_is_a_link_to_them():
    read = contents(["gwo", "mealpy:OriginalGWO", "hill-climber", "unknown", "recording:x.csv"])
    assert list(read) == ["optimizers.gwo", "optimizers.mealpy", "testing_plugins"]
    assert list(fingerprint("gwo", read))[-1] == "optimizers/gwo.py"
    assert fingerprint("unknown", read) == {}


def test_modules_of_one_name_that_one_process_needs_are_refused(tmp_path):
    for folder in ("problems", "optimizers", "others"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "mine.py").write_text("import helper_of_two")
        (tmp_path / folder / "helper_of_two.py").write_text("")
    problem, *optimizers = (f"{tmp_path / folder / 'mine.py'}:mine" for folder in ("problems", "optimizers", "others"))
    assert len(contents(optimizers)) == 2
    with pytest.raises(BenchError, match=r"imports .*/problems/helper_of_two.py and .* one module of a name alone"):
        contents(optimizers, [problem])
