"""Estimates as lines and as a table."""

from pathlib import Path

import pytest
from rich.console import Console

from problems.backlash.sensor import formatting
from problems.backlash.sensor.batch import Estimated


def test_the_table_fits_eighty_columns_whatever_the_names(make_estimate):
    names = [f"a-robot-with-a-long-name/joint4_2024-{month:02}.csv" for month in (1, 2)]
    outcomes = [Estimated(Path(name), make_estimate(0.001, verdict="no backlash")) for name in names]
    console = Console(width=80, record=True)
    console.print(formatting.table(outcomes, names, 80), highlight=False)
    lines = console.export_text().splitlines()
    assert max(map(len, lines)) <= 80
    assert "0.900 to 1.100" in lines[2]
    assert [line.split()[2] for line in lines[2:]] == ["a-robot…t4_2024-01.csv", "a-robot…t4_2024-02.csv"]


@pytest.mark.parametrize(
    ("verdict", "amplitude", "early", "progressed"),
    [
        ("no backlash", 0.0, False, False),
        ("no backlash", 0.1, False, False),
        ("early", 0.5, True, False),
        ("progressed", 1.5, True, True),
        ("undecided", 1.2, True, False),
        ("undecided", 0.0, False, False),  # the noise may hide it
        ("backlash", 0.5, True, False),
    ],
)
def test_an_alarm_is_for_what_is_detected_and_as_bad_as_asked(make_estimate, verdict, amplitude, early, progressed):
    estimate = make_estimate(verdict=verdict, amplitude_rps=amplitude)
    assert formatting.is_alarm(estimate, "early") == early
    assert formatting.is_alarm(estimate, "progressed") == progressed
