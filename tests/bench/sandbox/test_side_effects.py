"""What plug-in code leaves behind in its process is detected; what leaves nothing behind is not accused."""

import os
import sys
from importlib import import_module

import pytest

from bench.sandbox.process import Process

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals, forks and timers of POSIX")

LONG = 60.0  # seconds; ends a test that hangs, and decides nothing else
NOTHING = {"random": [], "threads": 0, "processes": 0, "altered": False, "any": False}
FENV = "import ctypes; ctypes.CDLL('libm.so.6').fesetround"
X86 = pytest.mark.skipif(os.uname().machine != "x86_64", reason="rounding modes are numbered as on x86-64")


@pytest.fixture(scope="module")
def fork_server(testing_plugins):
    with Process(hash_seed=0, forks=True) as fork_server:
        fork_server.call(
            import_module("testing_calls").side_effects, "import ctypes, subprocess, threading", seconds=LONG
        )
        yield fork_server


def left_by(fork_server, statement):
    with fork_server.fork() as process:
        return process.call(import_module("testing_calls").side_effects, statement, seconds=LONG)


@pytest.mark.parametrize(
    "statement",
    [
        "",
        "import numpy as np; np.random.default_rng(1).random(10); [x**2 for x in range(1000)]",
        "import random; random.Random(3).random()",
        "import subprocess; subprocess.run(['true'])",
        "import threading; thread = threading.Thread(target=print); thread.start(); thread.join()",
        "import threading, time; threading.Thread(target=time.sleep, args=(0.02,)).start()",  # it is waited for
        "import os; os.fork() or os._exit(0)",
        "import numpy as np\nwith np.errstate(all='raise'): pass",
        "import os; folder = os.getcwd(); os.chdir('/'); os.chdir(folder)",
    ],
)
def test_what_is_put_back_or_ends_is_no_side_effect(fork_server, statement):
    assert left_by(fork_server, statement) == NOTHING


@pytest.mark.parametrize(
    "statement",
    [
        "import sys; sys.setrecursionlimit(5000)",
        "import sys; sys.path.append('/')",
        "import sys; sys.path = []",
        "import sys, types; sys.modules['new'] = types.ModuleType('new')",
        "import os; os.environ['OMP_NUM_THREADS'] = '2'",
        "import os; del os.environ['PATH']",
        "import os; os.chdir('/proc')",
        "import numpy as np; np.seterr(all='raise')",
        "import numpy as np; np.seterrcall(print)",
        "import warnings; warnings.simplefilter('error')",
        "import sys; sys.stdout = None",
        "import os; os.close(0)",
        "import os; os.dup2(os.open('/dev/null', os.O_RDWR), 2)",
        "import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN)",
        "import signal; signal.setitimer(signal.ITIMER_VIRTUAL, 500)",
        pytest.param(f"{FENV}(0x400)", id="rounding downwards", marks=X86),
        pytest.param(f"{FENV}(0x800)", id="rounding upwards", marks=X86),
        pytest.param(f"{FENV}(0xc00)", id="rounding to zero", marks=X86),
        pytest.param(
            "import ctypes; libm = ctypes.CDLL('libm.so.6'); state = (ctypes.c_uint32 * 8)(); libm.fegetenv(state); "
            "state[7] |= 0x8040; libm.fesetenv(state)",
            id="flushing to zero",
            marks=X86,
        ),
    ],
)
def test_a_process_that_is_not_as_it_was_is_detected(fork_server, statement):
    assert left_by(fork_server, statement) == NOTHING | {"altered": True, "any": True}


@pytest.mark.parametrize(
    ("statement", "names"),
    [
        ("import random; random.random()", ["Python's random"]),
        ("import numpy as np; np.random.seed(0)", ["numpy.random"]),
        ("import random, numpy as np; np.random.rand(); random.seed(1)", ["Python's random", "numpy.random"]),
    ],
)
def test_a_use_of_global_random_states_is_named(fork_server, statement, names):
    assert left_by(fork_server, statement) == NOTHING | {"random": names, "any": True}


@pytest.mark.parametrize("daemon", [True, False])
def test_threads_that_stay_are_counted(fork_server, daemon):
    thread = f"threading.Thread(target=time.sleep, args=(600,), daemon={daemon})"
    statement = f"import threading, time\nfor _ in range(3): {thread}.start()"
    assert left_by(fork_server, statement) == NOTHING | {"threads": 3, "any": True}


def test_threads_that_no_module_knows_are_counted(fork_server):
    statement = "import _thread, time; _thread.start_new_thread(time.sleep, (600,))"  # it need not have begun to run
    assert left_by(fork_server, statement) == NOTHING | {"threads": 1, "any": True}


@pytest.mark.parametrize(
    "statement",
    [
        "import subprocess; subprocess.Popen(['sleep', '600'])",
        "import subprocess; subprocess.Popen(['sleep', '600'], start_new_session=True)",
        "import subprocess; subprocess.run(['sh', '-c', 'sleep 600 & exit 0'])",
        "import os, time\nif os.fork() == 0: os.setsid(); time.sleep(600)",
    ],
)
def test_processes_that_stay_are_counted(fork_server, statement):
    assert left_by(fork_server, statement) == NOTHING | {"processes": 1, "any": True}


def test_multiprocessing_s_own_helper_is_no_stray(fork_server):
    statement = (
        "from multiprocessing import shared_memory\n"
        "memory = shared_memory.SharedMemory(create=True, size=8); memory.close(); memory.unlink()"
    )
    assert left_by(fork_server, statement)["processes"] == 0
