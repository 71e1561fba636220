"""The published numbers of the thesis's Table 7.3, the test on noisy signals."""

from __future__ import annotations

from typing import NamedTuple


class Row(NamedTuple):
    """A row of the table: 30 runs of CMA-ES on one noisy dataset, in rps.

    Attributes:
        theoretical: the positive peak of the undecimated disturbance, which is the expected A.
        noise: amplitude of the uniform noise, half of its peak-to-peak value.
        mean: mean of the A of the runs.
        stdev: their standard deviation.
        error: |mean - theoretical| / theoretical in percent, None without backlash.
    """

    theoretical: float
    noise: float
    mean: float
    stdev: float
    error: float | None


TABLE_7_3 = {
    2: Row(0.2769, 0.1079, 0.2641, 0.0024, 4.63),
    3: Row(0.4159, 0.1158, 0.3870, 0.0009, 6.94),
    4: Row(0.5245, 0.1237, 0.4925, 0.0138, 6.10),
    5: Row(0.6263, 0.1316, 0.5709, 0.0124, 8.84),
    6: Row(0.7246, 0.1394, 0.6731, 0.0223, 7.11),
    7: Row(0.8162, 0.1474, 0.8074, 0.0127, 1.07),
    8: Row(0.8976, 0.1552, 0.8960, 0.0011, 0.18),
    9: Row(0.9757, 0.1631, 0.9269, 0.0276, 5.00),
    10: Row(1.0639, 0.1711, 1.0328, 0.0570, 2.92),
    11: Row(1.1385, 0.1789, 1.0696, 0.0194, 6.05),
    0: Row(0.0, 0.1000, 0.0099, 0.0178, None),
}
"""By dataset, 0 for noise without backlash: Giovannitti, "Virtual measurement of backlash in industrial manipulators",
Table 7.3. The table names no datasets; its theoretical values are those of 2 to 11."""
