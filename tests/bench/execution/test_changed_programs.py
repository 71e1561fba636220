"""Changes of programs, as optimizers and as problems: each is named, or found by a trial that is made again."""

import os
import sys
from dataclasses import dataclass, field

import pytest

from bench import BenchError, Study, load_results, run
from bench.execution.runner import plan
from tests.bench.made import Heard

CLIMB = """
import json, sys, os
HERE = os.path.dirname(os.path.abspath(__file__))
{code}
about = json.loads(sys.stdin.readline())
share = {share}
ends = zip(about["lower"], about["upper"])
print(json.dumps({{"x": [[low + share * (high - low) for low, high in ends]]}}), flush=True)
sys.stdin.readline()
print(json.dumps({{"stop": "done"}}), flush=True)
"""


@dataclass(frozen=True)
class Program:
    """A program that changes.

    Attributes:
        words: of its command; files among them stand in its folder.
        before: its files.
        after: those that change, with what they hold then.
        named: what the run names; "" where a trial that is made again finds it.
        files: what the study names beside it.
    """

    words: tuple
    before: dict
    after: dict
    named: str = ""
    files: tuple = ()
    options: dict = field(default_factory=dict)


BOX = {"lower": [0, 0], "upper": [1, 1]}
CAT = 'cat "$(dirname "$0")/'
PROBLEMS = {
    "script": Program(("sh", "a.sh"), {"a.sh": "echo 1"}, {"a.sh": "echo 2"}, "a.sh"),
    "comment that a shell reads": Program(("sh", "a.sh"), {"a.sh": "echo 1"}, {"a.sh": "echo 1 # x"}, "a.sh"),
    "executable": Program(("./a.sh",), {"a.sh": "#!/bin/sh\necho 1\n"}, {"a.sh": "#!/bin/sh\necho 2\n"}, "a.sh"),
    "word that is a file": Program(("sh", "-c", 'cat "$0"', "v.txt"), {"v.txt": "1"}, {"v.txt": "2"}, "v.txt"),
    "option that is a file": Program(
        ("sh", "a.sh", "--data=v.txt"), {"a.sh": 'cat "${1#*=}"', "v.txt": "1"}, {"v.txt": "2"}, "v.txt"
    ),
    "script beside": Program(
        ("sh", "a.sh"), {"a.sh": '. "$(dirname "$0")/b.sh"', "b.sh": "echo 1"},
        {"b.sh": "echo 2"}, "b.sh",
    ),
    "helper in Python": Program(
        (sys.executable, "a.py"), {"a.py": "from b import V\nprint(V)", "b.py": "V = 1"}, {"b.py": "V = 2"}, "b.py"
    ),
    "files": Program(("sh", "a.sh"), {"a.sh": f'{CAT}v.dat"', "v.dat": "1"}, {"v.dat": "2"}, "v.dat", ("v.dat",)),
    "files by a pattern": Program(
        ("sh", "a.sh"), {"a.sh": f'{CAT}data/v.dat"', "data/v.dat": "1"},
        {"data/v.dat": "2"}, "data/v.dat", ("data/*.dat",)
    ),
    "a file more of a pattern": Program(
        ("sh", "a.sh"), {"a.sh": 'cat "$(dirname "$0")"/data/*.dat | tail -1', "data/a.dat": "1\n"},
        {"data/b.dat": "2\n"},
        "the files", ("data/*.dat",),
    ),
    "a folder of files": Program(
        ("sh", "a.sh"), {"a.sh": f'{CAT}data/deep/v.dat"', "data/deep/v.dat": "1"}, {"data/deep/v.dat": "2"},
        "data/deep/v.dat", ("data/**",),
    ),
    "a file that no one names": Program(("sh", "a.sh"), {"a.sh": f'{CAT}v.dat"', "v.dat": "1"}, {"v.dat": "2"}),
    "a variable": Program(("sh", "a.sh"), {"a.sh": "echo ${BENCH_TEST_PROGRAM:-1}"}, {"BENCH_TEST_PROGRAM": "2"}),
}  # fmt: skip


def climb(code="", share="SHARE", **files):
    return {"climb.py": CLIMB.format(code=code, share=share)} | {
        name.replace("_", "."): text for name, text in files.items()
    }


