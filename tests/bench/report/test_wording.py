"""Numbers, lists and durations in sentences and cells."""

import numpy as np
import pytest

from bench.report.wording import cell_text, count, listing, row_texts, seconds


@pytest.mark.parametrize(
    ("value", "decimals", "text"),
    [
        (True, None, "yes"), (np.bool_(False), None, "no"), (None, None, "–"), (float("nan"), 2, "–"),
        (float("inf"), 2, "∞"), (-float("inf"), None, "−∞"), (12345, None, "12,345"), (np.int64(7), 3, "7"),
        (1.23456, None, "1.235"), (1.23456, 1, "1.2"), (12345.6, 0, "12,346"), ("<b>", None, "<b>"),
    ],
)  # fmt: skip
def test_cells(value, decimals, text):
    assert cell_text(value, decimals) == text


@pytest.mark.parametrize(
    ("values", "texts"),
    [
        ([1.912, 1.341, 263.9], ["1.912", "1.341", "263.9"]),
        ([263.8958, 263.8959, 270.0], ["263.9", "263.9", "270.0"]),
        ([263.8958, 263.8965], ["263.896", "263.897"]),
        ([263.8958, 263.8958], ["263.9", "263.9"]),
        ([263.89581, 263.89582], ["263.9", "263.9"]),
        ([12345.6, 0.0, -1.5, 0.99996], ["12,346", "0", "-1.500", "1.0000"]),
        ([2.5e7, 2.50004e7, 3e-5], ["2.50000e+07", "2.50004e+07", "3.00000e-05"]),
        ([float("nan"), float("inf"), 1.0], ["–", "∞", "1.000"]),
        ([], []),
    ],
)
def test_values_of_a_row_show_the_digits_that_distinguish_them(values, texts):
    assert row_texts(np.array(values)) == texts


def test_sentences():
    assert count(1, "trial") == "1 trial"
    assert count(60_000, "evaluation") == "60,000 evaluations"
    assert listing(["a"]) == "a"
    assert listing(["a", "b", "c"]) == "a, b and c"
    assert listing(list("abcdef"), at_most=3) == "a, b and 4 more"
    assert (seconds(0.0123), seconds(3.456)) == ("12.3 ms", "3.46 s")
