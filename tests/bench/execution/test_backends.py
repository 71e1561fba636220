import pytest

from bench import BenchError
from bench.execution.backends import open_pool


@pytest.mark.parametrize(
    ("backend", "scheduler", "sentence"),
    [
        ("docal", None, r"^unknown backend 'docal'.*'local'"),
        ("dask", None, "^the dask backend needs --scheduler"),
        ("local", "tcp://127.0.0.1:1", "no other backend takes one"),
    ],
)
def test_backends_that_cannot_be_opened_are_refused(backend, scheduler, sentence):
    with pytest.raises(BenchError, match=sentence):
        open_pool(backend, 1, scheduler)


def test_minus_one_job_is_one_for_each_core():
    with open_pool("local", -1, None) as every, open_pool("local", 3, None) as three:
        assert (every.jobs >= 1, three.jobs) == (True, 3)
