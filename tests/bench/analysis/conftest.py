"""What the tests of the analysis share: small tidy frames, and a look at a single row."""

import numpy as np
import pandas as pd
import pytest

# Demšar 2006 (Journal of Machine Learning Research 7), Table 6: AUC of C4.5 under four tunings, higher is better.
DEMSAR = {
    "adult": (0.763, 0.768, 0.771, 0.798),
    "breast cancer": (0.599, 0.591, 0.590, 0.569),
    "breast cancer wisconsin": (0.954, 0.971, 0.968, 0.967),
    "cmc": (0.628, 0.661, 0.654, 0.657),
    "ionosphere": (0.882, 0.888, 0.886, 0.898),
    "iris": (0.936, 0.931, 0.916, 0.931),
    "liver disorders": (0.661, 0.668, 0.609, 0.685),
    "lung cancer": (0.583, 0.583, 0.563, 0.625),
    "lymphography": (0.775, 0.838, 0.866, 0.875),
    "mushroom": (1.000, 1.000, 1.000, 1.000),
    "primary tumor": (0.940, 0.962, 0.965, 0.962),
    "rheum": (0.619, 0.666, 0.614, 0.669),
    "voting": (0.972, 0.981, 0.975, 0.9749),  # printed as 0.975 twice, but ranked 2 and 3
    "wine": (0.957, 0.978, 0.946, 0.970),
}


@pytest.fixture(scope="session")
def frame_of():
    """Build a tidy frame from {(problem, optimizer): values}; None stands for a failed trial."""

    def build(cells, **columns):
        rows = [
            (problem, optimizer, i, "failed" if value is None else "ok", value)
            for (problem, optimizer), values in cells.items()
            for i, value in enumerate(values)
        ]
        return pd.DataFrame(rows, columns=["problem", "optimizer", "trial", "status", "fun"]).assign(**columns)

    return build


@pytest.fixture(scope="session")
def one():
    """Return the only row of a table, or the only one with these values."""

    def only(table, **where):
        for column, value in where.items():
            same = np.isclose(table[column], value) if isinstance(value, float) else table[column] == value
            table = table[same]
        assert len(table) == 1
        return table.iloc[0]

    return only


@pytest.fixture(scope="session")
def random_frame(frame_of):
    """Build a tidy frame of random trials, with some failures, ties and cells of different sizes."""

    def build(seed, problems=3, optimizers=4, trials=12, failing=0.1, decimals=1):
        rng = np.random.default_rng(seed)
        cells = {}
        for problem in range(problems):
            for optimizer in "abcdefgh"[:optimizers]:
                values = rng.gamma(2, 1, trials - rng.integers(3)).round(decimals) + rng.integers(3)
                failed = rng.random(len(values)) < failing
                cells[f"p{problem}", optimizer] = [
                    None if bad else value for bad, value in zip(failed, values, strict=True)
                ]
        return frame_of(cells)

    return build


@pytest.fixture(scope="session")
def demsar():
    """Return Demšar's Table 6 as errors, lower is better: 14 problems by four optimizers."""
    table = pd.DataFrame.from_dict(DEMSAR, orient="index", columns=["C4.5", "C4.5+m", "C4.5+cf", "C4.5+m+cf"])
    return (1 - table).round(4)
