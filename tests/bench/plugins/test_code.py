"""What decides trials: a file with all that it imports from outside installed packages, and packages by version."""

import importlib.machinery
import shutil
import sys
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import spec_from_file_location
from typing import ClassVar

import pytest

from bench import BenchError, Optimizer, load_optimizer, load_problem
from bench.plugins import code


def mapping(file):
    return code.hashes(code.modules(file, file.read_bytes()))


@pytest.fixture
def written(tmp_path, tmp_path_factory, monkeypatch):
    """Return what writes files below a folder and returns the hashes of the first one and its imports.

    Python does not find the modules of other tests, whose folders loaded files have left on the path.
    """
    others = str(tmp_path_factory.getbasetemp())
    monkeypatch.setattr(sys, "path", [place for place in sys.path if not place.startswith(others)])

    def write(files, folder=tmp_path):
        for name, content in files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(content)
        return mapping(folder / next(iter(files)))

    return write


@pytest.mark.parametrize(
    ("files", "found"),
    [
        ({"mine.py": "import numpy, json, bench.objective", "json.py": "", "numpy.py": ""}, []),
        ({"mine.py": "from helper import STEP", "helper.py": "STEP = 1", "other.py": ""}, ["helper.py"]),
        ({"mine.py": "def late():\n    import helper", "helper.py": ""}, ["helper.py"]),
        ({"mine.py": "import helper", "helper.py": "import deeper", "deeper.py": ""}, ["deeper.py", "helper.py"]),
        ({"mine.py": "import helper", "helper.py": "import mine, other", "other.py": "import helper"},
         ["helper.py", "other.py"]),
        ({"mine.py": "import missing_module, missing_package.inner"}, []),
        ({"mine.py": "import helper", "helper.py": "def"}, ["helper.py"]),
        ({"mine.py": "def", "helper.py": ""}, []),
        ({"mine.py": "import pkg", "pkg/__init__.py": "", "pkg/inner.py": ""}, ["pkg/__init__.py"]),
        ({"mine.py": "import pkg.inner", "pkg/__init__.py": "", "pkg/inner.py": ""},
         ["pkg/__init__.py", "pkg/inner.py"]),
        ({"mine.py": "from pkg import inner, STEP", "pkg/__init__.py": "", "pkg/inner.py": ""},
         ["pkg/__init__.py", "pkg/inner.py"]),
        ({"mine.py": "import pkg", "pkg/__init__.py": "from .inner import x", "pkg/inner.py": "from . import other",
          "pkg/other.py": "from ..up import x", "up.py": ""}, ["pkg/__init__.py", "pkg/inner.py", "pkg/other.py"]),
        ({"mine.py": "from pkg import *", "pkg/__init__.py": "__all__ = ['a']", "pkg/a.py": "", "pkg/b.py": ""},
         ["pkg/__init__.py", "pkg/a.py"]),
        ({"mine.py": "import space.inner.deep", "space/inner/deep.py": "", "space/inner/other.py": ""},
         ["space/inner/deep.py"]),
        ({"mine.py": "from importlib import import_module\nimport_module('helper')", "helper.py": ""}, ["helper.py"]),
    ],
)  # fmt: skip
def test_a_file_counts_with_all_that_it_imports_from_outside_installed_packages(written, files, found):
    assert list(written(files)) == ["mine.py", *found]


def test_the_difference_of_two_versions_names_the_helper(written):
    files = {"mine.py": "from helper import STEP", "helper.py": "STEP = 1", "other.py": "import helper"}
    before = written(files)
    assert code.differences(before, written(files | {"helper.py": "STEP = 1  # of the box"})) == []
    assert code.differences(before, written(files | {"helper.py": "STEP = 2"})) == ["helper.py"]
    assert code.differences(before, written(files | {"mine.py": "STEP = 1"})) == ["mine.py", "helper.py"]


def test_a_folder_that_is_moved_or_has_spaces_keeps_its_hashes(written, tmp_path):
    files = {"mine.py": "import helper, pkg.inner", "helper.py": "", "pkg/inner.py": ""}
    before = written(files, tmp_path / "here")
    shutil.move(tmp_path / "here", tmp_path / "a b" / "there")
    assert mapping(tmp_path / "a b" / "there" / "mine.py") == before
    assert list(before) == ["mine.py", "helper.py", "pkg/inner.py"]


def test_a_link_counts_as_the_file_beside_which_its_modules_lie(written, tmp_path):
    before = written({"real/mine.py": "import helper", "real/helper.py": "STEP = 1", "helper.py": "STEP = 2"})
    (tmp_path / "link.py").symlink_to(tmp_path / "real" / "mine.py")
    assert mapping(tmp_path / "link.py") == before


def test_a_module_of_a_checkout_on_the_path_counts_and_wins_over_one_beside_the_file(written, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path / "checkout")
    files = {
        "own/mine.py": "import of_both",
        "own/of_both.py": "STEP = 1",
        "checkout/of_both.py": "STEP = 2",
    }
    before = written(files)
    assert list(before) == ["mine.py", "of_both.py"]
    assert written(files | {"own/of_both.py": "STEP = 3"}) == before
    assert code.differences(before, written(files | {"checkout/of_both.py": "STEP = 3"})) == ["of_both.py"]


