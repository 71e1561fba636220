"""What all plots share: looks that differ without colour, and offsets of points."""

import numpy as np

from bench.plots import style


def test_looks_are_told_without_colour():
    looks = style.looks([str(i) for i in range(40)]).values()
    assert len({(look.color, look.marker, str(look.line)) for look in looks}) == 40
    assert len({look.marker for look in list(looks)[:7]}) == 7


def test_offsets_are_fixed_and_bounded():
    assert np.abs(style.spread(1000)).max() <= 0.25
    assert (style.spread(5) == style.spread(5)).all()
