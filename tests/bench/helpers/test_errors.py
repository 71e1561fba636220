"""BenchError, and the hints in its messages."""

import pytest

from bench import BenchError
from bench.helpers.errors import explained, nearest


@pytest.mark.parametrize(
    ("name", "known", "hint"),
    [
        ("gwp", ["alo", "gwo"], "; did you mean 'gwo'?"),
        ("CMA-ES", ["cma-es", "bipop-cma-es"], "; did you mean 'cma-es'?"),
        ("pso", ["pymoo", "m:OriginalPSO", "n:PSO", "p:EPPSO", "m:C_PSO"], "; did you mean 'n:PSO' or 'm:C_PSO'?"),
        ("pso", ["pymoo", "m:OriginalPSO"], "; did you mean 'm:OriginalPSO'?"),
        (
            "f1",
            ["a-f1-d10", "a-f1-d2", "a-f1-d5", "a-f1-d3", "a-f10-d2"],
            "; did you mean 'a-f1-d2', 'a-f1-d3' or 'a-f1-d5'?",
        ),
        ("", ["gwo", "alo"], "; known: alo, gwo"),
        ("xyz", ["gwo", "alo"], "; known: alo, gwo"),
        ("xyz", [], "; there are none"),
        (
            "?",
            [f"n{i:02}" for i in range(13)],
            "; known: n00, n01, n02, n03, n04, n05, n06, n07, n08, n09, n10, n11, …",
        ),
    ],
)
def test_a_hint_names_the_nearest_or_what_is_known(name, known, hint):
    assert nearest(name, known) == hint


class UnprintableError(Exception):
    def __str__(self):
        raise OSError


@pytest.mark.parametrize(
    ("raised", "said"),
    [
        (FileNotFoundError(2, "No such file or directory"), "it fails: No such file or directory"),
        (KeyError("a"), "it fails: KeyError: 'a'"),
        (ValueError("one\ntwo"), "it fails: ValueError: one"),
        (RuntimeError(), "it fails: RuntimeError: no message"),
        (UnprintableError(), "it fails: UnprintableError: its message cannot be read: OSError"),
        (BenchError("a sentence"), "a sentence"),
    ],
)
def test_what_is_explained_is_one_sentence(raised, said):
    with pytest.raises(BenchError) as error, explained("it fails", Exception):
        raise raised
    assert str(error.value) == said
