"""The sandbox: a stranger's optimizer can write nowhere, sees no other process and no network, and leaves nothing."""

import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from textwrap import dedent

import pandas as pd
import psutil
import pytest

from bench import BenchError, Results, Study, load_optimizer, load_results, run
from bench.check.bias import diagnose
from bench.check.conformance.subject import Subject
from bench.execution.job import MEMORY, TIMEOUT, Task, root, sandbox
from bench.execution.verify import verify
from bench.sandbox import bubblewrap, namespaces
from bench.sandbox.forks import ForkServer
from bench.sandbox.process import Process
from bench.storage.folder import SUMS

TIMES = ["wall_s", "cpu_s", "objective_s", "memory_mb", "study"]


def reason():
    """Why no sandbox can be used here, "" where one can."""
    try:
        bubblewrap.find()
    except BenchError as error:
        return str(error)
    return ""


REASON = reason()
needed = pytest.mark.skipif(bool(REASON), reason=REASON or "bubblewrap can be used")

ATTACKS = """
    import ctypes, os, resource, signal
    from pathlib import Path

    scratch, system = Path(os.environ["TMPDIR"]), ctypes.CDLL(None, use_errno=True)

    def attack(deed):
        def minimize(objective, rng):
            deed()
            while True:
                objective(objective.initial(4))
        return minimize

    def others():
        own = os.getpid(), int(os.readlink("/proc/self"))  # other numbers where /proc is that of the whole sandbox
        return [each for each in map(int, filter(str.isdigit, os.listdir("/proc"))) if each not in own]

    def refuse(condition, what):
        if condition:
            raise AssertionError(what)

    @attack
    def honest():
        pass

    @attack
    def kills():
        refuse({parent} in others() and b"pytest" in Path("/proc/{parent}/cmdline").read_bytes(), "it sees the run")
        for each in (-1, *others()):
            for number in (signal.SIGSTOP, signal.SIGKILL):
                try:
                    os.kill(each, number)
                except ProcessLookupError:
                    pass

    @attack
    def limits():
        for each in others():
            try:
                resource.prlimit(each, resource.RLIMIT_AS, (1 << 20, 1 << 20))
            except (ProcessLookupError, PermissionError):
                pass

    @attack
    def rewrites():
        for each in others():
            try:
                open(f"/proc/{{each}}/mem", "r+b").close()
            except OSError:
                continue
            raise AssertionError("it can write to the memory of another process")

    @attack
    def litters():
        refuse(os.listdir(scratch), "a file of another trial")
        (scratch / "left").mkdir(mode=0)
        os.chmod(scratch, 0)

    @attack
    def nests():
        refuse(os.listdir(scratch), "a folder of another trial")
        os.chdir(scratch)
        for _ in range(3000):
            os.mkdir("deeper")
            os.chdir("deeper")

    @attack
    def shares_memory():
        number = system.shmget(4242, 4096, 0o1600)
        refuse(number < 0, "it cannot have shared memory")
        system.shmat.restype = ctypes.c_void_p
        system.shmdt.argtypes = [ctypes.c_void_p]
        address = system.shmat(number, None, 0)
        place = ctypes.c_char.from_address(address)
        refuse(place.value != b"\\0", "memory of another trial")
        place.value = b"x"
        system.shmdt(address)
"""
HOLDS = """
    import mmap

    held = mmap.mmap(-1, 4096)  # which forks would share

    def holds(objective, rng):
        if held[0] > 1:  # after a warm-up in this process
            raise AssertionError("memory of another trial")
        held[0] += 1
        while True:
            objective(objective.initial(4))
"""
DEEDS = "honest", "kills", "limits", "rewrites", "litters", "nests", "shares_memory", "holds"


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A run in the sandbox of all of these beside an honest optimizer of the package, and the same one alone."""
    place = tmp_path_factory.mktemp("sandboxed")
    (place / "attacks.py").write_text(dedent(ATTACKS).format(parent=os.getpid()))
    (place / "holds.py").write_text(dedent(HOLDS))
    head = 'name = "s"\ntrials = 3\nbudget = 40\n[[problems]]\nname = "sphere-2"\n[[optimizers]]\nname = "scatter"\n'
    files = {name: "holds.py" if name == "holds" else "attacks.py" for name in DEEDS}
    attacks = "".join(f'[[optimizers]]\nname = "{place / file}:{name}"\n' for name, file in files.items())
    for name, text in (("alone", head), ("out", head + attacks)):
        (place / f"{name}.toml").write_text(text)
        run(place / f"{name}.toml", place / name, n_jobs=2, timeout=120, untrusted=name == "out")
    return place


@needed
@pytest.mark.slow
@pytest.mark.parametrize("deed", DEEDS)
def test_a_trial_finds_nothing_of_another_one_and_does_it_no_harm(ran, deed):
    frame = load_results(ran / "out")
    rows = frame[frame["optimizer"] == deed]
    assert list(rows["status"]) == ["ok"] * 3, list(rows["error"])


@needed
@pytest.mark.slow
def test_the_results_of_others_are_those_of_a_run_without_a_sandbox(ran):
    frames = [load_results(ran / each).drop(columns=TIMES) for each in ("out", "alone")]
    frames = [frame[frame["optimizer"] == "scatter"].reset_index(drop=True).astype(object) for frame in frames]
    pd.testing.assert_frame_equal(*frames, check_exact=True)


@needed
@pytest.mark.slow
def test_stored_trials_are_verified_in_the_sandbox(ran):
    found = verify(ran / "alone", trials=1, untrusted=True)
    assert found.different == {}
    assert "the problem in another process than the optimizer" in found.sentence
    (record,) = Results(ran / "out").environments
    assert (record["timeout"], record["sandbox"]) == (120, "bwrap")


FAMILIES = {"unix": 1, "inet": 2, "inet6": 10, "netlink": 16, "packet": 17, "alg": 38, "vsock": 40}
REFUSED = {
    "change a setting of the kernel": ("open('/proc/sys/kernel/core_pattern', 'r+')", "Read-only file system"),
    "drop the caches of the kernel": ("open('/proc/sys/vm/drop_caches', 'w')", "Read-only file system"),
    "pair datagrams": ("socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)", "not permitted"),
    "pair packets": ("socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)", "not permitted"),
    **{f"ask through {name}": (f"socket.socket({number}, 2)", "not permitted") for name, number in FAMILIES.items()},
    "set up a ring": ("refused(system.syscall(425, 1, 0))", "not permitted"),
    "enter a ring": ("refused(system.syscall(426, 0, 0, 0, 0, 0))", "not permitted"),
    "register a ring": ("refused(system.syscall(427, 0, 0, 0, 0))", "not permitted"),
    "read the variables of the first process": ("open('/proc/1/environ').read()", "denied|No such"),
    "store a key": ("refused(system.syscall(248, b'user', b'note', b'x', 1, -3))", "not permitted"),
    "write a file": ("open(folder + '/mark', 'w')", "Read-only|No such"),
    "write to the results": ("open(folder + '/out/trials.sqlite', 'r+b')", "Read-only|No such"),
    "read passwords": ("open('/etc/shadow').read()", "No such file"),
    "read the results": ("open(folder + '/out/trials.sqlite', 'rb')", "No such file"),
    "read the data of a problem": ("open(folder + '/data.csv')", "No such file"),
    "read the definition of a problem": ("open(checkout + '/problems/cec.py')", "No such file|denied"),
    "read the history of a checkout": ("os.listdir(checkout + '/.git')", "No such file|Not a directory"),
    "read reference results": ("os.listdir(checkout + '/results')", "No such file"),
    "read the documentation": ("os.listdir(checkout + '/docs')", "No such file"),
}
IMPORTS = "[__import__('sys').executable, '-c', 'import problems.backlash.signature.problem']"
NOTHING = {
    "read a problem in a file": "open(folder + '/mine/problem.py').read()",
    "find a secret in the environment": "os.environ.get('A_SECRET')",
    "find the problems of the study": "[*trial_process._study.problems]",
}


@pytest.fixture(scope="module")
def inside(tmp_path_factory):
    """A function that evaluates a text in a process of an optimizer that nobody trusts."""
    place = tmp_path_factory.mktemp("inside")
    for name, text in {
        "mine/problem.py": PROBLEM,
        "mine/late.py": HONEST,
        "data.csv": "1",
        "out/trials.sqlite": "",
    }.items():
        (place / name).parent.mkdir(exist_ok=True)
        (place / name).write_text(dedent(text))
    study = {"name": "s", "trials": 1, "budget": 10, "problems": [{"name": f"{place}/mine/problem.py:Bowl"}],
             "optimizers": [{"name": f"{place}/mine/late.py:late"}]}  # fmt: skip
    task = replace(Task.of(Study.from_dict(study), untrusted=True), output=str(place / "out"))
    head = f"""
        import ctypes, os, socket
        from bench.execution import trial_process
        folder, checkout = {str(place)!r}, {str(Path(__file__).parents[3])!r}
        system = ctypes.CDLL(None, use_errno=True)
        def refused(result):
            if result < 0:
                raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
        def tried(text):
            try:
                return str(eval(text, globals()))
            except Exception as error:
                return f"refused: {{error}}"
    """
    os.environ["A_SECRET"] = "a token"
    with root(task, without_problems=True) as server:
        del os.environ["A_SECRET"]
        process = server.process()

        def evaluate(text):
            code = f"(lambda place: (exec({dedent(head)!r}, place), place['tried']({text!r}))[1])({{}})"
            return process.call(eval, code, seconds=60.0)

        yield evaluate


@needed
def test_what_copies_of_a_copy_leave_is_waited_for():
    def ended():
        return [each for each in psutil.Process().children(recursive=True) if each.status() == psutil.STATUS_ZOMBIE]

    with ForkServer(sandbox=sandbox([])) as server:
        branch, before = server.branch(), len(ended())
        for _ in range(8):
            branch.process().close()
        assert len(ended()) <= before + 2  # one may be ending


HONEST = """
    def late(objective, rng):
        while True:
            objective(objective.initial(4))
