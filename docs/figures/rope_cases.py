"""Intervals of a difference beside the region of practical equivalence."""

from matplotlib.figure import Figure

CASES = (
    ("equivalent", -0.4, 0.5), ("different, and it matters", 1.4, 2.6),
    ("different, but too little to matter", 0.1, 0.8), ("neither shown: too few trials", -0.7, 1.9),
)  # fmt: skip


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    figure = Figure(figsize=(6.4, 2.2))
    ax = figure.subplots()
    ax.axvspan(-1, 1, alpha=0.25)
    ax.axvline(0, color=ink, linewidth=0.7, linestyle=":")
    for row, (_, low, high) in enumerate(CASES):
        ax.plot([low, high], [row, row], "|-", color=ink, linewidth=2, markersize=9)
    ax.set_yticks(range(len(CASES)), [name for name, _, _ in CASES])
    ax.set(xlabel="difference of medians (shaded: the rope)", xlim=(-2, 3), ylim=(3.6, -0.6))
    return figure
