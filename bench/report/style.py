"""How the figures of a report look: :mod:`bench.plots.style`, by the name under which sections know it."""

from bench.plots.style import *  # noqa: F403
