"""Reading speed and position recordings, in the shapes that loggers and spreadsheets write."""

import numpy as np
import pandas as pd
import pytest

from bench import BenchError
from problems.backlash.recordings import Recording, read
from problems.backlash.recordings.screen import warnings

T = 0.002 * np.arange(50)
V = np.round(100 + 0.5 * np.sin(20 * T), 4)


def write(folder, text, name="a.csv"):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def rows(*columns, separator=",", decimal="."):
    lines = (separator.join(f"{cell:.6f}".replace(".", decimal) for cell in row) for row in zip(*columns, strict=True))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("text", "factor"),
    [
        pytest.param(rows(T, V), 1, id="no heading"),
        pytest.param("t,v\n" + rows(T, V), 1, id="short names"),
        pytest.param("a,b\n" + rows(T, V), 1, id="unknown names"),
        pytest.param("speed,time\n" + rows(V, T), 1, id="the other order"),
        pytest.param("Zeit [s];Drehzahl [1/min]\n" + rows(T, V, separator=";", decimal=","), 60, id="German"),
        pytest.param("time\tspeed_rpm\n" + rows(T, V, separator="\t", decimal=","), 60, id="tabs"),
        pytest.param("# 500 Hz, joint 2\n# time speed\n" + rows(T, V, separator="   "), 1, id="blanks and remarks"),
        pytest.param("time,speed\ns,deg/s\n" + rows(T, V), 360, id="a line of units"),
        pytest.param("t,v (rad/s)\n" + rows(T, V).replace("\n", "\n\n", 3) + "\n\n", 2 * np.pi, id="blank lines"),
        pytest.param("time_ms,omega_rad_s\n" + rows(1e3 * T, V), 2 * np.pi, id="milliseconds"),
        pytest.param("n,time,load_speed,motor_speed_rpm\n" + rows(V, T, V - 60, V), 60, id="the motor's of two"),
        pytest.param("time,belt speed,motor speed\n" + rows(T, V - 60, V), 1, id="the motor's and another"),
        pytest.param('"time","speed"\n' + rows(T, V), 1, id="quotes"),
        pytest.param(("time\tspeed\r\n" + rows(T, V, separator="\t")).encode("utf-16"), 1, id="utf-16"),
    ],
)
def test_text_is_read_with_the_units_of_its_headings(tmp_path, text, factor):
    recording = read(write(tmp_path, text))
    assert recording.start == 0.0
    assert recording.dt == pytest.approx(0.002, rel=1e-12)
    np.testing.assert_allclose(recording.speed, V / factor, rtol=1e-12)


@pytest.mark.parametrize("kind", ["xlsx", "parquet"])
def test_spreadsheets_and_parquet_are_read_by_their_headings(tmp_path, kind):
    table = pd.DataFrame({"current": 0 * T, "Speed [rpm]": 60 * V, "Time_us": 1e6 * T})
    path = tmp_path / f"a.{kind}"
    table.to_excel(path, index=False) if kind == "xlsx" else table.to_parquet(path)
    recording = read(path)
    np.testing.assert_allclose(recording.speed, V, rtol=1e-12)
    assert (recording.dt, recording.unit) == (pytest.approx(0.002), "rpm")


@pytest.mark.parametrize(
    ("heading", "options", "said"),
    [
        ("a,b\n", {}, ["column 'a' for the time in s and column 'b' for the speed in rps"]),
        ("", {}, ["column '1' for the time in s and column '2' for the speed in rps"]),
        ("time_s,speed\n", {}, ["the reader took column 'speed' for the speed in rps"]),
        ("a,b\n", {"speed": "b", "unit": "rps"}, ["the reader took column 'a' for the time in s"]),
        ("time_s,b\n", {"unit": "rps"}, []),
        ("time_s,speed_rps\n", {}, []),
        ("time [s],angle_deg\n", {}, []),
    ],
)
def test_what_no_heading_says_is_reported(tmp_path, heading, options, said):
    made = read(write(tmp_path, heading + rows(T, V)), **options)
    notes = [note for note in warnings(made) if "the reader took" in note]
    assert len(notes) == len(said)
    assert all(part in note for part, note in zip(said, notes, strict=True))


