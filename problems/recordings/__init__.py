"""Recordings of a motor's speed: reading, screening (``screen``), and the time of one load turn (``period``)."""

from problems.recordings.reader import read
from problems.recordings.recording import Recording, parse_window

__all__ = ["Recording", "parse_window", "read"]
