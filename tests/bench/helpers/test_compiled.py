import numpy as np
import pytest

from bench.helpers.compiled import compiled


def test_without_a_folder_for_numbas_cache_the_loop_is_compiled_nevertheless():
    from numba import float64

    exec("def twice(x):\n    return 2 * x", names := {})  # of no file, so numba finds no folder for it
    assert compiled(names["twice"], float64(float64))(2.5) == 5.0


def test_an_array_of_another_layout_is_refused_and_not_misread():
    second = compiled(lambda values: values[1], "float64(float64[::1])")
    assert second(np.arange(2.0)) == 1.0
    with pytest.raises(TypeError):
        second(np.arange(4.0)[::2])