@pytest.mark.parametrize(("unit", "turn"), [("rev", 1.0), ("rad", 2 * np.pi), ("deg", 360.0)])
@pytest.mark.parametrize("wrapped", [False, True])
def test_a_position_is_differentiated_about_the_middle_of_two_samples(tmp_path, unit, turn, wrapped):
    """theta = 100 t + a sin(w t) has the central difference 100 + a w sinc(w dt / 2) cos(w t) exactly."""
    a, w = 0.01, 40.0
    theta = 100 * T + a * np.sin(w * T)
    if wrapped:
        theta = (theta + 0.3) % 1.0 - 0.5
    recording = read(write(tmp_path, f"time,motor_angle_{unit}\n{rows(T, turn * theta)}"))
    assert (recording.start, len(recording.speed)) == (pytest.approx(0.001), 49)
    factor = np.sin(w * 0.001) / (w * 0.001)
    np.testing.assert_allclose(recording.speed, 100 + a * w * factor * np.cos(w * recording.time), atol=2e-3 / turn)


def test_samples_of_one_time_stamp_are_averaged_and_the_note_says_so(tmp_path):
    """One of the published recordings repeats its first time stamp."""
    t = 0.002 * np.arange(200)
    v = 100 + t
    path = write(tmp_path, "time_s,speed_rps\n" + rows([t[0], *t], [v[0] + 1, *v]))
    recording = read(path)
    np.testing.assert_allclose(recording.speed, [v[0] + 0.5, *v[1:]], atol=1e-6)
    assert (recording.start, recording.assumed) == (
        0.0, "1 time stamp is repeated, and samples of one time stamp were averaged",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("time,angle\n" + rows(T, V), {}, "the unit of the position in column 'angle' is not known; give it: rev, rad"),
        (rows(T, V), {"unit": "Hz"}, "unit 'Hz' is not known; give rps, rpm"),
        ("time,t\n" + rows(T, V), {}, "the time may be 'time' or 't'; rename one of them"),
        (rows(T, V), {"speed": 3}, "no column '3'; its columns are 1, 2"),
        ("time,speed\n" + rows(T, V), {"speed": "time"}, "column 'time' cannot be both time and speed"),
        (rows(V), {}, "has no two columns, of time and of speed or position"),
        ("", {}, "cannot be read: it is empty; export it again"),
        ("Dear colleague,\nplease find the recording attached\n", {}, "has no line of numbers"),
        ("time,speed\n0,1\n0.002,\n0.004,1\n0.006,1\n", {}, "line 3 has no number in column 'speed'; fix or cut it"),
        (
            "time,speed\n0,1\n\n0.002,1\n0.004,1\n(end)\n",
            {},
            "line 6 has no number in column 'time' but '(end)'; fix or cut it",
        ),
        (
            "time,speed\n0,1\n0.002,1\n0.002,1\n0.006,1\n",
            {},
            "line 4: time stands still or runs backwards in column 'time'; sort",
        ),
        (rows(np.delete(T, 30), V[1:]), {}, "line 31: time is not uniform in column '1': steps of 0.002 to 0.004"),
    ],
)
def test_a_file_that_cannot_be_read_is_reported_in_one_sentence(tmp_path, text, options, message):
    with pytest.raises(BenchError) as caught:
        read(write(tmp_path, text), **options)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_motor_that_turns_backwards_gives_the_mirrored_signature(tmp_path):
    """The sign is kept: (A, v_t) becomes (-A, -v_t), so that |A| is the same."""
    from problems.backlash.signature.problem import SignatureFit

    t = 0.002 * np.arange(2401)
    speed = 100 + np.sin(2 * np.pi * 2.5 * t) ** 3
    forwards, backwards = (SignatureFit("a", Recording(0.0, 0.002, sign * speed)) for sign in (1, -1))
    x = np.random.default_rng(0).uniform(forwards.lower, forwards.upper, (20, 7))
    mirrored = x * [-1, 1, 1, 1, -1, 1, 1]
    np.testing.assert_allclose(backwards.evaluate(mirrored), forwards.evaluate(x), rtol=1e-9)
    assert forwards.describe(x[0])["amplitude_rpm"] == backwards.describe(mirrored[0])["amplitude_rpm"]