"""
PROBLEM = """
    import numpy as np
    from bench import FunctionProblem
    def Bowl():
        return FunctionProblem(lambda x: (x**2).sum(), [-1] * 2, [1] * 2)
"""


@needed
@pytest.mark.parametrize("what", REFUSED)
def test_an_optimizer_cannot(inside, what):
    code, reason = REFUSED[what]
    assert re.search(f"refused: .*({reason})", inside(code))


@needed
@pytest.mark.parametrize("what", NOTHING)
def test_an_optimizer_does_not(inside, what):
    assert inside(NOTHING[what]).partition(":")[0] in ("None", "[]", "", "refused")


@needed
def test_a_process_that_an_optimizer_starts_finds_no_problem_either(inside):
    assert "ModuleNotFoundError: No module named" in inside(
        f"__import__('subprocess').run({IMPORTS}, capture_output=True)"
    )


TELLS = """
    import os
    def raises(objective, rng):
        raise ValueError("no luck")
    def crashes(objective, rng):
        os.write(2, b"a secret")
        os._exit(7)
"""


@needed
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "error"), [("raises", "ValueError: no luck"), ("crashes", "its process ended with exit code 7")]
)
def test_an_error_is_cut_to_its_message(tmp_path, name, error):
    (tmp_path / "mine.py").write_text(dedent(TELLS))
    study = {"name": "s", "trials": 1, "budget": 10, "problems": [{"name": "sphere-2"}],
             "optimizers": [{"name": f"{tmp_path}/mine.py:{name}"}]}  # fmt: skip
    run(Study.from_dict(study), tmp_path / "out", n_jobs=1, untrusted=True)
    assert [*load_results(tmp_path / "out")["error"]] == [error]


@needed
def test_the_scratch_folder_is_all_that_can_be_written():
    folders = ("/", "/dev", "/tmp", "/var/tmp", "/run", namespaces.SCRATCH)
    with Process(sandbox=bubblewrap.find()) as process:
        assert process.call(eval, f"[x for x in {folders} if __import__('os').access(x, 2)]", seconds=60.0) == [
            namespaces.SCRATCH
        ]


@needed
def test_the_package_that_a_file_imports_from_beside_it_can_be_read_there(tmp_path):
    (tmp_path / "package_of_mine").mkdir()
    (tmp_path / "package_of_mine" / "inner.py").write_text("WORD = 'read'")
    (tmp_path / "mine.py").write_text("def late():\n    import package_of_mine.inner")
    with Process(sandbox=sandbox([f"{tmp_path / 'mine.py'}:late"])) as process:
        script = f"open({str(tmp_path / 'package_of_mine' / 'inner.py')!r}).read()"
        assert process.call(eval, script, seconds=60.0) == "WORD = 'read'"


@pytest.mark.slow
@needed
def test_numba_reads_there_what_was_compiled_outside_and_writes_beside_it(tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text("from numba import njit\n@njit(cache=True)\ndef twice(x):\n    return 2 * x\n")
    monkeypatch.syspath_prepend(tmp_path)
    script = "import mine; mine.twice(1); print(sum(mine.twice.stats.cache_hits.values()))"
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    for _ in range(2):
        subprocess.run([sys.executable, "-c", script], env=environment, check=True)
    kernels = [*tmp_path.rglob("__pycache__/*.nb[ci]")]
    assert len(kernels) == 2
    with Process(sandbox=bubblewrap.find(shown=[tmp_path], kernels=kernels)) as process:
        for argument, hits in (("1", 1), ("1.5", 1)):
            code = f"[m := __import__('mine'), m.twice({argument})] and sum(m.twice.stats.cache_hits.values())"
            assert process.call(eval, code, seconds=60.0) == hits
    assert len([*tmp_path.rglob("__pycache__/*.nb[ci]")]) == 2


def test_without_bubblewrap_a_sentence_names_what_to_install(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda _: None)
    with pytest.raises(
        BenchError,
        match=r"^--untrusted needs bubblewrap .* install it \(on Debian",
    ):
        bubblewrap.find()


PEEPS = """
    import os

    open({mark!r}, "a").write("x")  # refused in the sandbox, so that the file does not load there

    def peeps(objective, rng):
        objective(objective.initial(4))
