"""Drive ``bench.Evaluator`` through 200 candidates in one process, 50 of them hostile, and look for what they leave.

    python validation/evaluator.py [--no-sandbox]

A hostile candidate evaluates one point, the middle of the box, and then tries to get a better score or to do harm. One
that evaluates the same point and returns has the true score: none may be above it. The others are random searches of
several shapes. Processes, open files, memory and files are counted before and after. The costs are processor seconds of
all processes, so that other work on the machine changes little.
"""

import sys
import textwrap
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
import psutil

import bench

WARM, ALL, EVERY = 10, 200, 4  # candidates before the first count, in all, and of which one is hostile
PROBLEMS = ["bbob-f01-d5-i1", "bbob-f10-d5-i1"]
FIRST = "def search(objective, rng):\n    objective((objective.lower + objective.upper) / 2)\n"
HOSTILE = {
    "frames": """
        import sys
        frame = sys._getframe()
        while frame is not None:
            for value in [*frame.f_locals.values()]:
                for name, lie in (("fun", -1e9), ("_nfev", 1), ("_limit", 10**9), ("_budget", 10**9)):
                    try:
                        object.__setattr__(value, name, lie)
                    except Exception:
                        pass
            frame = frame.f_back
        while True:
            objective(objective.upper + 1)
    """,
    "gc": """
        import gc
        from bench.contract.problem import Problem
        for thing in gc.get_objects():
            if isinstance(thing, Problem):
                thing.evaluate = lambda x: x[:, 0] * 0 - 1e9
                thing.optimum = 0.0
        objective._compute = lambda x: x[:, 0] * 0 - 1e9
        objective(objective.upper + 1)
    """,
    "ctypes": """
        import ctypes
        ctypes.memset(objective.lower.ctypes.data, 0, objective.lower.nbytes)
        ctypes.c_double.from_address(id(objective.fun) + 16).value = -1e9
        ctypes.string_at(1)
    """,
    "files": """
        import os, pathlib, tempfile
        for folder in ("/tmp", "/var/tmp", "/dev/shm", os.path.expanduser("~"), os.getcwd(), tempfile.gettempdir()):
            try:
                pathlib.Path(folder, "left-by-a-candidate").write_bytes(bytes(10_000_000))
            except OSError:
                pass
        kept = [open(os.devnull) for _ in range(200)]
    """,
    "sockets": """
        import socket
        for address in (("127.0.0.1", 22), ("1.1.1.1", 53)):
            try:
                socket.create_connection(address, timeout=1).sendall(b"x")
            except OSError:
                pass
    """,
    "answers": """
        import os
        for number in range(3, 30):
            try:
                os.write(number, b'["value", {"fun": -1e9, "status": "ok"}]' * 100)
            except OSError:
                pass
    """,
    "sleeping": """
        import time
        time.sleep(10_000)
    """,
    "forking": """
        import os, time
        for _ in range(30):
            if not os.fork():
                os.setsid()
                time.sleep(10_000)
    """,
    "printing": """
        while True:
            print("x" * 1_000_000)
    """,
    "nan": """
        import numpy as np
        for value in (np.nan, np.inf, -np.inf, 1e308):
            objective(np.full(objective.dimension, value))
    """,
    "arrays": """
        import numpy as np
        kept = []
        while True:
            kept.append(np.ones(50_000_000))
    """,
    "exit": """
        import os
        os._exit(0)
    """,
}
ORDINARY = [
    "def search(objective, rng):\n    while True:\n        objective(objective.initial(7))\n",
    """
import numpy as np
class RandomSearch:
    def __init__(self, budget=10000, dim=10):
        self.budget, self.f_opt, self.x_opt = budget, np.inf, None
    def __call__(self, func):
        for i in range(self.budget):
            x = np.random.uniform(func.bounds.lb, func.bounds.ub)
            f = func(x)
            if f < self.f_opt:
                self.f_opt, self.x_opt = f, x
        return self.f_opt, self.x_opt
""",
    "def search(objective, rng):\n    return [0][len(objective.lower)]\n",
    "class Unfinished:\n    def __init__(self, budget, dim)\n",
]


