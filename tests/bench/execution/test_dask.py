"""Many machines: a real dask scheduler and real workers on loopback, some of which are killed."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from bench import BenchError, FunctionProblem, Results, Study, load_results, run
from bench.execution import dask as cluster
from bench.execution import dask_worker
from bench.execution.supervisor import Task, WorkerDiedError
from tests.bench.made import Heard
from tests.bench.sandbox.helpers import hear_interrupts

distributed = pytest.importorskip("distributed", reason="the optional extra 'dask' is not installed")

PATIENCE = 90  # seconds; ends a test that hangs, and decides nothing else
HANG = """
import os, time

def hang(objective, rng):
    objective(objective.initial(1))
    with open({path!r}, "w") as file:
        file.write(f"{{os.getpid()}}\\n")
    time.sleep(3600)
"""
KILL = """
import psutil

def kill(objective, rng):
    with open({path!r}, "a+") as file:
        if file.tell() < {times}:
            file.write("x")
            file.flush()
            next(each for each in psutil.Process().parents() if "bench.sandbox" not in str(each.cmdline())).kill()
    while True:
        objective(objective.initial(1))
"""


def until(true, what, patience=PATIENCE):
    deadline = time.monotonic() + patience
    while not (value := true()):
        assert time.monotonic() < deadline, f"waited {patience} s for {what}"
        time.sleep(0.05)
    return value


def is_alive(process):
    try:
        return process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


class Machines:
    """A scheduler and its workers, each a process of its own."""

    def __init__(self, folder, allowed_failures):
        self.folder, self.processes = folder, []
        self.scheduler = self._start(
            "scheduler", "--host", "127.0.0.1", "--port", "0", file := folder / "scheduler",
            environment={"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": str(allowed_failures)},
        )  # fmt: skip
        self.address = until(lambda: file.exists() and _address(file), "the scheduler")

    def _start(self, what, *arguments, environment=None, cores=None):
        file = ["--scheduler-file"] if what == "scheduler" else []
        module, last = f"distributed.cli.dask_{what}", arguments[-1]
        command = [sys.executable, "-P", "-m", module, "--no-dashboard", *arguments[:-1], *file, last]
        with (self.folder / f"{what}.log").open("ab") as log:
            process = subprocess.Popen(
                list(map(str, command)), stdout=log, stderr=log, start_new_session=True, cwd=self.folder,
                env=os.environ | (environment or {}),
                preexec_fn=(lambda: os.sched_setaffinity(0, cores)) if cores else None,
            )  # fmt: skip
        self.processes.append(process)
        return process

    def worker(self, name, threads=1, *, nanny="--no-nanny", **options):
        arguments = [nanny, "--nthreads", threads, "--name", name, "--local-directory", self.folder / name]
        return self._start("worker", *arguments, self.address, **options)

    def registered(self, number):
        log = self.folder / "scheduler.log"
        until(lambda: log.read_text().count("Register worker") >= number, f"{number} workers")

    def run(self, study, output, **options):
        return run(study, output, backend="dask", scheduler=self.address, **options)

    def close(self):
        for process in self.processes:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def _address(file):
    text = file.read_text()
    return text.partition('"address": "')[2].partition('"')[0]


@pytest.fixture
def machines(tmp_path, monkeypatch, request):
    """Start a scheduler; a parameter is the number of workers that a trial may lose before dask gives it up."""
    monkeypatch.setattr(cluster, "RETURN", PATIENCE)  # a test that loses more than it means to shall end
    folder = tmp_path / "machines"
    folder.mkdir()
    started = Machines(folder, getattr(request, "param", 3))
    yield started
    started.close()


def study_of(optimizer, folder, code, trials):
    """Return a study of one optimizer, whose code is written to a file."""
    (folder / "mine.py").write_text(code)
    return Study.from_dict(
        {"name": "mine", "trials": trials, "budget": 30, "problems": [{"name": "sphere-2"}],
         "optimizers": [{"name": f"{folder}/mine.py:{optimizer}"}]}
    )  # fmt: skip


def slow_study(trials):
    return Study.from_dict(
        {"name": "slow", "trials": trials, "budget": 40, "seed": 3, "problems": [{"names": ["slow-2", "sphere-3"]}],
         "optimizers": [{"name": "hill-climber"}, {"name": "scatter"}]}
    )  # fmt: skip


@pytest.mark.slow
def test_functions_and_classes_travel_to_the_workers_by_value(machines, tmp_path):
    machines.worker("one")
    goal = 0.25

    def draw(objective, rng):
        while True:
            objective(objective.initial(1))

    def study(trials):
        problem = FunctionProblem(lambda x: ((x - goal) ** 2).sum(), [0, 0], [1, 1], name="distance")
        return {"name": "s", "trials": trials, "budget": 30, "problems": [problem], "optimizers": [draw]}

    assert machines.run(study(2), tmp_path / "dask").made == 2
    assert run(study(3), tmp_path / "dask", n_jobs=1).made == 1  # the cells are the same here and there
    assert load_results(tmp_path / "dask")["status"].eq("ok").all()


@pytest.mark.slow
def test_a_run_that_loses_a_worker_ends_with_the_frame_of_one_machine(machines, tmp_path, capfd):
    core = min(os.sched_getaffinity(0))
    meeting = tmp_path / "meeting"  # neither worker makes many trials before the other one has begun
    meeting.mkdir()
    workers = [
        machines.worker("one", threads=2, environment={"MEETING": str(meeting)}),
        machines.worker("two", cores={core}, environment={"MEETING": str(meeting)}),
    ]
    machines.registered(2)
    cores, made = {}, []

    def kill_one(trial, row):
        made.append(trial.key)
        cores.update({record["cores"]: record for record in Results(tmp_path / "dask").environments})
        if len(cores) == len(workers) == len(list(meeting.iterdir())) == 2:
            os.killpg(workers.pop().pid, signal.SIGKILL)

    study = slow_study(10)
    assert machines.run(study, tmp_path / "dask", progress=Heard(kill_one)).made == 40
    assert len(workers) == 1, "both workers made trials before one was killed"
    assert sorted(made) == sorted(trial.key for trial in study.plan())
    record = cores[1]
    assert (record["backend"], record["jobs"]) == ("dask", 3)
    run(study, tmp_path / "local", n_jobs=2)
    times = ["wall_s", "cpu_s", "objective_s", "memory_mb"]
    assert load_results(tmp_path / "dask")["status"].eq("ok").all()
    frames = [load_results(tmp_path / each).drop(columns=times) for each in ("dask", "local")]
    assert frames[0].equals(frames[1])
    assert capfd.readouterr().err == ""


@pytest.mark.slow
def test_a_run_whose_scheduler_is_lost_ends_with_a_sentence_and_goes_on_later(machines, tmp_path, capfd):
    machines.worker("one")

    def kill(trial, row):
        machines.scheduler.kill()

    with pytest.raises(WorkerDiedError, match=rf"^the scheduler {machines.address} is gone.* run the same command"):
        machines.run(slow_study(10), tmp_path / "out", progress=Heard(kill))
    kept = len(load_results(tmp_path / "out"))
    assert 0 < kept < 40
    assert run(slow_study(10), tmp_path / "out", n_jobs=2).made == 40 - kept
    assert capfd.readouterr().err == ""


@pytest.mark.slow
def test_a_cluster_that_loses_all_its_workers_is_not_waited_for_for_ever(machines, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "RETURN", 0.5)
    worker = machines.worker("one")
    processes = []

    def kill(trial, row):
        if not processes:
            processes.extend(psutil.Process(worker.pid).children(recursive=True))
            os.killpg(worker.pid, signal.SIGKILL)

    with pytest.raises(WorkerDiedError, match=r"no workers for .* minutes; every finished trial is kept"):
        machines.run(slow_study(20), tmp_path / "out", progress=Heard(kill))
    assert len(load_results(tmp_path / "out")) > 0
    assert processes
    until(lambda: not any(map(is_alive, processes)), "the trial processes of the killed worker to end")


@pytest.mark.slow
@pytest.mark.parametrize("machines", [0], indirect=True)
@pytest.mark.parametrize(("times", "ends"), [(2, False), (3, True)])
def test_the_third_worker_in_a_row_that_is_killed_ends_the_run(times, ends, machines, tmp_path):
    code = KILL.format(path=str(tmp_path / "kills"), times=times)
    machines.worker("one", nanny="--nanny")
    if ends:
        with pytest.raises(WorkerDiedError, match=r"^3 worker processes in a row were killed .* run the same command"):
            machines.run(study_of("kill", tmp_path, code, 3), tmp_path / "out")
    else:
        assert machines.run(study_of("kill", tmp_path, code, 3), tmp_path / "out").made == 3
        assert load_results(tmp_path / "out")["status"].eq("ok").all()
    assert (tmp_path / "kills").stat().st_size == times


@pytest.mark.slow
def test_idle_and_unwanted_trial_processes_end(monkeypatch, tmp_path):
    monkeypatch.setattr(dask_worker, "LOOK", 0.1)
    monkeypatch.setattr(dask_worker, "IDLE", 0.5)
    monkeypatch.setenv("GATE", str(tmp_path / "gate"))  # for which the trial of the slow problem waits
    study = slow_study(1)
    task, trials = Task(study), {trial.problem: trial for trial in study.plan()}
    before = set(psutil.Process().children())

    def started():
        return set(psutil.Process().children()) - before

    one_thread = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.Client(processes=False, **one_thread) as client:

        def submit(problem):
            return client.submit(dask_worker.work, "run", task, trials[problem], pure=False)

        first, _ = submit("sphere-3").result()
        kept = started()
        second, _ = submit("sphere-3").result()
        assert first["fun"] == second["fun"]
        assert started() == kept, "the second trial starts no process"
        until(lambda: not started(), "the idle processes to end")
        unwanted = submit("slow-2")
        until(started, "its process")
        unwanted.cancel()
        until(lambda: not started(), "the unwanted process to end")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "change"), [("contract/seeds.py", "\n"), ("execution/dask_worker.py", "\nwork = None\n")]
)
def test_a_worker_with_other_code_is_refused_by_name_first_or_last(module, change, machines, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(Path(cluster.__file__).parents[1], copy / "bench", ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "bench" / module).open("a").write(change)
    path = os.pathsep.join([str(copy), os.environ["PYTHONPATH"]])
    said = r"^the worker tcp://127\.0\.0\.1:\d+ \(stranger on .*\) runs backlash-bench .*code .*, this process .*code "
    machines.worker("one")
    strangers = []

    def join(trial, row):
        if not strangers:
            strangers.append(machines.worker("stranger", threads=4, environment={"PYTHONPATH": path}))
            machines.registered(2)

    with pytest.raises(BenchError, match=said):
        machines.run(slow_study(100), tmp_path / "late", progress=Heard(join))
    assert len(load_results(tmp_path / "late")) > 0
    with pytest.raises(BenchError, match=said):
        machines.run(slow_study(1), tmp_path / "early")
    assert not (tmp_path / "early").exists()


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_nothing_is_left_on_the_workers_when_the_run_is_ended(number, machines, tmp_path):
    machines.worker("one")
    running = tmp_path / "running"
    study = tmp_path / "study.toml"
    study.write_text(study_of("hang", tmp_path, HANG.format(path=str(running)), 3).to_toml())
    command = [sys.executable, "-m", "bench", "run", study, "--backend", "dask", "--scheduler", machines.address]
    pipes = {"stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen(list(map(str, command)), cwd=tmp_path, preexec_fn=hear_interrupts, **pipes)
    try:
        pid = int(until(lambda: running.exists() and running.read_text().strip(), "the trial"))
        os.kill(process.pid, number)
        said = process.communicate(timeout=PATIENCE)[1]
    finally:
        process.kill()
    if number == signal.SIGINT:
        assert process.returncode == 130
        assert said.count("\n") == 1
        assert said.startswith("bench: interrupted")
    until(lambda: not psutil.pid_exists(pid), "the trial's process to end")
    worker = psutil.Process(machines.processes[-1].pid)
    until(lambda: not worker.children(), "the worker's processes to end")
    assert worker.is_running()


@pytest.mark.parametrize("address", ["nonsense", "tls://127.0.0.1:1", "tcp://", "ftp://127.0.0.1:1", "a b\n", "", " "])
def test_an_address_without_a_scheduler_is_refused(address, monkeypatch, capfd):
    monkeypatch.setattr(cluster, "CONNECT", 0.5)
    with pytest.raises(BenchError, match="dask scheduler"), cluster.cluster(address):
        pass
    assert capfd.readouterr() == ("", "")


def test_a_busy_scheduler_at_which_dask_s_own_check_fails_is_asked_once_more():
    asked = []

    def client(address, **options):
        asked.append(address)
        assert len(asked) > 1
        return "connected"

    assert cluster._connect(client, "tcp://busy:1") == "connected"
    asked.clear()
    with pytest.raises(BenchError, match="no dask scheduler answers"):
        cluster._connect(lambda *_, **__: asked[0], "tcp://none:1")


@pytest.mark.slow
def test_a_server_that_says_nothing_is_one_sentence_of_the_command(bench_here, small_study, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "CONNECT", 0.5)
    (tmp_path / "small.toml").write_text(small_study.to_toml())
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        done = bench_here("run", "small.toml", "--backend", "dask", "--scheduler", address, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"bench: no dask scheduler answers at '{address}'")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "results").exists()


def test_a_cluster_without_workers_and_a_missing_extra_are_said_so(machines, small_study, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "ARRIVE", 0.2)
    with pytest.raises(BenchError, match=rf"at {machines.address} has no workers; start some with 'dask worker tcp:"):
        machines.run(small_study, tmp_path / "out")
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(BenchError, match=r"pip install 'backlash-bench\[dask\]'"):
        machines.run(small_study, tmp_path / "out")
