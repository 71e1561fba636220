"""Derive seeds from the identity of a trial alone, never from when, where or beside which trials it runs."""

import hashlib
import json
import random
from collections.abc import Hashable
from typing import Any

import numpy as np


def trial_seed(study_seed: int, problem: str, optimizer: str, trial: int) -> int:
    """Return the 63-bit seed of a trial: a stable hash (SHA-256) of its four coordinates.

    Adding, removing or reordering problems and optimizers, or changing the number of workers, does not change it.
    """
    key = json.dumps([study_seed, problem, optimizer, trial], ensure_ascii=True).encode()
    return int.from_bytes(hashlib.sha256(key).digest()[:8], "big") >> 1


def streams(seed: int) -> tuple[np.random.Generator, np.random.Generator]:
    """Return two independent generators of a trial: one for its initial points, one for the optimizer."""
    start, search = np.random.SeedSequence(seed).spawn(2)
    return np.random.default_rng(start), np.random.default_rng(search)


def global_states() -> dict[str, Hashable]:
    """Return the global random states of Python and numpy, which no optimizer may use, by name."""
    state: Any = np.random.get_state()  # noqa: NPY002
    return {"Python's random": random.getstate(), "numpy.random": (state[0], state[1].tobytes(), *state[2:])}
