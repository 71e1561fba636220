"""The jobs of a run share the open files that the system allows, in a process of its own with a low limit."""

import json
import subprocess
import sys

import pytest

pytest.importorskip("resource", reason="this system has no limit of open files")

RUN = """
import json, resource, sys
soft, hard, jobs, optimizers, trials, families, output = json.loads(sys.argv[1])
most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard or most))
from bench import BenchError, Study, run
from bench.execution.local import kept
study = Study.from_dict({
    "name": "many", "trials": trials, "budget": 40,
    "problems": [{"name": name} for name in ("sphere-2", "classical-rastrigin-d2-i1")[:families]],
    "optimizers": [{"name": "scatter", "label": f"s{number}", "agents": 2 + number} for number in range(optimizers)],
})
try:
    kept = kept(jobs)
    failed = run(study, output, n_jobs=jobs).failed if output else None
except BenchError as error:
    print(json.dumps({"error": str(error)}))
else:
    print(json.dumps({"kept": kept, "failed": failed, "soft": resource.getrlimit(resource.RLIMIT_NOFILE)[0]}))
"""


def outcome(soft, hard, jobs, optimizers, trials=1, families=1, output=None):
    given = json.dumps([soft, hard, jobs, optimizers, trials, families, output and str(output)])
    done = subprocess.run([sys.executable, "-c", RUN, given], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_soft_limit_is_raised_as_far_as_the_jobs_need():
    told = outcome(1024, 0, jobs=16, optimizers=2)
    assert told["kept"] == 64
    assert 1024 < told["soft"] < 16 * 310


def test_a_limit_that_suffices_stays():
    assert outcome(1024, 0, jobs=1, optimizers=2)["soft"] == 1024


def test_fewer_optimizers_are_kept_where_the_hard_limit_is_reached():
    told = outcome(1024, 1024, jobs=16, optimizers=2)
    assert 1 <= told["kept"] < 20
    assert told["soft"] == 1024


def test_what_cannot_fit_is_refused_before_the_start_with_what_to_do():
    told = outcome(256, 256, jobs=16, optimizers=2)["error"]
    assert "16 jobs need" in told
    assert "allows a process 256; run 4 at a time (--jobs 4), or allow more (ulimit -n " in told
    assert outcome(256, 256, jobs=4, optimizers=2)["kept"] == 2


def test_a_run_with_as_many_jobs_as_fit_makes_every_trial(tmp_path):
    told = outcome(250, 250, jobs=4, optimizers=6, output=tmp_path / "out")
    assert told["failed"] == 0
    assert told["kept"] < 6


@pytest.mark.slow
@pytest.mark.parametrize("hard", [0, 1024])
def test_sixteen_jobs_of_twenty_optimizers_run_under_the_usual_limit(hard, tmp_path):
    assert outcome(1024, hard, jobs=16, optimizers=20, trials=2, families=2, output=tmp_path / "out")["failed"] == 0
