"""Messages between processes: whole, in order, of limited size, and never waited for longer than asked."""

import os
import socket
import sys
from threading import Thread
from types import SimpleNamespace

import pytest

from bench.sandbox import channel
from bench.sandbox.channel import _HEAD, LONGEST, BrokenChannelError, Channel

LONG = 60.0  # seconds; ends a test that hangs, and decides nothing else
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="open files pass through sockets of POSIX only")


@pytest.fixture
def ends():
    one, other = socket.socketpair()
    with one, other:
        yield Channel(one), Channel(other), other


@pytest.fixture
def clock(monkeypatch):
    """A clock by which each look at it takes a tenth of a second."""
    clock = SimpleNamespace(now=0.0)

    def look():
        clock.now += 0.1
        return clock.now

    monkeypatch.setattr(channel, "monotonic", look)
    return clock


def test_messages_arrive_whole_and_in_order(ends):
    receiver, sender, _ = ends
    sent = [(1, b""), (2**64 - 1, b"x" * 3_000_000), (0, b"\x00")]
    thread = Thread(target=lambda: [sender.send(*each) for each in sent])
    thread.start()
    assert [receiver.receive(LONG) for _ in sent] == sent
    thread.join()
    assert receiver.receive(0.0) is None


def test_what_has_arrived_of_a_message_is_kept(ends):
    receiver, _, raw = ends
    message = _HEAD.pack(7, 4) + b"four"
    for cut in (3, 12, 3):
        raw.send(message[:cut])
        assert receiver.receive(0.0) is None
        message = message[cut:]
    raw.send(message + _HEAD.pack(8, 0))
    assert receiver.receive(0.0) == (7, b"four")
    assert receiver.receive(0.0) == (8, b"")


def test_one_that_sends_byte_by_byte_prolongs_no_receive(ends, clock, monkeypatch):
    """However much has arrived, and though more keeps arriving."""
    receiver, sender, _ = ends
    monkeypatch.setattr(channel, "_CHUNK", 1)
    sender.send(1, b"x" * 1000)
    assert receiver.receive(2.0) is None
    assert clock.now < 4.0
    clock.now = 0.0
    assert receiver.receive() == (1, b"x" * 1000)


def test_a_message_too_long_breaks_the_channel_before_it_is_read(ends):
    receiver, _, raw = ends
    raw.send(_HEAD.pack(1, LONGEST + 1))
    with pytest.raises(BrokenChannelError, match="too long"):
        receiver.receive(LONG)


@POSIX
def test_files_arrive_with_a_message_above_the_standard_streams(ends):
    one, other = socket.socketpair()
    with one, other:
        receiver, sender = Channel(one, takes_files=True), Channel(other)
        reading, writing = os.pipe()
        sender.send(1, b"x" * 1_000, [writing])
        os.close(writing)
        assert receiver.receive(LONG) == (1, b"x" * 1_000)
        (file,) = receiver.files
        assert file >= 10
        os.write(file, b"through it")
        os.close(file)
        assert os.read(reading, 100) == b"through it"
        os.close(reading)
