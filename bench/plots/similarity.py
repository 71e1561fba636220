"""A map of optimizers by how alike they search, and the tree of their clusters."""

from __future__ import annotations

import matplotlib.figure
import numpy as np
from scipy.cluster.hierarchy import dendrogram, fcluster, linkage

from bench.analysis.similarity import Similarity
from bench.plots import style

SQUARE = 3.6  # inches: a figure higher than that has a map of its own shape
NEAR = 0.05  # of the map's width: optimizers that share one label


def similarity_map(similarity: Similarity) -> matplotlib.figure.Figure:
    """Return a figure of two panels: a map, on which numbers stand for optimizers, and the tree that names them.

    Optimizers of one cluster have one colour.
    """
    names = style.names(similarity.places.index, 22)
    labels = [f"{names[str(name)]}  {number}" for number, name in enumerate(similarity.places.index, 1)]
    height = max(2.4, 0.18 * len(labels))
    figure, (left, right) = style.grid(
        2, height=height, left=0.5, across=0.4 + style.text_width(labels), top=0.15, bottom=0.4, right=0.1
    )
    places = similarity.places.to_numpy(dtype=float)
    colours = [style.PALETTE[(cluster - 1) % len(style.PALETTE)] for cluster in similarity.clusters]
    for (x, y), colour in zip(places, colours, strict=True):
        left.plot([x], [y], "o", color=colour, markersize=5, clip_on=False)
    width = float(np.ptp(places, axis=0).max()) or 1.0
    spots = fcluster(linkage(places), NEAR * width, criterion="distance")
    for spot in sorted(set(spots)):
        members = np.flatnonzero(spots == spot)
        at = places[members[places[members, 0].argmax()]]
        left.annotate(
            ", ".join(str(member + 1) for member in members), at, xytext=(5, 0), textcoords="offset points", va="center"
        )
    left.margins(0.15)
    if height > SQUARE:  # beside a long tree, the map is a square at its top
        left.set_aspect("equal", adjustable="box", anchor="N")
    else:
        left.set_aspect("equal", adjustable="datalim")
    left.set_xlabel("distance less its noise floor")
    dendrogram(
        similarity.tree, labels=labels, orientation="right", ax=right, color_threshold=0, above_threshold_color="black",
        leaf_font_size=style.POINTS,
    )  # fmt: skip
    for text in right.get_yticklabels():
        text.set_color(colours[int(text.get_text().rsplit("  ", 1)[1]) - 1])
    right.set_xlabel("distance less its noise floor")
    return figure