@pytest.mark.parametrize(
    ("first", "stamp"),
    [
        ("2026-06-01T12:00:00.000Z", "{:%Y-%m-%dT%H:%M:%S.%f}Z"),
        ("2026-06-01 12:00:00+02:00", "{:%Y-%m-%d %H:%M:%S.%f}+02:00"),
        ("1.6.2026 12:00:00,000", "{0.day}.{0.month}.{0.year} {0:%H:%M:%S},{0.microsecond:06d}"),
        ("31.12.2026 23:59:59,950", "{:%d.%m.%Y %H:%M:%S,%f}"),
        ("13/06/2026 12:00:00.5 CEST", "{:%d/%m/%Y %H:%M:%S.%f} CEST"),
        ("01-06-2026 12:00:00", "{:%d-%m-%Y %H:%M:%S.%f}"),
        ("12:00:00,000", "{:%H:%M:%S},{0.microsecond:06d}".replace("{:%H", "{0:%H")),
    ],
)
@pytest.mark.parametrize("kind", ["csv", "xlsx"])
def test_dates_and_times_count_from_the_first_sample(tmp_path, first, stamp, kind):
    start = pd.to_datetime(first.removesuffix(" CEST").replace(",", "."), dayfirst="2026-" not in first)
    at = [stamp.format(start + pd.Timedelta(milliseconds=2 * i)) for i in range(50)]
    if kind == "csv":
        speed = [f"{v:.4f}".replace(".", ",") for v in V]
        text = "Zeit;Drehzahl [1/s]\n" + "\n".join(map(";".join, zip(at, speed, strict=True)))
        recording = read(write(tmp_path, text))
    else:
        pd.DataFrame({"Zeit": at, "Drehzahl [1/s]": V}).to_excel(tmp_path / "a.xlsx", index=False)
        recording = read(tmp_path / "a.xlsx")
    assert (recording.start, recording.dt) == (0.0, pytest.approx(0.002, rel=1e-9))
    np.testing.assert_allclose(recording.speed, V, rtol=1e-12)
    assert recording.assumed == f"time counts from {at[0]}"


@pytest.mark.parametrize(
    "preamble",
    [
        "Scope export;\nSample time;2\nDate;2026-06-01\n\n",
        "# device: X20\n# 500 Hz\n",
        "Project;Line 7;robot 3\nOperator: Müller\n",
        "".join(f"Parameter {i};{i}\n" for i in range(40)),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "cp1252"])
def test_a_preamble_before_the_heading_is_passed_over(tmp_path, preamble, encoding):
    text = f"{preamble}t [ms];Geschwindigkeit [°/s]\n" + rows(1e3 * T, V, separator=";")
    recording = read(write(tmp_path, text.encode(encoding)))
    np.testing.assert_allclose(recording.speed, V / 360, rtol=1e-12)
    assert (recording.dt, recording.assumed) == (pytest.approx(0.002), "")


LONG = 0.002 * np.arange(1000)
SMOOTH = 100 + 0.5 * np.sin(40 * LONG)
HEADING = "time_s,speed_rps\n"


@pytest.mark.parametrize("lost", [[17], [17, 18, 300, 700], [500]])
def test_few_missing_samples_are_filled_in_with_a_note(tmp_path, lost):
    path = write(tmp_path, HEADING + rows(np.delete(LONG, lost), np.delete(SMOOTH, lost)))
    recording = read(path)
    np.testing.assert_allclose(recording.speed, SMOOTH, atol=2e-3)
    assert recording.assumed == f"{len(lost)} of 1000 samples are missing; the recording was resampled to equal steps"
    cells = [f"{t:.6f},{'' if i in lost else f'{v:.6f}'}" for i, (t, v) in enumerate(zip(LONG, SMOOTH, strict=True))]
    empty = read(write(tmp_path, HEADING + "\n".join(cells), "empty.csv"))
    np.testing.assert_allclose(empty.speed, recording.speed, rtol=1e-12)


def test_jitter_is_resampled_with_a_note(tmp_path):
    stamps = LONG + 0.002 * np.random.default_rng(3).uniform(-0.25, 0.25, len(LONG))
    recording = read(write(tmp_path, HEADING + rows(stamps, 100 + 0.5 * np.sin(40 * stamps))))
    assert recording.assumed == "the time steps are unequal; the recording was resampled to equal steps"
    np.testing.assert_allclose(recording.speed, 100 + 0.5 * np.sin(40 * recording.time), atol=2e-3)


@pytest.mark.parametrize("lost", [range(100, 112), range(0, 1000, 50), range(300, 306)])
def test_many_missing_samples_or_a_long_gap_are_refused_with_the_line(tmp_path, lost):
    lost = [i for i in lost if i]
    path = write(tmp_path, HEADING + rows(np.delete(LONG, lost), np.delete(SMOOTH, lost)))
    with pytest.raises(BenchError, match=f"line {lost[0] + 2}: time is not uniform in column 'time_s': steps of"):
        read(path)
