"""Recordings of a motor's speed: reading, screening (``screen``), and the time of one load turn (``period``)."""

from problems.backlash.recordings.reading import NoRecordingError, read, read_joints
from problems.backlash.recordings.recording import Recording, parse_window

__all__ = ["NoRecordingError", "Recording", "parse_window", "read", "read_joints"]
