"""The budget left unused, by hand."""

import pytest

from bench.analysis.unused_budget import unused_budget

pytestmark = pytest.mark.filterwarnings("error", "default::ResourceWarning")


def test_unused_budget(frame_of):
    frame = frame_of({("p", "a"): [1.0, 1.0, None], ("p", "b"): [1.0]}, nfev=[50, 100, 10, 99.5], stop="tolfun")
    found = unused_budget(frame, 100).set_index("optimizer")
    assert found.loc["a"].tolist() == [2, 0.25, 0.5]
    assert found.loc["b"].tolist() == pytest.approx([1, 0.005, 0.0])
    good = unused_budget(frame.assign(stop=["target", "budget", None, "target"]), 100).set_index("optimizer")
    assert good.loc["a"].tolist() == [2, 0.0, 0.0]
