"""The exceptions for bad input, a problem whose own code fails and the end of a run, and helpers for messages."""

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from importlib import import_module
from math import inf
from pathlib import Path
from types import ModuleType

Kinds = type[BaseException] | tuple[type[BaseException], ...]


class BenchError(ValueError):
    """Bad input: the message is one sentence that says what was wrong, where, and what to do.

    The command line prints it without a traceback and exits with code 2.
    """


class ProblemError(RuntimeError):
    """The problem's own code raised, which is not the optimizer's fault.

    Args:
        raised: what it raised, which the message describes.
    """

    def __init__(self, raised: BaseException) -> None:
        super().__init__(raised)
        self.raised = raised

    def __str__(self) -> str:
        return f"{type(self.raised).__name__}: {self.raised}"


class PointError(RuntimeError):
    """A point of a batch could not be evaluated; a problem raises it so that no other point is evaluated again.

    Args:
        reason: why, in one sentence.
        values: those of the first points of the batch, all that were tried; +inf of those that failed.
        failed: the number of points that failed.
    """

    def __init__(self, reason: str, values: Sequence[float] = (inf,), failed: int = 1) -> None:
        super().__init__(reason)
        self.values, self.failed = values, failed


class BudgetExhausted(BaseException):
    """Raised by an objective that has no evaluation left; the harness catches it, an optimizer need not.

    It is not a subclass of Exception, so that an optimizer's own ``except Exception`` does not catch it.
    """


class StopRun(BudgetExhausted):
    """Raised by a problem's function, or by ``on_evaluation``, to end a trial with what it has found so far.

    The call of the objective under way counts where ``on_evaluation`` raises it, and does not where the function does.

    Example:
        >>> raise bench.StopRun("good enough")  # the trial's ``stop``
    """


LONGEST = 3_000
"""Characters that are read of an exception's message."""

PROBLEM_FAILED = f"{ProblemError.__name__}: "
"""With which the stored error of a trial begins that was lost by its problem."""


def typed(error: BaseException) -> str:
    """Return an exception as one line: its type, and the first line of its message."""
    try:
        message = (str(error)[:LONGEST].strip() or "no message").splitlines()[0]
    except BaseException as another:  # __str__ is plug-in code too
        message = f"its message cannot be read: {type(another).__name__}"
    return f"{type(error).__name__}: {message}"


def reason(error: BaseException) -> str:
    """Return why an exception was raised: the system's words, a BenchError's own, or its type and message."""
    if isinstance(error, BenchError):
        return str(error)
    if isinstance(error, FileExistsError) and isinstance(error.filename, (str, Path)):
        place = Path(error.filename)
        if place.is_symlink() and not place.exists():
            return f"{place} is a link to {place.readlink()}, which is not there"
    return error.strerror if isinstance(error, OSError) and error.strerror else typed(error)


@contextmanager
def explained(what: str, kinds: Kinds = OSError) -> Iterator[None]:
    """Raise exceptions of these kinds as a BenchError that begins with what cannot be done.

    A BenchError passes unchanged.
    """
    try:
        yield
    except BenchError:
        raise
    except kinds as error:
        raise BenchError(f"{what}: {reason(error)}") from error


def require(module: str, extra: str, needed: str) -> ModuleType:
    """Import and return a module that an extra of this package installs.

    Args:
        module: its name, such as "pyarrow".
        extra: the extra of this package that installs it.
        needed: the start of the message where the module is missing, such as "the parquet format needs".

    Raises:
        BenchError: where it is not installed.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name not in (module, module.partition(".")[0]):
            raise
        raise BenchError(f"{needed} {module}; install it with: pip install 'backlash-bench[{extra}]'") from error


def near(name: str, known: Iterable[str], cutoff: float = 0.5) -> list[str]:
    """Return the known names that somebody may have meant, at most three; upper and lower case are the same.

    They are the name itself in other letters, or else the shortest names that hold it as a word, or that hold it at
    all, or else the one that is spelled most alike, where its ratio of :mod:`difflib` is at least ``cutoff``.
    """
    names = {text.casefold(): text for text in sorted(known, reverse=True)}
    wanted = name.casefold()
    if wanted in names:
        return [names[wanted]]
    word = re.compile(rf"(?<![^\W_]){re.escape(wanted)}(?![^\W_])")
    held = [text for text in names if word.search(text)] if len(wanted) > 1 else []
    held = held or [text for text in names if len(wanted) > 2 and wanted in text]
    shortest = sorted(held, key=lambda text: (len(text), text))[:3]
    return [names[text] for text in shortest or get_close_matches(wanted, names, n=1, cutoff=cutoff)]


def nearest(name: str, known: Iterable[str], otherwise: str = "") -> str:
    """Return a hint such as ``"; did you mean 'gwo'?"`` or, where none is near, ``otherwise`` or the known names."""
    known = sorted(known)
    if close := [repr(text) for text in near(name, known)]:
        return f"; did you mean {' or '.join(filter(None, (', '.join(close[:-1]), close[-1])))}?"
    if otherwise or not known:
        return otherwise or "; there are none"
    shown = ", ".join(known[:12])
    return f"; known: {shown}{', …' if len(known) > 12 else ''}"
