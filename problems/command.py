"""Programs in any language as problems: they are given points and print values, such as a simulator does."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from math import isnan
from pathlib import Path
from tempfile import TemporaryDirectory
from time import sleep
from typing import Any

import numpy as np

from bench import BenchError, FunctionProblem, Problem
from bench.contract.numbers import require_whole
from bench.contract.typing import Floats, Options
from bench.helpers import Json, JsonObject, ProgramCommand, Talk, count, short
from bench.helpers.errors import PointError, nearest

PROTOCOL = 1
OPTIONS = ("lower", "upper", "variables", "integer", "optimum", "violations", "retries", "folder")
PATIENCE = 60.0  # seconds for the first line of a program
LONGEST_WAIT = 60.0  # seconds before a program is started again
FIRST = (
    'a first line of JSON such as {"protocol": 1, "lower": [0, 0], "upper": [1, 2]}, or lower and upper among the '
    "options of a program that takes each point as arguments"
)
ANSWER = 'a line of JSON such as {"f": 0.25}'
BOX = ("lower", "upper", "variables", "integer", "optimum", "measure", "violations")
"""What a first line may say of the problem, beside ``protocol``."""


class Program(FunctionProblem):
    """A program that evaluates one point after the other.

    Args:
        name: of the problem.
        command: of the program.
        folder: in which it runs, None for the one in which the harness was called.
        box: ``lower`` and ``upper``, and other arguments of :class:`bench.FunctionProblem`.
    """

    compiles = False

    def __init__(self, name: str, command: ProgramCommand, folder: str | None, box: Options) -> None:
        settings = dict(box)
        self.measure = str(settings.pop("measure", ""))
        self._number: int | None = settings.pop("violations", None)  # of violations; else that of the first answer
        if self._number is not None:
            require_whole(f"problem {name!r}: its number of violations", self._number, 0, 1000)
        self.joint = self._number != 0
        self._found: dict[bytes, list[float]] = {}  # the violations at the points of the last call
        try:
            super().__init__(self.values, name=name, vectorized=True, **settings)
        except (TypeError, ValueError) as error:
            if isinstance(error, BenchError):
                raise
            raise BenchError(f"problem {name!r}: its box cannot be read: {error}") from error
        self._command, self._folder, self.by_point = command, folder, True

    def values(self, x: Floats) -> Floats:
        """Return the (n,) values of the (n, d) points ``x``; raises PointError at the first that fails."""
        self._found.clear()
        values: list[float] = []
        for row in x:
            try:
                value, *violations = self.answer(row)
                if isnan(value):
                    raise BenchError(f"the program {self._command.title} returned NaN")
            except BenchError as error:
                raise PointError(str(error), [*values, np.inf]) from error
            self._number = len(violations)
            self._found[row.tobytes()] = violations
            values.append(value)
        return np.array(values, dtype=np.float64)

    def violations(self, x: Floats) -> Floats | None:
        """Return the (n, m) violations that the program finds at the (n, d) points, None where it never does."""
        if not self.joint:
            return None
        if any(row.tobytes() not in self._found for row in x):
            self.values(x)
        return np.array([self._found[row.tobytes()] for row in x], dtype=np.float64)

    def fits(self, numbers: Sequence[float]) -> bool:
        """Return whether an answer has the value and as many violations as were declared, or as the first answer."""
        return len(numbers) > 0 and self._number in (None, len(numbers) - 1)

    def answer(self, row: Floats) -> list[float]:
        """Return the value of a (d,) point and its violations; raises BenchError where the program gives none."""
        raise NotImplementedError

    def coordinates(self, row: Floats) -> list[int | float]:
        """Return the coordinates of a (d,) point, those of integer variables as whole numbers."""
        whole = np.zeros(self.dimension, bool) if self.integer is None else self.integer
        return [int(value) if flag else float(value) for value, flag in zip(row, whole, strict=True)]


class Conversation(Program):
    """A program that runs for as long as a trial does, and answers each point by a line of JSON."""

    _unasked = ""  # what the program wrote in this trial without being asked
    _is_asked = False  # whether an answer is due, as where the call was interrupted
    _talk: tuple[int, Talk] | None = None  # with the process that started it: a copy starts its own

    def answer(self, row: Floats) -> list[float]:
        """Return the answer of the program."""
        try:
            talk = self._started()
            if before := talk.unread():  # an answer before may have been meant for another point
                self._unasked = f"wrote {short(before)} unasked"
                raise talk.error(self._unasked)
            self._is_asked = True
            talk.say(x=self.coordinates(row))
            answer = talk.hear()
            self._is_asked = False
            match answer:
                case {"f": value, "g": [*violations], **rest} if not rest and self._are([value, *violations]):
                    return [float(value), *map(float, violations)]
                case {"f": value, **rest} if not rest and self._are([value]):
                    return [float(value)]
                case None:
                    raise talk.error("ended without an answer")
                case _:
                    more = f', "g": [the {count(self._number, "violation")}]}}' if self._number else "}"
                    raise talk.error(f"wrote {short(answer)}", ANSWER[:-1] + more)
        except BenchError:
            self._ended()  # another one is started for the next point
            raise

    def _are(self, numbers: list[Json]) -> bool:
        """Return whether these are the numbers of an answer."""
        plain = all(isinstance(each, int | float) and not isinstance(each, bool) for each in numbers)
        return plain and self.fits(numbers)

    def open(self) -> None:
        """Start the program, unless it runs."""
        self._started()

    def close(self) -> None:
        """End the program, if one runs; raises BenchError where it wrote more lines than it was asked for."""
        left, before, asked = self._ended(), self._unasked, self._is_asked
        self._unasked, self._is_asked = "", False
        if before or (left and not asked):
            raise BenchError(
                f"the program {self._command.title} {before or f'wrote {short(left)} after its last answer'}"
            )

    def _ended(self) -> str:
        """End the program, if one runs; return what it wrote and nobody read."""
        talk, self._talk = self._talk, None
        return talk[1].close() if talk is not None and talk[0] == os.getpid() else ""

    def _started(self) -> Talk:
        if self._talk is None or self._talk[0] != os.getpid():
            talk = Talk(self._command, ANSWER, self._folder)
            self._talk = os.getpid(), talk
            talk.hear()  # the box again
        return self._talk[1]


class OncePerPoint(Program):
    """A program that is started for each point, takes its coordinates as arguments, and prints its value last.

    Where words of the command hold names of variables in braces, such as ``--gap={gap}``, the coordinates stand there;
    else they follow the command. Where they hold ``{in}``, that is the name of a file with a line ``name = value`` for
    each variable; of ``{out}``, the file's last line is read in place of what the program prints. Violations follow the
    value, in the same line.

    Args:
        retries: how often a program that ended with an exit code is started again for a point, after 1, 2, 4 … s.
    """

    def __init__(self, name: str, command: ProgramCommand, folder: str | None, box: Options) -> None:
        settings = dict(box)
        self._retries = settings.pop("retries", 0)
        require_whole(f"problem {name!r}: 'retries'", self._retries, 0, 100)
        super().__init__(name, command, folder, settings)

    def answer(self, row: Floats) -> list[float]:
        """Return the numbers in the last line that the program prints or writes."""
        texts = dict(zip(self.variables, map(repr, self.coordinates(row)), strict=True))
        with TemporaryDirectory() as place:
            files = {"in": Path(place, "in.txt"), "out": Path(place, "out.txt")}
            words = [_filled(word, {**files, **texts}) for word in self._command.words]
            words += texts.values() if words == [*self._command.words] else ()
            files["in"].write_text("".join(f"{name} = {text}\n" for name, text in texts.items()))
            done = self._run(words)
            for wait in (2.0**number for number in range(self._retries)):
                if done.returncode > 0:
                    sleep(min(wait, LONGEST_WAIT))
                    done = self._run(words)
            written = done.stdout
            if any("{out}" in word for word in self._command.words):
                written = files["out"].read_bytes() if files["out"].is_file() else b""
        return self._read(done, _last(written))

    def _run(self, words: list[str]) -> subprocess.CompletedProcess[bytes]:
        try:
            return subprocess.run(words, capture_output=True, cwd=self._folder, stdin=subprocess.DEVNULL)
        except OSError as error:
            raise BenchError(f"the program {self._command.title} cannot be started: {error.strerror}") from error

    def _read(self, done: subprocess.CompletedProcess[bytes], last: str) -> list[float]:
        """Return the numbers of a line; raises BenchError where the program failed, or they are others."""
        title, said = self._command.title, short(_last(done.stderr))
        complaint = f"; it complained: {said}" if said else ""
        if done.returncode:
            how = f"with code {done.returncode}" if done.returncode > 0 else f"by signal {-done.returncode}"
            raise BenchError(f"the program {title} ended {how}{complaint}")
        with suppress(ValueError):
            numbers = [float(word.replace("_", "?")) for word in last.split()]  # Python alone takes 1_000 for a number
            if self.fits(numbers):
                return numbers
        wanted = f"the value and {count(self._number, 'violation')}" if self._number else "the value, as in 0.25"
        what = f"printed {short(last)} last" if last else "printed nothing"
        raise BenchError(f"the program {title} {what}; wanted is {wanted}{complaint}")


def _filled(word: str, texts: Mapping[str, object]) -> str:
    for name, text in texts.items():
        word = word.replace(f"{{{name}}}", str(text))
    return word


def _last(written: bytes) -> str:
    lines = written.decode(errors="replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "")


def _first_line(command: ProgramCommand, folder: str | None) -> JsonObject:
    """Return the box that a program declares; raises BenchError where it says none."""
    with Talk(command, FIRST, folder) as talk:
        first = talk.hear(PATIENCE)
        if first is None:
            raise talk.error("ended without a line")
        if not isinstance(first, dict) or not {"lower", "upper"} <= first.keys():
            raise talk.error(f"wrote {short(first)}")
    if first.pop("protocol", None) != PROTOCOL:
        raise BenchError(f'the first line of {command.title} must have "protocol": {PROTOCOL}')
    for key in first:
        if key not in BOX:
            raise BenchError(f"the first line of {command.title} has {key!r}{nearest(key, BOX)}")
    return first


class Command:
    """The family ``command:<words of a command>``: any program, in any language, that returns values of points.

    It has no list of names: 'bench solve command:./simulate gwo' runs the program ./simulate; in a study, write
    problem = ["./simulate", "--case", "3"]. The program writes its box in its first line, and answers lines of JSON; or
    it is started for each point, where the options ``lower`` and ``upper`` give the box. The protocol is in
    docs/reference/protocol.md; examples/simulator has programs to copy.
    """

    def names(self) -> list[str]:
        """Return no name: there is nothing to list."""
        return []

    def load(self, name: str, /, folder: str | None = None, **box: Any) -> Problem:
        """Return the problem of a program; raises BenchError where it cannot be started or gives no box.

        Args:
            name: ``command:`` and the words of the command, as in a shell.
            folder: in which the program runs; by default the one in which the harness was called.
            box: ``lower``, ``upper``, and ``variables``, ``integer``, ``optimum`` and the number of ``violations``, of
                a program that is started for each point; another one says so itself. ``retries`` is how often it is
                started again where it ended with an exit code, such as for a licence that is not free.
        """
        for option in box:
            if option not in OPTIONS:
                raise BenchError(f"problem {name!r} has no option {option!r}{nearest(option, OPTIONS)}")
        if folder is not None and not Path(folder).is_dir():
            raise BenchError(f"problem {name!r}: there is no folder {folder!r} to run the program in")
        command = ProgramCommand.read(name)
        if {"lower", "upper"} <= box.keys():
            return OncePerPoint(name, command, folder, box)
        if box:
            raise BenchError(f"problem {name!r} has {', '.join(box)}, but not both lower and upper, which give a box")
        return Conversation(name, command, folder, _first_line(command, folder))


command = Command()
