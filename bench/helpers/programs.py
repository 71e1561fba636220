"""Programs in any language that a plug-in talks to: lines of JSON to their standard input and from their output."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import subprocess
from collections import deque
from contextlib import AbstractContextManager, suppress
from os import PathLike
from pathlib import Path
from select import select
from threading import Thread
from typing import IO, NamedTuple, cast

from bench.helpers.errors import BenchError, explained
from bench.helpers.parsing import Json

LONGEST = 2**26  # bytes of a line
GRACE = 1.0  # seconds in which a program may end by itself
SHOWN = 200  # characters of what a program wrote, in a message


class ProgramCommand(NamedTuple):
    """The command of a program.

    Attributes:
        words: its absolute path, and its arguments, in which those that are files are absolute paths.
    """

    words: tuple[str, ...]

    @classmethod
    def read(cls, name: str) -> ProgramCommand:
        """Return the command of a plug-in's name, such as ``"command:Rscript mine.R"``, with words as in a shell.

        Raises:
            BenchError: where its first word is not a program that can be run.
        """
        said = name.partition(":")[2]
        try:
            words = [said] if Path(said).is_file() else shlex.split(said)
        except ValueError as error:  # a quotation without its end
            raise BenchError(f"{name!r} is no command: {error}") from error
        program = shutil.which(words[0]) if words else None
        if program is None and words and Path(words[0]).is_file():
            raise BenchError(
                f"{words[0]} cannot be executed: make it executable by 'chmod +x {shlex.quote(words[0])}', or name the "
                "interpreter that runs it, too, as in command:'Rscript mine.R'"
            )
        if program is None:
            raise BenchError(
                f"{name!r} names no program that can be run; write command:./mine, or command:'Rscript mine.R' with an "
                "interpreter that is on the path"
            )
        places = [str(Path(word).absolute()) if Path(word).is_file() else word for word in words[1:]]
        return cls((str(Path(program).absolute()), *places))

    @property
    def title(self) -> str:
        """The name of the program in messages."""
        return " ".join(Path(word).name for word in self.words[:2])


class Talk(AbstractContextManager["Talk"]):
    """A running program, and the lines to and from it; it ends with the context, or when it is closed.

    Args:
        command: of the program.
        wanted: what its lines may be, for messages.
        folder: in which it runs, None for that of this process.
    """

    def __init__(self, command: ProgramCommand, wanted: str, folder: str | PathLike[str] | None = None) -> None:
        self._name, self._wanted = command.title, wanted
        pipe = subprocess.PIPE
        with explained(f"the program {command.words[0]} cannot be started"):
            self._process = subprocess.Popen(command.words, stdin=pipe, stdout=pipe, stderr=pipe, cwd=folder)
        pipes = self._process.stdin, self._process.stdout, self._process.stderr
        self._stdin, self._stdout, self._stderr = cast(tuple[IO[bytes], IO[bytes], IO[bytes]], pipes)
        self._complaints: deque[bytes] = deque(maxlen=3)  # the last lines that it wrote to standard error
        self._reader = Thread(target=self._listen, daemon=True)
        self._reader.start()

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        self.close(0 if isinstance(error, Exception) else None)

    def close(self, grace: float | None = None) -> str:
        """Close its input, and end it where it does not end by itself within some seconds; return its unread words."""
        with suppress(OSError):
            self._stdin.close()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(GRACE if grace is None else grace)
        self._process.kill()
        self._process.wait()
        self._reader.join(GRACE)
        left = self.unread()
        for pipe in (self._stdout, self._stderr):
            pipe.close()
        return left

    def unread(self) -> str:
        """Return what the program has written and nobody has read, as far as that can be seen (not on Windows)."""
        if os.name != "posix":
            return ""
        os.set_blocking(self._stdout.fileno(), False)
        try:
            return (self._stdout.read(SHOWN) or b"").decode(errors="replace").strip()
        finally:
            os.set_blocking(self._stdout.fileno(), True)

    def say(self, **message: object) -> None:
        """Send one line, with 1e999 for +inf; a program that does not read any more is not an error here."""
        text = json.dumps(message).replace("Infinity", "1e999")  # JSON has no infinity, but any reader makes one of it
        with suppress(BrokenPipeError):
            self._stdin.write(text.encode() + b"\n")
            self._stdin.flush()

    def hear(self, seconds: float | None = None) -> Json:
        """Return the next line as JSON, None after the last; raises BenchError for another line, or a failure.

        With ``seconds``, a program that writes nothing for as long has failed, where that can be seen (not on Windows).
        """
        if seconds is not None and os.name == "posix" and not select([self._stdout], [], [], seconds)[0]:
            raise self.error(f"wrote nothing for {seconds:g} s")
        line = self._stdout.readline(LONGEST)
        if not line:
            return self._end()
        try:
            return json.loads(line)
        except (ValueError, RecursionError):  # of a cut line, too
            raise self.error(f"wrote {short(line[: 2 * SHOWN].decode(errors='replace'))}") from None

    def error(self, what: str, wanted: str = "") -> BenchError:
        """Return an error with the program's fault and the expected behaviour."""
        return BenchError(f"the program {self._name} {what}; wanted is {wanted or self._wanted}{self._said()}")

    def _end(self) -> None:
        """Raise BenchError where the program, which writes no more, failed."""
        try:
            code = self._process.wait(GRACE)
        except subprocess.TimeoutExpired:
            raise self.error("closed its standard output", "another line, or its end") from None
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
        return f"; it complained: {short(' '.join(said.split()))}" if said else ""


def short(value: object) -> str:
    """Return a program's words as one printable line that is not long."""
    text = value if isinstance(value, str) else json.dumps(value)
    text = "".join(letter if letter.isprintable() else "?" for letter in text.strip()[: SHOWN + 1])
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}…"
