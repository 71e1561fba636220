"""Worker processes: answers in order, a death costs one item, Ctrl-C and the parent's death leave nothing behind."""

import math
import os
import re
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import psutil
import pytest

from problems.backlash.sensor import workers
from problems.backlash.sensor.workers import FORKS, in_workers

forks = pytest.mark.skipif(not FORKS, reason="a test's functions cannot be sent to a worker that is not forked")


@pytest.fixture(params=["fork", "spawn"])
def kind(request, monkeypatch):
    """Fork the workers, or start them anew; their functions then need a module that can be imported."""
    if request.param == "fork" and not FORKS:
        pytest.skip("forking is not safe here")
    monkeypatch.setattr(workers, "FORKS", request.param == "fork")


def lost(item):
    return item, "lost"


def negated(item):
    if item % 3 == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return -item


def inverse(item):
    return 1 // item


def process_of(item, folder):
    if item:
        (folder / str(item)).touch()
    while not item and len(list(folder.iterdir())) < 3:  # the first ends after the others
        time.sleep(0.01)
    return os.getpid()


def children():
    return psutil.Process().children(recursive=True)


def test_workers_import_nothing_of_the_working_folder(kind, tmp_path, monkeypatch):
    (tmp_path / "random.py").write_text("open('imported', 'w').close()\n")  # which multiprocessing itself imports
    monkeypatch.chdir(tmp_path)
    assert list(in_workers(math.factorial, [3], 1, lost)) == [6]
    assert not Path("imported").exists()
    assert "PYTHONSAFEPATH" not in os.environ


@pytest.mark.parametrize("jobs", [1, 2, 9])
def test_answers_come_in_the_order_of_their_items(kind, jobs):
    items = [5, 3, 8, 1]
    assert list(in_workers(math.factorial, items, jobs, lost)) == [120, 6, 40320, 1]
    assert list(in_workers(math.factorial, [], jobs, lost)) == []


def test_an_item_that_ends_its_process_costs_itself_only(kind):
    assert list(in_workers(os._exit, [3, 0, 4], 2, lost)) == [(code, "lost") for code in (3, 0, 4)]


@forks
def test_other_items_are_answered_after_a_death():
    expected = [lost(item) if item % 3 == 0 else -item for item in range(10)]
    assert list(in_workers(negated, list(range(10)), 2, lost)) == expected


@forks
def test_an_exception_of_the_work_is_raised():
    with pytest.raises(ZeroDivisionError):
        list(in_workers(inverse, [0, 1], 1, lost))


@forks
def test_items_are_made_at_once_and_slow_ones_hold_no_others_back(tmp_path):
    first, *others = in_workers(partial(process_of, folder=tmp_path), [0, 1, 2, 3], 2, lost)
    assert len(set(others)) == 1
    assert first not in others


def test_no_process_stays_when_the_answers_are_not_all_taken(kind):
    before = set(children())
    answers = in_workers(math.factorial, list(range(50)), 2, lost)
    assert next(answers) == 1
    assert len(set(children()) - before) >= 2  # multiprocessing keeps one of its own beside spawned ones
    answers.close()
    assert not [each for each in set(children()) - before if "resource_tracker" not in " ".join(each.cmdline())]


SCRIPT = """if True:
    import os, sys, time
    from problems.backlash.sensor.workers import in_workers

    def work(item):
        os.write(1, b"%d\\n" % item)
        time.sleep(600)

    try:
        list(in_workers(work, [1, 2, 3], 2, None))
    except KeyboardInterrupt:
        sys.exit(130)
"""


@pytest.fixture
def script():
    """A process of its own with two workers that are busy for ten minutes; yield it and the workers."""
    with subprocess.Popen(
        [sys.executable, "-c", SCRIPT],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        assert sorted(process.stdout.readline() for _ in range(2)) == ["1\n", "2\n"]
        yield process, psutil.Process(process.pid).children()
        process.kill()


@forks
def test_an_interrupt_ends_everything_without_a_word(script):
    process, busy = script
    assert len(busy) == 2
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    assert process.wait(120) == 130
    assert process.stderr.read() == ""
    assert not psutil.wait_procs(busy, timeout=120)[1]


@pytest.mark.slow
@forks
def test_workers_end_with_a_parent_that_is_killed(script):
    process, busy = script
    process.kill()
    assert not psutil.wait_procs(busy, timeout=120)[1]
    assert not re.search("Traceback", process.stderr.read())
