"""The jobs of a run share the open files that the system allows, in a process of its own with a low limit."""

import subprocess
import sys

import pytest

resource = pytest.importorskip("resource", reason="this system has no limit of open files")
TRY = """
import resource
from bench.execution.local import BenchError, require_files
resource.setrlimit(resource.RLIMIT_NOFILE, ({}, {} or resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
try:
    require_files({})
    print(resource.getrlimit(resource.RLIMIT_NOFILE)[0])
except BenchError as error:
    print(error)
"""
REFUSED = "16 jobs need 4,800 open files, and this system allows a process 512; run 1 at a time (--jobs 1)"


@pytest.mark.parametrize(
    ("limits", "expected"), [((256, 0, 8), "2432"), ((1024, 0, 1), "1024"), ((512, 512, 16), REFUSED)]
)
def test_the_soft_limit_is_raised_as_far_as_the_jobs_need_or_they_are_refused(limits, expected):
    done = subprocess.run([sys.executable, "-c", TRY.format(*limits)], capture_output=True, text=True, check=True)
    assert done.stdout.startswith(expected)
