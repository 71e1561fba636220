import threading
import time
from itertools import count

import pytest

from bench.execution.job import Task
from bench.execution.local import Local
from bench.execution.supervisor import KilledError, Loaded
from bench.plugins.inputs import Present
from bench.storage.provenance import memory


class Supervisor:
    """Makes trials, which are numbers, at once; those from 100 on wait until they are killed."""

    def __init__(self, task):
        self._killed = threading.Event()

    def load(self):
        return Loaded({}, Present(), "machine", {})

    def make(self, trial):
        if trial == 13:
            raise ZeroDivisionError
        if trial >= 100:
            self._killed.wait()
            raise KilledError
        return {"fun": trial}

    def kill(self):
        self._killed.set()


@pytest.fixture
def local(small_study):
    before = set(threading.enumerate())

    def made(jobs, missing, on_begin=None):
        pool = Local(jobs, Supervisor)
        pool.load(Task(small_study))
        return pool.answers(on_begin, missing)

    yield made
    for thread in set(threading.enumerate()) - before:
        thread.join(10.0)
        assert not thread.is_alive()


@pytest.mark.parametrize("jobs", [1, 3])
class TestLocal:
    def test_every_trial_is_answered_once_with_the_machine(self, local, jobs):
        begun = []
        answers = list(local(jobs, lambda: range(10), lambda *each: begun.append(each)))
        assert Local(jobs).share == pytest.approx(0.9 * memory() / jobs, rel=1e-6)
        assert sorted(trial for _, trial in begun) == list(range(10))
        assert {job for job, _ in begun} <= set(range(jobs))
        assert sorted(answers, key=lambda each: each[0]) == [(i, {"fun": i}, "machine") for i in range(10)]

    def test_one_thread_at_a_time_notes_what_it_begins(self, local, jobs):
        noting = threading.Lock()

        def note(job, trial):
            assert noting.acquire(blocking=False)
            time.sleep(0.001)
            noting.release()

        assert len(list(local(jobs, lambda: range(10), note))) == 10

    def test_an_error_reaches_the_run(self, local, jobs):
        with pytest.raises(ZeroDivisionError):
            list(local(jobs, lambda: range(10, 20)))

    def test_a_run_that_is_given_up_ends_the_trials_under_way(self, local, jobs):
        answers = local(jobs, lambda: count(99))
        assert next(answers)[0] == 99
        answers.close()
