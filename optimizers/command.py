"""Programs in any language, as ``command:./mine``: they propose points on standard output, in lines of JSON."""

from __future__ import annotations

import hashlib
import json
import shlex
import shutil
import subprocess
from collections import deque
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Thread
from types import TracebackType
from typing import IO, Any, ClassVar, cast

import numpy as np

from bench.errors import BenchError
from bench.families import derive
from bench.objective import BudgetExhausted, Objective
from bench.optimizer import Optimizer, build, settings
from bench.typing import Floats

PROTOCOL = 1
LONGEST = 2**26  # bytes of a line
GRACE = 1.0  # seconds in which a program may end after its trial
SHOWN = 200  # characters of what a program wrote, in a message
REQUEST = 'a line of JSON such as {"x": [[0.5, 0.5]]}, {"repair": [[…]]}, {"initial": 1} or {"stop": "converged"}'


@dataclass(frozen=True)
class Program(Optimizer):
    """A program that proposes points, and is started anew for each trial; its options are passed on to it."""

    code: ClassVar[str] = "a program"
    words: ClassVar[tuple[str, ...]]  # of its command

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Answer what the program asks, by docs/reference/protocol.md; raises BenchError where it breaks the rules."""
        with _Talk(self.words) as talk:
            talk.say(
                protocol=PROTOCOL,
                dimension=objective.dimension,
                lower=objective.lower.tolist(),
                upper=objective.upper.tolist(),
                integer=objective.integer.tolist(),
                budget=objective.budget,
                seed=int(rng.integers(1, 2**31 - 1)),
                options=settings(self),
            )
            try:
                while (request := talk.hear()) is not None:
                    match request:
                        case {"x": x, **rest} if not rest:
                            talk.say(f=objective(talk.points(x, objective.dimension)).tolist())
                        case {"repair": x, **rest} if not rest:
                            talk.say(x=objective.repair(talk.points(x, objective.dimension)).tolist())
                        case {"initial": int(n), **rest} if not rest and 1 <= n <= objective.budget:
                            talk.say(x=objective.initial(n).tolist())
                        case {"stop": str(reason), **rest} if not rest:
                            return objective.stop(reason)
                        case _:
                            raise talk.error(f"wrote {_short(request)}", REQUEST)
            except BudgetExhausted:
                talk.say(stop="budget")
                raise


class _Talk:
    """A running program, and the lines to and from it; it ends with the context."""

    def __init__(self, words: tuple[str, ...]) -> None:
        self._name = " ".join(Path(word).name for word in words[:2])
        pipe = subprocess.PIPE
        try:
            self._process = subprocess.Popen(words, stdin=pipe, stdout=pipe, stderr=pipe)
        except OSError as error:
            raise BenchError(f"the program {words[0]} cannot be started: {error.strerror}") from error
        pipes = self._process.stdin, self._process.stdout, self._process.stderr
        self._stdin, self._stdout, self._stderr = cast(tuple[IO[bytes], IO[bytes], IO[bytes]], pipes)
        self._complaints: deque[bytes] = deque(maxlen=3)  # the last lines that it wrote to standard error
        self._reader = Thread(target=self._listen, daemon=True)
        self._reader.start()

    def __enter__(self) -> _Talk:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        with suppress(OSError):
            self._stdin.close()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(0 if kind and not issubclass(kind, BudgetExhausted) else GRACE)
        self._process.kill()
        self._process.wait()
        self._reader.join(GRACE)
        for pipe in (self._stdout, self._stderr):
            pipe.close()

    def say(self, **message: Any) -> None:
        """Send one line, with 1e999 for +inf; a program that does not read any more is no error here."""
        text = json.dumps(message).replace("Infinity", "1e999")  # JSON has no infinity, but any reader makes one of it
        with suppress(BrokenPipeError):
            self._stdin.write(text.encode() + b"\n")
            self._stdin.flush()

    def hear(self) -> Any:
        """Return the next line as JSON, None after the last; raises BenchError for another line, or a failure."""
        line = self._stdout.readline(LONGEST)
        if not line:
            return self._end()
        try:
            return json.loads(line)
        except (ValueError, RecursionError):  # of a cut line, too
            raise self.error(f"wrote {_short(line[: 2 * SHOWN].decode(errors='replace'))}", REQUEST) from None

    def points(self, value: Any, dimension: int) -> Floats:
        """Return the (n, d) points of a request; raises BenchError where they are none."""
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            array = np.empty(0)
        if array.ndim != 2 or array.shape[1] != dimension or not len(array):
            raise self.error(f"sent the points {_short(value)}", f"a list of points, each of {dimension} numbers")
        return array

    def error(self, what: str, wanted: str) -> BenchError:
        """Return an error that says what the program did and what is wanted instead."""
        return BenchError(f"the program {self._name} {what}; wanted is {wanted}{self._said()}")

    def _end(self) -> None:
        """Raise BenchError where the program, which writes no more, failed."""
        try:
            code = self._process.wait(GRACE)
        except subprocess.TimeoutExpired:
            raise self.error("closed its standard output", "a request, or its end") from None
        self._reader.join(GRACE)
        if code:
            ended = f"with code {code}" if code > 0 else f"by signal {-code}"
            raise BenchError(f"the program {self._name} ended {ended}{self._said()}")

    def _listen(self) -> None:
        for line in iter(lambda: self._stderr.readline(4 * SHOWN), b""):
            if line.strip():
                self._complaints.append(line)

    def _said(self) -> str:
        said = b" ".join(self._complaints).decode(errors="replace")
        return f"; it complained: {_short(' '.join(said.split()))}" if said else ""


def _short(value: Any) -> str:
    text = value if isinstance(value, str) else json.dumps(value)
    text = "".join(letter if letter.isprintable() else "?" for letter in text.strip()[: SHOWN + 1])
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}…"


class Command:
    """The family ``command:<words of a command>``: any program, in any language, that proposes points in lines of JSON.

    It has no list of names: 'bench solve classical-sphere-d5-i1 command:./mine' runs the program ./mine, and
    'command:"Rscript mine.R"' a script. In a study, write name = "command" and command = ["Rscript", "mine.R"].
    The protocol is in docs/reference/protocol.md; examples/command has programs to copy.
    """

    def __reduce__(self) -> str:
        """Pickle by reference."""
        return "command"

    def names(self) -> list[str]:
        """Return no name: there is nothing to list."""
        return []

    def load(self, name: str, **options: Any) -> Optimizer:
        """Return the optimizer that runs a command; raises BenchError where its program is not found.

        The words of the command are as in a shell. All options are the program's own.
        """
        said = name.partition(":")[2]
        words = [said] if Path(said).is_file() else shlex.split(said)
        program = shutil.which(words[0]) if words else None
        if program is None:
            raise BenchError(
                f"{name!r} names no program that can be run; write command:./mine, or command:'Rscript mine.R' with an "
                "interpreter that is on the path"
            )
        try:
            json.dumps(options, allow_nan=False)
        except (TypeError, ValueError) as error:
            raise BenchError(f"the options of {name!r} must be texts, numbers, lists or tables of these") from error
        files = [Path(word) for word in (program, *words[1:]) if Path(word).is_file()]
        hashes: dict[str, str] = {}
        for file in files:
            shown = file.name if file.name not in hashes else str(file)
            hashes[shown] = hashlib.sha256(file.read_bytes()).hexdigest()[:16]
        places = [str(Path(word).absolute()) if Path(word).is_file() else word for word in words[1:]]
        attributes = {"words": (str(Path(program).absolute()), *places), "fingerprint": hashes}
        made = derive(Program, name, {key: (Any, value) for key, value in options.items()}, self.load, **attributes)
        return build(made, name, options)


command = Command()