def test_a_package_that_its_installer_finds_by_a_finder_of_its_own_counts_by_its_files(written, tmp_path, monkeypatch):
    class Linked:
        @staticmethod
        def find_spec(name, path=None, target=None):
            init = tmp_path / "checkout" / "linked_by_finder" / "__init__.py"
            return spec_from_file_location(name, init) if name == "linked_by_finder" else None

    monkeypatch.setattr(sys, "meta_path", [*sys.meta_path, Linked])
    package = {"checkout/linked_by_finder/__init__.py": "", "checkout/linked_by_finder/inner.py": ""}
    found = written({"own/mine.py": "from linked_by_finder.inner import x"} | package)
    assert list(found) == ["mine.py", "linked_by_finder/__init__.py", "linked_by_finder/inner.py"]
    assert list(code.linked("linked_by_finder.inner")) == list(found)[1:]


def test_two_files_of_one_name_are_told_apart(written, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path / "checkout")
    files = {"own/mine.py": "import helper_of_both", "own/helper_of_both.py": "import mine", "checkout/mine.py": ""}
    assert list(written(files)) == ["mine.py", "helper_of_both.py", "../checkout/mine.py"]


def test_a_compiled_module_counts_by_its_bytes(written, tmp_path):
    compiled = f"fast{importlib.machinery.EXTENSION_SUFFIXES[0]}"
    before = written({"mine.py": "import fast", compiled: "one"})
    assert list(before) == ["mine.py", compiled]
    assert code.differences(before, written({"mine.py": "import fast", compiled: "two"})) == [compiled]


def test_nothing_of_a_file_is_run(written, capfd):
    written({"mine.py": "print(1)\nimport helper, pkg.inner", "helper.py": "print(2)", "pkg/__init__.py": "print(3)",
             "pkg/inner.py": "print(4)"})  # fmt: skip
    assert capfd.readouterr().out == ""


def test_an_installed_optimizer_counts_by_the_versions_of_its_package_and_its_library(monkeypatch):
    monkeypatch.setattr(code, "_is_installed", lambda spec: True)
    assert code.identity(load_optimizer("gwo")) == {"backlash-bench": version("backlash-bench")}
    both = {"backlash-bench": version("backlash-bench"), "cma": version("cma")}
    assert code.identity(load_optimizer("cma-es")) == both


def test_an_optimizer_of_a_checkout_counts_by_the_files_that_its_class_imports():
    found = code.identity(load_optimizer("gwo"))
    assert list(found) == ["optimizers/__init__.py", "optimizers/common/__init__.py", "optimizers/common/base.py",
                           "optimizers/gwo.py"]  # fmt: skip
    assert found["optimizers/gwo.py"] != code.identity(load_optimizer("alo"))["optimizers/alo.py"]


@pytest.mark.parametrize(
    ("name", "libraries"),
    [("cma-es", ["cma"]), ("scipy:shgo", ["scipy"]), ("mealpy:OriginalGWO", ["mealpy"]), ("pymoo:DE", ["pymoo"]),
     ("pymoo:CMAES", ["cma", "pymoo"]), ("nevergrad:DE", ["cma", "nevergrad"]), ("minion:LSHADE", ["minionpy"]),
     ("optuna:TPESampler", ["optuna"]), ("optuna:CmaEsSampler", ["cmaes", "optuna"])],
)  # fmt: skip
def test_every_wrapper_declares_its_libraries(name, libraries):
    found = code.identity(load_optimizer(name))
    assert [each for each in found if not each.endswith(".py")] == libraries
    assert all(found[library] == version(library) for library in libraries)


def test_modules_that_define_a_plugin_are_those_of_plugins_alone():
    assert code.defining([load_optimizer("hill-climber"), load_problem("sphere-2")]) == ["testing_plugins"]
    assert "optimizers.mealpy" in code.defining([load_optimizer("mealpy:OriginalGWO")])


@dataclass(frozen=True)
class Own(Optimizer):
    libraries = ("numpy",)
    fingerprint: ClassVar = {"program": "f00"}

    def minimize(self, objective, rng):
        pass


@pytest.mark.parametrize("libraries", ["numpy", ("pycma",), ("numpy", ""), (3,)])
def test_libraries_that_are_no_installed_packages_are_one_sentence(libraries, monkeypatch):
    monkeypatch.setattr(Own, "libraries", libraries)
    with pytest.raises(BenchError, match="the 'libraries' of Own must be names of packages that are installed here"):
        code.identity(Own())


def test_a_class_of_no_file_counts_by_what_it_declares(monkeypatch):
    monkeypatch.setattr(Own, "__module__", "__main__")
    assert code.identity(Own()) == {"numpy": version("numpy"), "program": "f00"}


MINE = """
from dataclasses import dataclass
from helper_of_walk import STEP
from optimizers.gwo import GWO

@dataclass(frozen=True)
class Mine(GWO):
    pass

def walk(objective, rng):
    pass
"""


@pytest.mark.parametrize("attribute", ["Mine", "walk"])
def test_a_function_and_a_derived_class_of_a_file_count_by_the_files(attribute, tmp_path, written):
    files = written({"mine.py": MINE, "helper_of_walk.py": "STEP = 1"})
    try:
        assert code.identity(load_optimizer(f"{tmp_path / 'mine.py'}:{attribute}")) == files
    finally:
        sys.modules.pop("helper_of_walk", None)
    assert {"mine.py", "helper_of_walk.py", "optimizers/gwo.py"} < files.keys()
