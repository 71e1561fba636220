import gc
import os
import shutil
import sys
from collections import Counter
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from pathlib import Path

import pytest
from filelock import FileLock, Timeout
from hypothesis import settings

# A busy machine must not fail a property, nor two runs of one commit differ.
settings.register_profile("suite", deadline=None, derandomize=True, max_examples=25)
settings.register_profile("nightly", settings.get_profile("suite"), max_examples=50)
settings.load_profile("suite")

# Looking for garbage among the million objects of numba, pandas and matplotlib takes a sixth of the suite's time.
gc.set_threshold(20_000, 50, 100)

# The workers of xdist take the cores: a report of their tests is drawn, and a study run, by one process more at most.
os.environ.setdefault("LOKY_MAX_CPU_COUNT", "1")

# Hundreds of processes import pandas, numba and matplotlib: without bytecode files each would take seconds more.
if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
    sys.dont_write_bytecode = False

# The first one compiles kernels that hundreds of later tests take from numba's cache.
LONGEST = (
    "test_kernel.py", "test_write.py", "test_app.py", "test_runner.py", "test_examples.py", "test_contract.py",
    "test_cma_es_fast.py", "test_crash.py", "test_dask.py", "test_hostile.py", "test_sandbox.py", "test_estimate.py",
    "test_browser.py", "test_report.py", "test_checker.py", "test_bias.py",
    "test_folder.py", "test_author.py",
)  # fmt: skip


def pytest_addoption(parser):
    """Let a change of a page that is meant be written into the committed text."""
    parser.addoption("--update", action="store_true", help="write the texts of pages that tests compare")


def pytest_configure(config):
    """Try more examples of each property beside the slow tests, and have one worker of xdist at a time compile.

    In a fresh clone the workers would otherwise compile the same kernels at the same time, each for itself: they find
    in numba's cache what they wait for.
    """
    if "slow" in config.option.markexpr.replace("not slow", ""):
        settings.load_profile("nightly")
    if not hasattr(config, "workerinput"):
        return
    from numba.core.caching import NullCache
    from numba.core.dispatcher import Dispatcher

    file = Path(__file__).parent / "__pycache__" / "compiling.lock"
    lock, compile_for = FileLock(file, timeout=120, thread_local=False), Dispatcher.compile

    def compile_alone(self, signature):
        with nullcontext() if isinstance(self._cache, NullCache) else waiting(lock):
            return compile_for(self, signature)

    Dispatcher.compile = compile_alone


@contextmanager
def waiting(lock):
    """Hold a lock, or go on without it where another process keeps it for too long or it cannot be written."""
    with ExitStack() as stack:
        with suppress(Timeout, OSError):
            stack.enter_context(lock)
        yield


@pytest.hookimpl(tryfirst=True)  # before -m chooses
def pytest_collection_modifyitems(items):
    """Mark as slow what is beyond the sample of a parametrisation, and begin with the files that take longest.

    So no worker is left alone with one of these files at the end.
    """
    seen = Counter()
    for item in items:
        sampled = item.get_closest_marker("sampled")
        if sampled:
            test = item.nodeid.partition("[")[0]
            seen[test] += 1
            if seen[test] > sampled.args[0]:
                item.add_marker("slow")
    items.sort(key=lambda item: LONGEST.index(item.path.name) if item.path.name in LONGEST else len(LONGEST))


def pytest_collection_finish():
    """Let the collector pass over what is imported by now: pytest has it look through everything at the end."""
    gc.freeze()


@pytest.fixture(scope="session")
def published() -> Path:
    """The folder with the thesis authors' published recordings; a test that needs it is skipped where there is none."""
    default = Path(__file__).resolve().parents[1].parent / "shared" / "data"
    folder = Path(os.environ.get("BENCH_PUBLISHED_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"no published recordings at {folder}: set BENCH_PUBLISHED_DATA to their folder")
    return folder


# A browser: the system's Chromium, driven by playwright, which downloads none of its own here.

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
ARGUMENTS = ["--no-sandbox", "--hide-scrollbars", "--disable-gpu"]  # it would only imitate one
PATIENCE_MS = 300_000  # a ceiling for a browser that hangs; no test waits that long for one that works
LOOK_MS = 50


class Browser:
    """A headless browser, and the page that a test opened in it last: ``page`` is playwright's."""

    def __init__(self, browser):
        self.browser, self.context, self.page = browser, None, None

    def open(self, path, *, width=1280, height=900, dark=False, media="screen", scripts=True, state=""):
        """Load a file as a new reader with such a screen sees it; ``state`` ends its address."""
        if self.context:
            self.context.close()
        self.context = self.browser.new_context(
            viewport={"width": width, "height": height},
            color_scheme="dark" if dark else "light",
            java_script_enabled=scripts,
        )
        self.page = self.context.new_page()
        self.page.set_default_timeout(PATIENCE_MS)
        self.page.emulate_media(media=media)
        self.requests, self.complaints = [], []  # addresses asked for; messages in the console and errors of scripts
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.goto(path.as_uri() + state)

    def run(self, script):
        """Return the value of a JavaScript expression, awaited."""
        return self.page.evaluate(script)

    def wait(self, script):
        """Return a JavaScript expression's value as soon as it is true.

        It is asked for again and again from here: playwright's own waiting reads the expression anew in the page by
        ``eval``, which the policy of our pages refuses.
        """
        for _ in range(PATIENCE_MS // LOOK_MS):
            if value := self.run(script):
                return value
            self.page.wait_for_timeout(LOOK_MS)
        raise TimeoutError(f"this did not come true: {script}")

    def press(self, key):
        self.page.keyboard.press(key)


@pytest.fixture(scope="module")
def browser():
    """Return a headless Chromium; a test that needs it is skipped where there is none.

    Playwright keeps an event loop in the thread while it runs, so that it has to end before tests of another module.
    """
    program = next(filter(None, map(shutil.which, PROGRAMS)), None)
    if program is None:
        pytest.skip(f"no browser: none of {', '.join(PROGRAMS)} is installed")
    api = pytest.importorskip("playwright.sync_api", reason="no playwright, which drives the browser")
    with api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=program, args=ARGUMENTS)
        yield Browser(started)
        started.close()
