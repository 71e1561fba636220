"""Contradictions that a table can have, and none in the numbers of any real sample."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.reproduce.criticism import criticise
from bench.reproduce.table import PaperCell, PaperTable, Printed, read

EXAMPLES = Path(__file__).parents[3] / "examples" / "tables"


def printed(text):
    return Printed(float(text), 10.0 ** -len(text.partition(".")[2]) if "e" not in text else 0.0, text)


def cell(function="1", optimizer="GWO", runs=30, **numbers) -> PaperCell:
    texts = {name: printed(text) for name, text in numbers.items()}
    return PaperCell(1, "", function, optimizer, None, None, runs, "", texts, {})


def found(*cells, averages=(), **settings):
    remarks, _ = criticise(PaperTable("t", cells, tuple(averages), {"values": "error", **settings}))
    return [(remark.kind, remark.sentence) for remark in remarks]


def kinds(*cells, **settings):
    return [kind for kind, _ in found(*cells, **settings)]


def test_a_value_below_the_optimum_is_found():
    table = PaperTable("t", (cell("cec2022-f04-d10", mean="799.0", best="650.0"),))
    (remark,), _ = criticise(table)
    assert (remark.kind, remark.sentence) == (
        "below the optimum",
        "its best 650.0 is below the optimum, 800 (the definition of the suite)",
    )
    assert kinds(cell(mean="-0.3")) == ["below the optimum"]


@pytest.mark.parametrize(
    ("numbers", "sentence"),
    [
        ({"mean": "1.00", "best": "2.00"}, "its best 2.00 is above its mean 1.00"),
        ({"median": "3.00", "worst": "2.00"}, "its median 3.00 is above its worst 2.00"),
    ],
)
def test_an_order_that_no_sample_has_is_found(numbers, sentence):
    assert found(cell(**numbers)) == [("order", sentence)]


@pytest.mark.parametrize(
    "numbers",
    [
        {"mean": "10.00", "best": "9.00", "sd": "5.60"},  # at most sqrt(30) = 5.48
        {"mean": "1.00", "sd": "5.60"},  # no error is below 0
        {"mean": "10.00", "best": "5.00", "sd": "0.90"},  # the best alone makes 5 / sqrt(29) = 0.93
        {"mean": "10.00", "best": "10.00", "worst": "12.00", "sd": "0.20"},
        {"mean": "10.00", "median": "8.00", "sd": "1.50"},
        {"mean": "10.00", "best": "9.00", "worst": "11.00", "sd": "1.20"},  # at most 1.017
        {"mean": "10.00", "sd": "-1.00"},
    ],
)
def test_an_sd_that_the_other_numbers_exclude_is_found(numbers):
    assert "impossible SD" in kinds(cell(**numbers))


def test_averages_that_do_not_recompute_are_found():
    cells = (cell("1", mean="1.0", rank="1"), cell("2", mean="3.0", rank="2"))
    wrong = [cell("Average", mean="2.5"), cell("average rank", mean="1.8")]
    assert found(*cells, averages=wrong) == [
        ("average", "its mean 2.5 is not the average of 2 cells, 2"),
        ("average", "its rank 1.8 is not the average of 2 cells, 1.5"),
    ]
    assert found(*cells, averages=[cell("Average", mean="2.1"), cell("average rank", mean="1.5")]) == []


samples = st.lists(
    st.one_of(st.floats(0, 1e6), st.sampled_from([0.0, 1.0, 1e-9])) | st.integers(0, 50).map(float),
    min_size=2,
    max_size=40,
)


@settings(max_examples=100, deadline=None)
@given(samples, st.integers(0, 6), st.booleans(), st.booleans())
def test_no_sample_contradicts_itself_however_it_is_printed(values, digits, cut, population):
    x = np.array(values)
    whole = bool((x == x.round()).all())
    statistics = {
        "mean": x.mean(), "sd": x.std(ddof=0 if population else 1),
        "best": x.min(), "median": np.median(x), "worst": x.max(),
    }  # fmt: skip
    scale = 10.0**digits
    texts = {name: f"{(np.floor(v * scale) / scale if cut else v):.{digits}f}" for name, v in statistics.items()}
    texts["success"] = f"{100 * (x < 1).mean():.{digits}f}"
    assert found(cell(runs=len(x), **texts), counts=whole) == []


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("lshade-cec2017", {}),
        ("jso-lshade-opfunu-cec2022", {}),
        ("below-the-optimum-cec2022", {"below the optimum": 12, "rank": 1}),
    ],
)
def test_the_example_tables(name, expected):
    remarks, _ = criticise(read(EXAMPLES / f"{name}.csv"))
    assert {kind: [r.kind for r in remarks].count(kind) for kind in {r.kind for r in remarks}} == expected
