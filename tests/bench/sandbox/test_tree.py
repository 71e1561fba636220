"""The tree of a process: its children, its memory, its end."""

import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

from bench.sandbox import tree

PARENT = "import subprocess; subprocess.Popen(['sleep', '60']); input()"


@pytest.fixture
def parent():
    """A process with a child that has a session of its own."""
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT.replace("60']", "60'], start_new_session=True")], stdin=subprocess.PIPE
    )
    while not (members := psutil.Process(parent.pid).children()):
        pass
    yield parent, members[0]
    for each in (parent, members[0]):
        with suppress(psutil.NoSuchProcess):
            each.kill()
    parent.stdin.close()
    parent.wait()


def test_children_are_those_of_this_process_ended_ones_included(parent):
    parent, child = parent
    assert parent.pid in tree.children()
    assert child.pid not in tree.children()
    parent.kill()
    os.waitid(os.P_PID, parent.pid, os.WEXITED | os.WNOWAIT)
    assert parent.pid in tree.children()
    parent.wait()
    assert parent.pid not in tree.children()


def test_children_are_known_without_the_kernel_s_list_too(parent, monkeypatch):
    listed = tree.children()
    monkeypatch.setattr(Path, "iterdir", lambda self: iter([Path("/nowhere")]))
    assert tree.children() == listed


def test_memory_is_that_of_all_members(parent):
    parent, child = parent
    held = tree.look(parent.pid)
    assert held > psutil.Process(parent.pid).memory_info().rss
    assert held > tree.look(child.pid) > 0


def test_one_that_has_ended_holds_none():
    ended = subprocess.Popen([sys.executable, "-c", ""])
    os.waitid(os.P_PID, ended.pid, os.WEXITED | os.WNOWAIT)
    assert tree.look(ended.pid) is None  # though its parent has not waited for it
    ended.wait()
    assert tree.look(ended.pid) is None
