"""The jobs of a run share the open files that the system allows, in a process of its own with a low limit."""

import json
import subprocess
import sys

import pytest

pytest.importorskip("resource", reason="this system has no limit of open files")

TRY = """
import json, resource, sys
soft, hard, jobs = json.loads(sys.argv[1])
resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard or resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
from bench import BenchError
from bench.execution.local import require_files
try:
    require_files(jobs)
    print(resource.getrlimit(resource.RLIMIT_NOFILE)[0])
except BenchError as error:
    print(error)
"""

REFUSED = (
    "16 jobs need 2,752 open files, and this system allows a process 512; run 2 at a time (--jobs 2), or allow more "
    "(ulimit -Hn 2752)"
)


@pytest.mark.parametrize(
    ("soft", "hard", "jobs", "expected"),
    [(256, 0, 16, "2752"), (1024, 0, 1, "1024"), (512, 512, 16, REFUSED)],
    ids=["raised", "suffices", "refused"],
)
def test_the_soft_limit_is_raised_as_far_as_the_jobs_need_or_they_are_refused(soft, hard, jobs, expected):
    asked = json.dumps([soft, hard, jobs])
    done = subprocess.run([sys.executable, "-c", TRY, asked], capture_output=True, text=True, timeout=300, check=True)
    assert done.stdout.strip() == expected
