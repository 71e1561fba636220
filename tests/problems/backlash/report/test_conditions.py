"""Unequal conditions of any study."""

from bench import Study
from problems.backlash.report import fitting_errors


def test_table_7_2_takes_the_thesis_s_population_of_several():
    labels = fitting_errors.algorithms(Study.load("thesis-equal"))
    assert labels == {name: f"{name} 300" for name in ("alo", "goa", "da", "gwo", "cma-es")}


def test_a_study_of_unequal_conditions_names_the_one_of_equal_ones():
    sentence = fitting_errors.unequal(Study.load("thesis"))[0]
    assert "the study thesis-equal gives all the same handling and start" in sentence
    assert fitting_errors.unequal(Study.load("thesis-equal")) == ()