RUN = (sys.executable, "climb.py")
OPTIMIZERS = {
    "constant": Program(RUN, climb("SHARE = 0.25"), climb("SHARE = 0.75"), "climb.py"),
    "module": Program(RUN, climb("from h import SHARE", h_py="SHARE = 0.25"), {"h.py": "SHARE = 0.75"}, "h.py"),
    "exec": Program(
        RUN, climb("exec(open(HERE + '/h.py').read())", h_py="SHARE = 0.25"),
        {"h.py": "SHARE = 0.75"}, "h.py",
    ),
    "argument": Program(
        (*RUN, "v.txt"), climb(share="float(open(sys.argv[1]).read())", v_txt="0.25"), {"v.txt": "0.75"}, "v.txt"
    ),
    "files": Program(
        RUN, climb(share="float(open(HERE + '/w.bin').read())", w_bin="0.25"), {"w.bin": "0.75"}, "w.bin", ("w.bin",)
    ),
    "files in json": Program(
        RUN, climb(share="json.load(open(HERE + '/w.json'))", w_json="0.25"), {"w.json": "0.75"}, "w.json", ("*.json",)
    ),
    "undeclared": Program(RUN, climb(share="float(open(HERE + '/w.bin').read())", w_bin="0.25"), {"w.bin": "0.75"}),
    "variable": Program(
        RUN, climb(share="float(os.environ.get('BENCH_TEST_CLIMB', '0.25'))"), {"BENCH_TEST_CLIMB": "0.75"}
    ),
    "wrapper": Program(
        ("sh", "run.sh"),
        climb("SHARE = 0.25") | {"run.sh": f'exec {sys.executable} "$(dirname "$0")/climb.py"'}, climb("SHARE = 0.75"),
        "climb.py",
    ),
    "deeper": Program(
        RUN, climb("from lib.h import SHARE") | {"lib/__init__.py": "", "lib/h.py": "SHARE = 0.25"},
        {"lib/h.py": "SHARE = 0.75"}, "lib/h.py", ("lib/*.py",),
    ),
    "deeper and undeclared": Program(
        RUN, climb("from lib.h import SHARE") | {"lib/__init__.py": "", "lib/h.py": "SHARE = 0.25"},
        {"lib/h.py": "SHARE = 0.75"}
    ),
    "docstring": Program(RUN, climb("SHARE = len('abc') / 9"), climb("SHARE = len('abcd') / 9"), "climb.py"),
    "default": Program(
        RUN, climb("def f(x=0.25):\n    return x", "f()"), climb("def f(x=0.5):\n    return x", "f()"), "climb.py"
    ),
}  # fmt: skip


def write(folder, files):
    for name, text in files.items():
        if name.startswith("BENCH_TEST"):
            os.environ[name] = text
            continue
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)


def entry(folder, name, program, key):
    write(folder, program.before)
    words = [str(folder / word) if (folder / word).is_file() else word for word in program.words]
    words = [word.replace("=v.txt", f"={folder}/v.txt") for word in words]
    about = {"label": name, "files": [str(folder / file) for file in program.files]}
    if key == "problems":
        return {"problem": words, **BOX, **about}
    return {"name": "command", "command": words, **about}


def said_of(folder, programs, key):
    """Run a study of these programs and change them; return what the plan says, and what is found by a trial again."""
    entries = [entry(folder / str(n), name, each, key) for n, (name, each) in enumerate(programs.items())]
    others = {"problems": ["sphere-2"], "optimizers": ["scatter"]}
    study = Study.from_dict({"name": "s", "trials": 1, "budget": 20} | others | {key: entries})
    assert run(study, folder / "out", n_jobs=2, verify=False).failed == 0
    assert plan(study, folder / "out").notes == []
    for n, program in enumerate(programs.values()):
        write(folder / str(n), program.after)
    notes = plan(study, folder / "out").notes
    lines = run(study.override(trials=2), folder / "out", n_jobs=2, verify=False).doubtful
    return {
        name: next((note for note in notes if note.startswith(f"{name} changed (")), "") for name in programs
    }, lines


@pytest.fixture(scope="module")
def changed(tmp_path_factory):
    yield {
        key: said_of(tmp_path_factory.mktemp(key), programs, key)
        for key, programs in (("problems", PROBLEMS), ("optimizers", OPTIMIZERS))
    }
    for name in ("BENCH_TEST_PROGRAM", "BENCH_TEST_CLIMB"):
        os.environ.pop(name, None)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "name"), [("problems", name) for name in PROBLEMS] + [("optimizers", name) for name in OPTIMIZERS]
)
def test_it_is_named_or_found(key, name, changed):
    program = {"problems": PROBLEMS, "optimizers": OPTIMIZERS}[key][name]
    said, lines = changed[key]
    if program.named:
        assert program.named in said[name].partition("):")[0], said[name]
    else:
        assert any(name in line for line in lines), lines


def test_a_program_that_changes_during_a_run_ends_its_trials_with_a_sentence(tmp_path):
    program = Program(("sh", "a.sh"), {"a.sh": "echo 1", "w.dat": "1"}, {}, files=("w.dat",))
    problems = [entry(tmp_path / "p", "one", program, "problems")]
    study = Study.from_dict({"name": "s", "trials": 3, "budget": 20, "problems": problems, "optimizers": ["scatter"]})

    def edit(trial, row):
        (tmp_path / "p" / "w.dat").write_text("2")

    outcome = run(study, tmp_path / "out", n_jobs=1, verify=False, progress=Heard(edit))
    assert outcome.failed >= 1
    errors = load_results(tmp_path / "out")["error"].dropna()
    assert errors.str.contains("w.dat changed while the study ran, so no trial is made with it").all()
    assert run(study, tmp_path / "out", n_jobs=1, verify=False).failed == 0


@pytest.mark.parametrize(("files", "said"), [("w.dat", "must be a list of files"), ([3], "must be a list of files")])
def test_files_are_a_list(files, said):
    with pytest.raises(BenchError, match=said):
        Study.from_dict({"name": "s", "problems": ["sphere-2"], "optimizers": [{"name": "scatter", "files": files}]})


def test_files_that_are_not_there_are_named(tmp_path):
    optimizers = [{"name": "scatter", "files": [str(tmp_path / "no.dat")]}]
    about = {"name": "s", "trials": 1, "budget": 20, "problems": ["sphere-2"]}
    study = Study.from_dict(about | {"optimizers": optimizers})
    run(study, tmp_path / "out", n_jobs=1, verify=False)
    assert load_results(tmp_path / "out")["error"].str.contains("'files' names .*no.dat', and there is no such").all()
