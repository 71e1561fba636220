"""Cut recordings, for tests of short ones."""

from dataclasses import replace

import numpy as np


def cut(recording, begin=-np.inf, end=np.inf):
    """Return the samples of a recording from one time to another, s."""
    near = 1e-6 * recording.dt
    first, *_, last = np.flatnonzero((recording.time >= begin - near) & (recording.time <= end + near))
    return replace(recording, start=recording.start + first * recording.dt, speed=recording.speed[first : last + 1])
