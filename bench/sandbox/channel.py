"""Messages over a socket: a number, a length and the payload; a server may receive open files with them."""

from __future__ import annotations

import os
import socket
import struct
from collections.abc import Sequence
from time import monotonic

LONGEST = 1 << 26
"""Bytes of a message that are accepted; a longer one breaks the channel."""

_HEAD = struct.Struct("<QQ")  # the call's number, and the number of bytes that follow
_CHUNK = 1 << 18
_FILES = 4  # that may go with one message
_FIRST = 10  # the least number of a file that came with a message


class BrokenChannelError(RuntimeError):
    """The other side has ended, has closed the channel, takes no message, or sent what is none."""


class Channel:
    """One end of a channel; a receive that runs out of time keeps what has arrived.

    Args:
        end: a connected stream socket.
        takes_files: whether open files are accepted with messages. The side that plug-in code writes to refuses them.
    """

    def __init__(self, end: socket.socket, *, takes_files: bool = False) -> None:
        self._end, self._takes_files = end, takes_files
        self._arrived = bytearray()
        self.files: list[int] = []  # that came with messages and have not been taken

    def fileno(self) -> int:
        """Return the socket's file number."""
        return self._end.fileno()

    def close(self) -> None:
        """Close this end."""
        self._end.close()

    def send(self, number: int, payload: bytes, files: Sequence[int] = (), seconds: float | None = None) -> None:
        """Send a message; raises BrokenChannelError, also where the other side does not take it for ``seconds``."""
        message = memoryview(_HEAD.pack(number, len(payload)) + payload)
        try:
            self._end.settimeout(seconds)
            if files:
                message = message[socket.send_fds(self._end, [message], list(files)) :]
            self._end.sendall(message)
        except TimeoutError as error:
            raise BrokenChannelError("the other side takes no message") from error
        except OSError as error:
            raise BrokenChannelError(str(error)) from error

    def receive(self, seconds: float | None = None) -> tuple[int, bytes] | None:
        """Return a message's number and payload, None where none has arrived after ``seconds``.

        Raises:
            BrokenChannelError: at the end of the channel, and for a message of more than ``LONGEST`` bytes.
        """
        until = None if seconds is None else monotonic() + seconds
        left = seconds
        while (message := self._whole()) is None:
            if left is not None and left < 0:  # though more may be arriving
                return None
            try:
                self._end.settimeout(left)
                chunk = self._read()
            except (TimeoutError, BlockingIOError):
                return None
            except OSError as error:
                raise BrokenChannelError(str(error)) from error
            if not chunk:
                raise BrokenChannelError("the other side has ended")
            self._arrived += chunk
            left = None if until is None else until - monotonic()
        return message

    def _whole(self) -> tuple[int, bytes] | None:
        """Return the first message that has arrived, None while it has not arrived whole."""
        if len(self._arrived) < _HEAD.size:
            return None
        number, length = _HEAD.unpack_from(self._arrived)
        if length > LONGEST:
            raise BrokenChannelError("a message is too long")
        whole = _HEAD.size + length
        if len(self._arrived) < whole:
            return None
        payload = bytes(self._arrived[_HEAD.size : whole])
        del self._arrived[:whole]
        return number, payload

    def _read(self) -> bytes:
        if not self._takes_files:
            return self._end.recv(_CHUNK)
        chunk, files, _, _ = socket.recv_fds(self._end, _CHUNK, _FILES)
        self.files += map(_moved, files)
        return chunk


def _moved(file: int) -> int:
    """Move an open file out of the numbers of the standard streams, which plug-in code may have closed."""
    import fcntl

    moved = fcntl.fcntl(file, fcntl.F_DUPFD_CLOEXEC, _FIRST)
    os.close(file)
    return moved
