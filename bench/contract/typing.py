"""The types of arrays and options in the contracts of problems and optimizers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
"""Points, values and bounds."""

Flags = NDArray[np.bool_]
"""Yes or no for each variable or point."""

Options = dict[str, Any]
"""Options of a plug-in by name; only its own code knows their types."""
