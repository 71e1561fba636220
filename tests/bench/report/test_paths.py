"""Paths keep every point, in fewer letters."""

import pytest

from bench.report.paths import shortened


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        pytest.param(
            "M 1 2 L 4 1 L 4.5 -1.25", "m1 2l3-1 .5-2.25", id="steps are relative, the command is not repeated"
        ),
        pytest.param("M 0 0 L 1 1 L 2 1 L 5 1 L 5 4 L 5 3", "m0 0l1 1h4v3-1", id="level steps"),
        pytest.param("M 0 0 L 1 1 L 1.001 1.001 L 2 3", "m0 0l1 1 1 2", id="a step below 0.01 is left out"),
        pytest.param("M 3 3 L 3 3", "m3 3l0 0", id="a dot is no step that may be left out"),
        pytest.param("M 5 5 L 6 6 z M 7 7 L 8 8", "m5 5l1 1zm2 2l1 1", id="after z a path is at its beginning"),
        pytest.param("M 0 1.5 C 0.4 1.5 0.8 1.3 1 1 z", "m0 1.5c.4 0 .8-.2 1-.5z", id="a curve"),
        pytest.param("M 0 0 A 1 1 0 0 0 2 2", "M 0 0 A 1 1 0 0 0 2 2", id="other commands stay"),
        pytest.param("", "", id="nothing"),
    ],
)
def test_a_path_by_hand(path, expected):
    assert shortened(path) == expected


def test_rounding_does_not_add_up():
    points = [(place * 0.333333, (place % 7) * 0.777777) for place in range(3_000)]
    path = "M" + "L".join(f"{x} {y}" for x, y in points)
    steps = shortened(path)[1:].replace("l", " ").replace("-", " -").split()
    along = sum(float(step) for step in steps[::2])
    assert along == pytest.approx(points[-1][0], abs=0.006)
