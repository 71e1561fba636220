"""Tables of values, a row a problem and a column an optimizer."""

import numpy as np
import pandas as pd


def table_of(rows, optimizers="abcdefgh"):
    rows = np.array(rows, dtype=float)
    return pd.DataFrame(rows, [f"p{i}" for i in range(len(rows))], list(optimizers[: rows.shape[1]]))


def random_table(seed, problems=10, optimizers=4):
    return table_of(np.random.default_rng(seed).gamma(2, 1, (problems, optimizers)))