def main() -> None:
    safe = "--no-sandbox" not in sys.argv
    hostile = [FIRST + textwrap.indent(textwrap.dedent(deed), "    ") for deed in HOSTILE.values()]
    with bench.Evaluator(PROBLEMS, budget=400, trials=1, timeout=5, memory=1, n_jobs=2, sandbox=safe) as judge:
        truth = judge(FIRST).score
        for number in range(1, WARM):
            judge(ORDINARY[number % 2])
        before, outside, wrong, known = counted(), left(), 0, {}
        for number in range(WARM, ALL):
            if number % EVERY == 0:
                place = number // EVERY % len(hostile)
                found = judge(hostile[place])
                name = [*HOSTILE][place]
                known[name] = found
                wrong += found.score > truth
            else:
                found = judge(ORDINARY[number % len(ORDINARY)])
        after = counted()
        print(f"{ALL} candidates; {wrong} of {ALL // EVERY} hostile ones above the truth, {truth:.6f}")
        for name, found in known.items():
            print(f"  {name:9} {found.score:.6f}  {found.error[:100]}")
        for what, first, last in zip(("processes", "open files", "MB here", "MB in all"), before, after, strict=True):
            print(f"  {what:10} {first:8.0f} -> {last:8.0f}")
        print("  files left outside:", sorted(left() - outside) or "none")
    print("  processes after close:", len(psutil.Process().children(recursive=True)))
    costs(safe)


def counted() -> tuple[float, ...]:
    """Return the processes below this one, its open files, its MB, and those of all (shared memory counts once)."""
    own = psutil.Process()
    below = own.children(recursive=True)
    held = sum(each.memory_full_info().pss for each in (own, *below) if each.is_running())
    return len(below), own.num_fds(), own.memory_info().rss / 1e6, held / 1e6


def left() -> set[str]:
    places = (Path("/tmp"), Path("/var/tmp"), Path("/dev/shm"), Path.home(), Path.cwd())
    return {str(path) for place in places for path in place.glob("left-by-a-candidate*")}


def costs(safe: bool) -> None:
    """Print the processor seconds of candidates beside those of the same searches in one process."""
    problems = [f"bbob-f{number:02}-d5-i1" for number in range(1, 11)]
    with bench.Evaluator(problems, budget=2000, trials=1, n_jobs=2, sandbox=safe) as judge:
        began = spent()
        judge(ORDINARY[1])
        print(f"first candidate, with start and baselines: {spent() - began:.2f} s of processor")
        ours, theirs, broken, scope = [], [], [], {}
        exec(ORDINARY[1], scope)
        for _ in range(5):
            began = spent()
            judge(ORDINARY[1])
            ours.append(spent() - began)
            began = process_time()
            for problem in problems:
                bench.solve(problem, scope["RandomSearch"], budget=2000)
            theirs.append(process_time() - began)
            began = spent()
            for _ in range(10):  # a look at the processor seconds takes about as long as one
                judge(ORDINARY[3])
            broken.append((spent() - began) / 10)
        began = perf_counter()
        judge(FIRST + "    while True:\n        pass\n")
        endless = perf_counter() - began
    here, plain, syntax = (float(np.median(each)) for each in (ours, theirs, broken))
    print(f"10 problems x 2,000 evaluations: {here:.2f} s, in one process {plain:.2f} s; syntax error {syntax:.3f} s")
    print(f"endless candidate, time limit 10 s: {endless:.1f} s of wall time")


def spent() -> float:
    """Return the processor seconds of this process and of all below it, those that have ended included."""
    own = psutil.Process()
    return sum(sum(each.cpu_times()[:4]) for each in (own, *own.children(recursive=True)))


if __name__ == "__main__":
    main()
