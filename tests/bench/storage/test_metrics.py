import json
import random
import struct

import numpy as np
import pytest

from bench.storage.metrics import Damaged, parsed


def by_hand(texts):
    """Return by name the rows that have a value, and their values."""
    found = {}
    for row, text in enumerate(texts):
        for name, value in json.loads(text or b"{}").items():
            rows, values = found.setdefault(name, ([], []))
            rows.append(row)
            values.append(value)
    return found


def written(rows):
    return [None if each is None else json.dumps(each).encode() for each in rows]


def assert_parsed(rows, runs=None):
    texts = written(rows)
    found, expected = parsed(texts, np.array(runs or [0, len(texts)])), by_hand(texts)
    assert list(found) == list(expected)
    for name, (index, values) in found.items():
        order = np.argsort(np.arange(len(texts)) if index is None else index)
        assert (list(range(len(texts))) if index is None else index[order].tolist()) == expected[name][0]
        assert [repr(value) for value in values[order].tolist()] == [repr(value) for value in expected[name][1]]


def doubles(count):
    """Return floating-point numbers of random bits: of all sizes, most with 17 digits."""
    rng = random.Random(7)
    numbers = (struct.unpack("<d", rng.getrandbits(64).to_bytes(8, "little"))[0] for _ in range(3 * count))
    return [number for number in numbers if number == number and abs(number) != float("inf")][:count]


def test_every_digit_of_a_number_is_kept():
    numbers = [*doubles(20_000), 0.0, -0.0, 5e-324, 1.7976931348623157e308, 0.1, 1e22, 9007199254740993.0, 1e-07, 1e16]
    assert_parsed([{"a": number, "T1": -number} for number in numbers])


def test_names_may_hold_digits_signs_letters_quotes_and_more():
    names = ["e1", "T-1", "1.5e-3", "a b", 'say "x"', "a: 1, b", "{}", "größe", "\\"]
    assert_parsed([{name: number + place for place, name in enumerate(names)} for number in (0.5, 1.5, 2.5)] * 5)


@pytest.mark.parametrize(
    "odd",
    [
        None, {}, {"b": 1.0, "a": 2.0}, {"a": 1.0}, {"a": 1.0, "b": 2.0, "c": 3.0}, {"a": 1, "b": 2.0},
        {"a": float("nan"), "b": float("inf")}, {"a": "1.0", "b": 2.0}, {"a": True, "b": 2.0}, {"c": 1.0, "d": 2.0},
        {"a": {"b": 1.0}, "b": 2.0}, {"b": 2.0},
    ],
)  # fmt: skip
@pytest.mark.parametrize("place", [0, 3, 9])
def test_a_text_unlike_the_others_is_parsed_all_the_same(odd, place):
    rows = [{"a": 0.25 * row, "b": 0.5 * row} for row in range(10)]
    texts = written([*rows[:place], odd, *rows[place:]])
    found, expected = parsed(texts, np.array([0, len(texts)])), by_hand(texts)
    assert set(found) == set(expected)
    for name, (rows_, values) in expected.items():
        index, got = found[name]
        having = dict(zip(range(len(texts)) if index is None else index.tolist(), got.tolist(), strict=True))
        for row, value in zip(rows_, values, strict=True):
            assert repr(having[row]) in (repr(value), repr(float(value)) if isinstance(value, int) else repr(value))


def test_runs_of_other_names_are_parsed_one_by_one():
    rows = [{"x1": row / 3, "x2": row / 7} for row in range(20)] + [{"y": row / 9} for row in range(20)]
    assert_parsed(rows, runs=[0, 20, 40])


def test_whole_numbers_stay_whole():
    index, values = parsed(written([{"a": 1}, {"a": 2}]), np.array([0, 2]))["a"]
    assert values.dtype == int
    assert values[np.argsort(index)].tolist() == [1, 2]


@pytest.mark.parametrize(
    "text",
    [b"", b"{", b'{"a": 1.0, "b": }', b'{"a": 1.0 "b": 2.0}', b'{"a": 1.0.0, "b": 2.0}', b'{"a": , "b": 2.0}',
     b'{"a": -, "b": 2.0}', b'{"a": 1.0, "b": 2.0}}', b'[1.0, 2.0]', b"\xff", b'{"a": 1 .0, "b": 2.0}',
     b'{"a": 1.0, "b": 2.0},{"a": 1.0, "b": 2.0}', b"1.0"],
)  # fmt: skip
@pytest.mark.parametrize("place", [0, 2, 4])
def test_the_row_of_a_damaged_text_is_named(text, place):
    texts = written([{"a": 0.5, "b": 1.5}] * 4)
    texts.insert(place, text)
    with pytest.raises(Damaged) as damaged:
        parsed(texts, np.array([0, 5]))
    assert damaged.value.place == place


def test_rows_without_values_have_none():
    assert parsed([None, b"{}", None], np.array([0, 3])) == {}
