import gc
import itertools
import json
import os
import select
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import settings

# A busy machine must not fail a property, nor two runs of one commit differ.
settings.register_profile("suite", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("suite")

# Looking for garbage among the million objects of numba, pandas and matplotlib takes a sixth of the suite's time.
gc.set_threshold(20_000, 50, 100)

# The workers of xdist take the cores: a report of their tests is drawn, and a study run, by one process more at most.
os.environ.setdefault("LOKY_MAX_CPU_COUNT", "1")

# Hundreds of processes import pandas, numba and matplotlib: without bytecode files each would take seconds more.
if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
    sys.dont_write_bytecode = False

SLOWEST = (
    "test_pages.py", "test_distributions.py", "test_examples.py", "test_reference_results.py", "test_hostile.py",
    "test_crash.py", "test_cma_es_fast.py", "test_app.py", "test_dask.py", "test_problem.py", "test_checker.py",
)  # fmt: skip


def pytest_collection_modifyitems(items):
    """Begin with the files that take longest, so that no worker is left alone with one of them at the end."""
    items.sort(key=lambda item: SLOWEST.index(item.path.name) if item.path.name in SLOWEST else len(SLOWEST))


@pytest.fixture(scope="session")
def published() -> Path:
    """The folder with the thesis authors' published recordings; a test that needs it is skipped where there is none."""
    default = Path(__file__).resolve().parents[1].parent / "shared" / "data"
    folder = Path(os.environ.get("BENCH_PUBLISHED_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"no published recordings at {folder}: set BENCH_PUBLISHED_DATA to their folder")
    return folder


# A browser: Chromium, spoken to in the DevTools protocol through a pipe, which needs no driver and no library.

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
OPTIONS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--remote-debugging-pipe",
)  # fmt: skip
LAUNCH = """
import fcntl, os, sys
reads, writes = (fcntl.fcntl(int(each), fcntl.F_DUPFD, 10) for each in sys.argv[1:3])
os.dup2(reads, 3), os.dup2(writes, 4)  # where Chromium looks for them
os.execv(sys.argv[3], sys.argv[3:])
"""
KEYS = {
    "Tab": (9, ""), "Enter": (13, "\r"), "ArrowRight": (39, ""), "ArrowDown": (40, ""), "+": (187, "+"), "0": (48, "0"),
}  # fmt: skip


class Browser:
    """One tab of a headless browser."""

    def __init__(self, program, profile):
        (reads, self.writes), (self.reads, writes) = os.pipe(), os.pipe()
        command = [
            sys.executable,
            "-c",
            LAUNCH,
            str(reads),
            str(writes),
            program,
            *OPTIONS,
            f"--user-data-dir={profile}",
        ]
        self.process = subprocess.Popen(command, pass_fds=(reads, writes), stderr=subprocess.DEVNULL)
        os.close(reads), os.close(writes)
        self.numbers, self.buffer, self.events, self.session = itertools.count(1), b"", [], {}
        target = self("Target.createTarget", url="about:blank")["targetId"]
        self.session = {"sessionId": self("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]}
        for domain in ("Page", "Network", "Log"):
            self(f"{domain}.enable")

    def __call__(self, method, **params):
        """Return a command's result; events that come before it are kept."""
        number = next(self.numbers)
        os.write(
            self.writes, json.dumps({"id": number, "method": method, "params": params, **self.session}).encode() + b"\0"
        )
        answer = self.until(lambda message: message.get("id") == number)
        assert "error" not in answer, (method, answer["error"])
        return answer["result"]

    def until(self, wanted, patience=30):
        """Return the first message that is wanted."""
        end = time.monotonic() + patience
        while True:
            while b"\0" in self.buffer:
                line, self.buffer = self.buffer.split(b"\0", 1)
                message = json.loads(line)
                self.events.append(message)
                if wanted(message):
                    return message
            ready = select.select([self.reads], [], [], max(end - time.monotonic(), 0))[0]
            chunk = os.read(self.reads, 1 << 20) if ready else b""
            if not chunk:
                raise TimeoutError("the browser does not answer")
            self.buffer += chunk

    def open(self, path, *, width=1280, height=900, dark=False, media="screen", scripts=True, state=""):
        """Load a file as a reader with such a screen sees it; ``state`` ends its address."""
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        self("Emulation.setEmulatedMedia", media=media, features=[scheme])
        self("Emulation.setScriptExecutionDisabled", value=not scripts)
        self.events.clear()
        self("Emulation.setScrollbarsHidden", hidden=True)
        self("Page.navigate", url=path.as_uri() + state)
        self.until(lambda message: message.get("method") == "Page.loadEventFired")

    def run(self, script):
        """Return the value of a JavaScript expression, awaited."""
        done = self("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in done, done["exceptionDetails"]
        return done["result"].get("value")

    def wait(self, script):
        """Return a JavaScript expression's value as soon as it is true."""
        return self.run(
            f"new Promise((done) => {{ const look = () => {{ const it = {script};"
            " it ? done(it) : setTimeout(look, 20) }; look() })"
        )

    def press(self, key):
        code, text = KEYS[key]
        for kind in ("keyDown", "keyUp"):
            self("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code, text=text)

    def seen(self, method):
        """Return the parameters of the events of a kind since the page was opened."""
        return [message["params"] for message in self.events if message.get("method") == method]

    def close(self):
        self.session = {}
        try:
            self("Browser.close")
            self.process.wait(10)
        except (TimeoutError, BrokenPipeError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()
        os.close(self.reads), os.close(self.writes)


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """Return a headless Chromium; a test that needs it is skipped where there is none."""
    program = next(filter(None, map(shutil.which, PROGRAMS)), None)
    if program is None:
        pytest.skip(f"no browser: none of {', '.join(PROGRAMS)} is installed")
    browser = Browser(program, tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()
