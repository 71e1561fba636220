"""Unequal conditions of any study."""

from bench import Study
from problems.backlash.report import fitting_errors


def test_table_7_2_takes_the_thesis_s_population_of_several():
    labels = fitting_errors.algorithms(Study.load("thesis-equal"))
    assert labels == {name: f"{name} 300" for name in ("alo", "goa", "da", "gwo", "cma-es")}