"""


@needed
@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        ("solve", "sphere-2", "{file}", "--budget", 40),
        ("check", "{file}", "--no-bias"),
        ("run", "quick", "--optimizer", "{file}", "--output", "{folder}/out"),
        ("run", "quick", "--optimizer", "{file}", "--output", "{folder}/out", "--dry-run"),
    ],
)
def test_no_command_loads_a_file_outside_it(bench_here, tmp_path, command):
    mark = tmp_path / "mark"
    (tmp_path / "mine.py").write_text(dedent(PEEPS).format(mark=str(mark)))
    words = [str(word).format(file=f"{tmp_path}/mine.py:peeps", folder=tmp_path) for word in command]
    done = bench_here(*words, "--untrusted")
    assert done.returncode != 0
    assert "Read-only file system" in done.stdout + done.stderr
    assert not mark.exists()


@needed
@pytest.mark.slow
def test_one_run_there_is_that_of_this_process(bench_here, shadows):
    command = ("solve", "beside.py:ball", "beside.py:stroll", "--budget", 40, "--seed", 7)
    here, there = (bench_here(*command, *flags, cwd=shadows).stdout for flags in ((), ("--untrusted",)))
    assert [*map(str.split, here.splitlines()[:-1])] == [*map(str.split, there.splitlines()[:-1])]  # but for the times
    assert not [*shadows.glob("*.imported")]


@needed
@pytest.mark.slow
def test_a_check_there_finds_what_another_does_and_keeps_the_problem_apart(bench_here, shadows):
    done = bench_here("check", "beside.py:stroll", "--untrusted", "--no-bias", cwd=shadows)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "passed: beside.py:stroll, problem apart: the problem and the budget" in done.stdout
    assert not [*shadows.glob("*.imported")]
    wrong = bench_here("check", "beside.py:stroll", "--untrusted", "--set", "stride=1", cwd=shadows)
    assert (wrong.returncode, wrong.stderr.count("\n")) == (2, 1)
    assert "stride" in wrong.stderr


@needed
@pytest.mark.slow
def test_biases_are_looked_for_there_too(shadows):
    sizes = {"dimension": 2, "runs": 1, "noise_runs": 3, "n_jobs": 1}
    found = diagnose(Subject("beside.py:stroll"), sandbox=sandbox(["beside.py:stroll"]), **sizes)
    assert found == diagnose(load_optimizer("beside.py:stroll"), **sizes)


@needed
@pytest.mark.slow
def test_a_folder_from_an_archive_is_run_verified_and_read_without_loading_its_files(bench_here, shadows):
    study = {"name": "s", "trials": 1, "budget": 30, "problems": [{"name": "beside.py:ball"}],
             "optimizers": [{"name": "beside.py:stroll"}]}  # fmt: skip
    run(Study.from_dict(study), "out", n_jobs=1)
    assert load_problem_of("out") is not None
    Path("out", SUMS).touch()  # as 'bench unpack' leaves it
    for command in (("run", "out/study.toml", "-o", "out"), ("verify", "out")):
        done = bench_here(*command, cwd=shadows)
        assert (done.returncode, done.stdout) == (2, "")
        assert "names 'beside.py:ball', whose code nobody trusts: add --untrusted" in " ".join(done.stderr.split())
    assert bench_here("verify", "out", "--untrusted", "--jobs", 1, cwd=shadows).returncode == 0
    with pytest.raises(BenchError, match="code that nobody trusts"):
        load_problem_of("out")
    assert Results("out").facts("ball").reason


def load_problem_of(folder):
    return Results(folder).problem("ball")


def test_limits_given_replace_those_by_default(small_study):
    assert (Task(small_study).timeout, Task(small_study).memory, Task(small_study).apart) == (None, None, False)
    bounded = Task(small_study, untrusted=True)
    assert (bounded.timeout, bounded.memory, bounded.apart) == (TIMEOUT, MEMORY, True)
    given = Task(small_study, timeout=5.0, memory=10**9, untrusted=True)
    assert (given.timeout, given.memory) == (5.0, 10**9)
