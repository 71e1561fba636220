"""Recordings of a motor's speed: reading, screening (``screen``), and the time of one load turn (``period``)."""

from problems.backlash.recordings.recording import Recording, parse_window, read

__all__ = ["Recording", "parse_window", "read"]
