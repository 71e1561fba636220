"""Estimates as lines and as a table."""

import math
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from problems.backlash.sensor import formatting
from problems.backlash.sensor.batch import Estimated, Failed
from problems.backlash.sensor.estimate import Settings
from problems.backlash.sensor.recording_files import Series
from problems.backlash.sensor.trend import trend
from problems.backlash.signature.calibration import Calibration

MINE = Calibration(np.array([3.0, 100.0]), np.array([0.0, 0.004]), name="mine", gear_ratio=40.0, speed_rps=100.0)
SETTINGS = Settings(calibration=MINE)
NAN = (math.nan, math.nan)


def words(estimate, settings=SETTINGS):
    return "\n".join(formatting.estimate_lines(Estimated(Path("a.csv"), estimate), settings))


def test_an_estimate_is_told_with_units_intervals_and_the_total_gap(make_estimate):
    said = words(make_estimate(0.001, notes=("it drifts",)))
    assert said.startswith("a.csv: early backlash, up to the limit of 2.1 mrad\n")
    for line in (
        "amplitude    0.6000 rps of the motor, 95% interval 0.5400 to 0.6600",
        "half-gap     1.000 mrad at the joint, 95% interval 0.900 to 1.100",
        "3.44 arc minutes, 95% interval 3.09 to 3.78",
        "total gap    twice the half-gap: 2.000 mrad, 6.88 arc minutes",
        "fit          RMSE 0.0500 rps; explains 90.0% of the signal's variance (p < 1e-6 for noise alone)",
        "load turn    0.4 s (found in the signal); 1.2 s, 3 load turns, 601 samples at 100 rps",
        "calibration  mine; gear ratio 40; motor at 100 rps\n",
        "note         it drifts",
    ):
        assert f"  {line}" in said


def test_no_backlash_tells_what_could_be_hidden_and_is_undecided_where_that_is_too_much(make_estimate):
    quiet = {"verdict": "no backlash", "amplitude_rps": 0.0, "p_value": 0.5}
    said = words(make_estimate(0.0, **quiet, amplitude_interval_rps=(0.0, 0.1), interval_rad=(0.0, 0.0001)))
    assert said.startswith("a.csv: no backlash detected\n")
    assert "none detected; the noise hides any below 0.1000 rps" in said
    assert "not seen     a gap that never opens in this motion, as with strong viscous friction\n" in said
    short = words(make_estimate(0.0, **quiet, amplitude_interval_rps=(0.0, 1e7), interval_rad=(0.0, math.nan)))
    assert "none detected; the recording is too short or too noisy to show one\n" in short
    assert "the noise hides any up to 0.100 mrad (0.34 arc minutes)" in said
    for most, hidden in ((1.2, 0.0022), (9.0, math.nan)):
        open_ = quiet | {"verdict": "undecided", "notes": ("it drifts", "the noise may hide a backlash above 0.3 mrad")}
        loud = make_estimate(0.0, **open_, amplitude_interval_rps=(0.0, most), interval_rad=(0.0, hidden))
        assert words(loud).startswith("a.csv: UNDECIDED: the noise may hide a backlash above 0.3 mrad\n")
        assert words(loud).count("may hide") == 1
    assert words(make_estimate(0.002, width=0.001)).startswith("a.csv: early backlash")
    from_one = Settings(calibration=Calibration(np.array([10.0, 100.0]), np.array([0.001, 0.004])))
    below = words(make_estimate(math.nan, **quiet, amplitude_interval_rps=(0.0, 0.1), interval_rad=NAN), from_one)
    assert below.startswith("a.csv: no backlash detected\n")
    assert "up to 1.000 mrad" in below


def test_the_table_has_a_row_a_file_whatever_became_of_it(make_estimate, capsys):
    names = ["good", "bad", "[red]"]
    outcomes = [
        Estimated(Path("g"), make_estimate(0.001)),
        Failed(Path("b"), "no"),
        Estimated(Path("r"), make_estimate(0.002)),
    ]
    Console(width=200).print(formatting.table(outcomes, names), highlight=False)
    heading, _, good, bad, red = capsys.readouterr().out.splitlines()
    assert heading.split()[:2] == ["half-gap,", "amplitude,"]
    assert " ".join(good.split()) == "early good 1.000 0.900 to 1.100 0.6000 0.5400 to 0.6600 0.0500"
    assert bad.split() == ["failed", "bad"]
    assert red.split()[:2] == ["early", "[red]"]


def test_the_table_fits_eighty_columns_whatever_the_names(make_estimate):
    names = [f"a-robot-with-a-long-name/joint4_2024-{month:02}.csv" for month in (1, 2)]
    outcomes = [Estimated(Path(name), make_estimate(0.001, verdict="no backlash")) for name in names]
    console = Console(width=80, record=True)
    console.print(formatting.table(outcomes, names, 80), highlight=False)
    lines = console.export_text().splitlines()
    assert max(map(len, lines)) <= 80
    assert "0.900 to 1.100" in lines[2]
    assert [line.split()[2] for line in lines[2:]] == ["a-robot…t4_2024-01.csv", "a-robot…t4_2024-02.csv"]


def trend_words(make_estimate, gaps, unit="month", settings=SETTINGS, **others):
    at = np.arange(len(gaps)) + (24288.0 if unit == "month" else 1.0)
    series = Series("joint4", tuple(range(len(gaps))), at, unit)
    made = trend(series, [make_estimate(gap, **others) for gap in gaps], limit_rad=settings.limit_rad)
    return "\n".join(formatting.trend_lines(made, settings))


@pytest.mark.parametrize(
    ("gaps", "unit", "lines"),
    [
        (
            [0.001 + 0.0001 * i for i in range(8)], "month",
            ["joint4: half-gap 1.000 mrad in 2024-01, 1.700 in 2024-08: a change of +0.700 (+0.559 to +0.841)",
             "  it grows by 0.1 mrad a month (95% interval 0.1 to 0.1, p < 0.001)",
             "  the limit of 2.1 mrad is reached in 2024-12 (2024-12 to 2024-12) if the growth of the latest 6"],
        ),
        (
            [0.001, 0.0022, 0.0023], "number",
            ["1.000 mrad in number 1, 2.300 in number 3", "no trend: +0.65 mrad for each 1 of the number in the names",
             "0.1 to +1.2) may be chance (p = 0.33)", "the limit of 2.1 mrad has been passed in number 2"],
        ),
        (
            [0.002 - 0.0001 * i for i in range(8)], "file",
            ["2.000 mrad in recording 1", "it falls by 0.1 mrad a recording (95% interval 0.1 to 0.1, p < 0.001)",
             "is not predicted to be reached: the latest 6 recordings show no significant growth"],
        ),
        ([0.001, 0.002], "month", ["a slope needs three recordings of different times"]),
        (
            [0.001, 0.002, math.nan], "month",
            ["amplitude (not all have a half-gap) 0.700 rps in 2024-01, 0.700 in 2024-03: a change of +0.000"],
        ),
    ],
)  # fmt: skip
def test_a_trend_is_told_in_sentences(make_estimate, gaps, unit, lines):
    others = {"amplitude_rps": 0.7, "amplitude_interval_rps": (0.6, 0.8)} if any(map(math.isnan, gaps)) else {}
    said = trend_words(make_estimate, gaps, unit, **others)
    for line in lines:
        assert line in said
    assert "nan" not in said
    assert ("limit" in said) == (len(gaps) > 2 and not others)


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
