"""Measure the accuracy of the virtual sensor on simulated recordings with noise and a random start.

    python validation/sensor.py [--draws 10] [--first 0] [--resamples 200]
    python validation/sensor.py --elsewhere
    python validation/sensor.py --healthy [--draws 10]
    python validation/sensor.py --worn [--draws 10]
    python validation/sensor.py --lost [--draws 60]
    python validation/sensor.py --changed [--draws 5]

The recordings are those of levels 2 to 20 of section 7.2.1 with both levels of noise of section 7.3, and as many
signals of noise alone: white, coloured, and with the load's ripple of a joint without backlash. Print the relative
errors of the amplitude and of the fit's |A|, the errors of the backlash, how often the intervals hold the truth, and
the right, open and wrong verdicts. With --elsewhere, print the errors of the backlash, in 1e-6 rad, where the default
calibration is used for joints with another motor speed or gear ratio, without noise.

With --healthy, print how often a joint without a gap gets a verdict of backlash, a row a family of disturbances, and a
column a source of the time of a load turn. With --worn, print the same of joints with a gap: how often it is found,
missed or left open, the errors of the half-gap, and how often its interval holds it; of joints with friction by a
calibration of that joint and by the default one. A rate has its standard error.

With --lost, print the verdicts on joints with and without a gap, of whose recordings one to five blocks of 8 to 80 ms
are lost without a gap in time, and on the same recordings with nothing lost: "said" counts the recordings of which the
sensor says where samples are lost. With --changed, print of joints whose load, stiffness or controller is not that of
the default calibration how often the sensor says so, and the error of the half-gap that it gives otherwise.
"""

import argparse
from dataclasses import replace
from math import pi
from time import perf_counter

import numpy as np
import pandas as pd
from scipy.signal import lfilter

from bench.helpers.errors import BenchError
from problems.backlash import EARLY_RAD
from problems.backlash.joint import DEFAULT, load_joint, simulate
from problems.backlash.recordings import Recording
from problems.backlash.sensor.estimate import Settings, estimate
from problems.backlash.sensor.load_turn import fold
from problems.backlash.sensor.response import response
from problems.backlash.signature.calibration import calibrate, sensor_calibration
from problems.backlash.signature.datasets import noisy, peak_to_peak

TIME = 0.002 * np.arange(2401)  # s
ALARMS = ("early", "progressed", "backlash")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=10)
    parser.add_argument(
        "--first", type=int, default=0, help="number of the first draw: others than the sensor was made on"
    )
    parser.add_argument("--resamples", type=int, default=200)
    for name in ("--elsewhere", "--healthy", "--worn", "--lost", "--changed"):
        parser.add_argument(name, action="store_true")
    options = parser.parse_args()
    draws = range(options.first, options.first + options.draws)
    asked = {
        false_alarms: options.healthy,
        found_gaps: options.worn,
        lost_blocks: options.lost,
        other_joints: options.changed,
    }
    for function in (function for function, is_asked in asked.items() if is_asked):
        for line in function(draws):
            print(line, flush=True)
        return
    if options.elsewhere:
        print(elsewhere().round(0).astype(int).to_string())
        return
    settings = Settings(resamples=options.resamples)
    estimate(noisy(3), settings)  # compile before the clock starts
    rows = []
    for noise in ("low", "high"):
        for level in range(2, 21):
            for draw in draws:
                made = noisy(level, noise, draw)
                started = perf_counter()
                found = estimate(made, settings)
                rows.append(row(noise, level, made, found, perf_counter() - started))
    frame = pd.DataFrame(rows)
    for noise, own in frame.groupby("noise", sort=False):
        print(f"{noise} noise: {len(own)} recordings, levels 2 to 20")
        for name in ("amplitude", "fit's |A|"):
            error = own[name].abs()
            print(f"  {name}: error {error.median():.1%} in the median, {error.max():.1%} at most")
        print(
            f"  backlash: error {own['gap'].abs().median():.2g} rad in the median, {own['gap'].abs().max():.2g} at most"
        )
        held, gap_held = own["held"].mean(), own["gap held"].mean()
        print(f"  the 95% interval holds the amplitude in {held:.0%}, the backlash in {gap_held:.0%}")
        print(f"  verdicts: {', '.join(f'{count} {kind}' for kind, count in own['judged'].value_counts().items())}")
    print(f"an estimate took {frame['seconds'].median():.2f} s in the median, {frame['seconds'].max():.2f} s at most")
    print(
        "no backlash, with that verdict:",
        ", ".join(f"{kind} {right} of {of}" for kind, right, of in healthy(draws)),
    )


def row(noise, level, made, found, seconds):
    low, high = found.amplitude_interval_rps
    least, most = found.interval_rad
    truth = "early" if made.half_gap <= EARLY_RAD else "progressed"
    return {
        "noise": noise,
        "level": level,
        "amplitude": found.amplitude_rps / made.peak - 1,
        "fit's |A|": abs(found.fit.variables["A"]) / made.peak - 1,
        "gap": found.backlash_rad - made.half_gap,
        "held": low <= made.peak <= high,
        "gap held": least <= made.half_gap <= most,
        "judged": {truth: "right", "undecided": "undecided"}.get(found.verdict, "wrong"),
        "seconds": seconds,
    }


def elsewhere():
    """Return the errors of the backlash in 1e-6 rad: a row a change in per cent, a column a quantity and half-gap."""
    everywhere = replace(sensor_calibration(), gear_ratio=None, speed_rps=None)
    errors = {}
    for change in (-5, -2, -1, 0, 1, 2, 5):
        factor = 1 + change / 100
        for what, joint in (
            ("speed", load_joint(omega_ref=2 * pi * 100 * factor)),
            ("gear ratio", load_joint(gear_ratio=40 * factor)),
        ):
            settings = Settings(resamples=0, gear_ratio=joint.gear.gear_ratio, calibration=everywhere)
            for gap in (0.0005, 0.0011, 0.0021, 0.0031, 0.0039):
                speed = simulate(joint, half_gap=gap, duration=12 * joint.turn).speed
                found = estimate(Recording(0.0, 0.002, speed), settings)
                errors[f"{change:+d} %", what, gap] = 1e6 * (found.backlash_rad - gap)
    return pd.Series(errors).unstack([1, 2], sort=False)


def healthy(draws):
    """Yield a kind of signal without backlash, how many of its draws got that verdict, and their number."""
    settings, ripple = Settings(resamples=0), simulate(half_gap=0.0).speed
    for noise in ("low", "high"):
        signals = {"white": [], "coloured": [], "with ripple": []}
        for draw in draws:
            rng = np.random.default_rng(draw)
            white = peak_to_peak(1, noise) * rng.uniform(-0.5, 0.5, len(ripple))
            coloured = np.convolve(white, 0.8 ** np.arange(30), "same")
            for kind, speed in (("white", 100 + white), ("coloured", 100 + coloured), ("with ripple", ripple + white)):
                signals[kind].append(Recording(0.0, 0.002, speed))
        for kind, recordings in signals.items():
            verdicts = [estimate(recording, settings).verdict for recording in recordings]
            yield f"{kind}, {noise}", verdicts.count("no backlash"), len(verdicts)


def tones(rng, count, low=3.0, high=60.0):
    """Return steady tones of 0.1 to 1 rps and log-uniform frequencies in Hz."""
    frequency, size = np.exp(rng.uniform(*np.log([low, high]), count)), rng.uniform(0.1, 1.0, count)
    phase = rng.uniform(0, 2 * pi, count)
    return (size * np.sin(2 * pi * np.outer(TIME, frequency) + phase)).sum(axis=1)


def harmonics(rng, numbers, size=0.1):
    """Return harmonics of the load turn, of one size in rps and random phases."""
    return size * np.sin(2 * pi * np.outer(TIME, numbers) / 0.4 + rng.uniform(0, 2 * pi, len(numbers))).sum(axis=1)


def resonant(rng, poles):
    """Return noise of 0.1 rps (rms) that is white noise through a filter with these poles and their conjugates."""
    conjugated = np.concatenate([poles, poles[np.imag(poles) != 0].conj()])
    made = lfilter([1.0], np.poly(conjugated).real, rng.standard_normal(len(TIME) + 5000))[5000:]
    return 0.1 * made / made.std()


def by_quality(rng, low, high):
    """Return noise that rings at 3 to 40 Hz with a log-uniform quality."""
    frequency, quality = np.exp(rng.uniform(*np.log([3, 40]))), np.exp(rng.uniform(*np.log([low, high])))
    s = 2 * pi * frequency * (-1 / (2 * quality) + 1j * np.sqrt(1 - 1 / (4 * quality**2)))
    return resonant(rng, np.exp([s * 0.002]))


def by_order(rng, order):
    """Return autoregressive noise of an order, of random stable poles."""
    poles = rng.uniform(0.5, 0.98, order // 2) * np.exp(1j * rng.uniform(0, 0.6, order // 2))
    return resonant(rng, np.concatenate([poles, rng.uniform(-0.5, 0.98, order % 2)]))


HEALTHY = {
    "white noise": lambda rng: 0.1 * rng.standard_normal(len(TIME)),
    "tone, 3 to 60 Hz": lambda rng: tones(rng, 1),
    "tone of 0.8 rps at 22.5 Hz": lambda rng: 0.8 * np.sin(2 * pi * 22.5 * TIME + rng.uniform(0, 2 * pi)),
    "tone near the ringing, 18 to 25 Hz": lambda rng: tones(rng, 1, 18, 25),
    "two tones, 3 to 60 Hz": lambda rng: tones(rng, 2),
    "three tones, 10 to 40 Hz": lambda rng: tones(rng, 3, 10, 40),
    "hum, 50 Hz and 25 Hz": lambda rng: tones(rng, 1, 49.9, 50.1) + tones(rng, 1, 24.95, 25.05),
    "harmonic of the load turn, 1 to 20": lambda rng: harmonics(rng, rng.integers(1, 21, 1)),
    "four harmonics, 1 to 20": lambda rng: harmonics(rng, rng.choice(20, 4, replace=False) + 1),
    "odd harmonics 1 to 19": lambda rng: harmonics(rng, np.arange(1, 20, 2), 0.05),
    "harmonics 1 to 20": lambda rng: harmonics(rng, np.arange(1, 21), 0.05),
    "harmonic and tone": lambda rng: harmonics(rng, rng.integers(1, 21, 1)) + tones(rng, 1),
    "resonant noise, Q 1 to 10": lambda rng: by_quality(rng, 1, 10),
    "resonant noise, Q 10 to 30": lambda rng: by_quality(rng, 10, 30),
    "resonant noise, Q 30 to 100": lambda rng: by_quality(rng, 30, 100),
    "AR noise, order 1": lambda rng: by_order(rng, 1),
    "AR noise, order 2": lambda rng: by_order(rng, 2),
    "AR noise, order 5": lambda rng: by_order(rng, 5),
    "drift, a random walk": lambda rng: np.cumsum(0.003 * rng.standard_normal(len(TIME))),
}


def rate(flags):
    """Return a share in per cent with its standard error, as text."""
    share = np.mean(flags)
    return f"{100 * share:3.0f} ± {100 * np.sqrt(share * (1 - share) / len(flags)):2.0f}"


def false_alarms(draws):
    """Yield a line a family: how often impacts are seen in it, and which verdicts follow with and without a ratio."""
    ripple = simulate(half_gap=0.0).speed
    many = range(draws.start, draws.start + 5 * len(draws))
    yield f"{'family':36}  impacts with --gear-ratio ({len(many)} recordings), per cent;"
    yield f"{'':36}  alarm, undecided with --gear-ratio; without it ({len(draws)} recordings)"
    for family, make in HEALTHY.items():
        verdicts, impacts = {40.0: [], None: []}, []
        for draw in many:
            rng = np.random.default_rng([draw, 44])
            speed = ripple + make(rng) + rng.uniform(0.1, 0.5) * rng.uniform(-0.5, 0.5, len(ripple))
            recording = Recording(0.0, 0.002, speed)
            impacts.append(fold(recording, 0.4).impacting)  # there is no alarm without them
            for ratio, found in verdicts.items() if draw in draws else ():
                found.append(estimate(recording, Settings(gear_ratio=ratio, resamples=0)).verdict)
        cells = (
            f"{rate([verdict in ALARMS for verdict in found])}, {rate([verdict == 'undecided' for verdict in found])}"
            for found in verdicts.values()
        )
        yield f"{family:36}  {'; '.join([rate(impacts), *cells])}"


def found_gaps(draws):
    """Yield a line a kind of joint and noise."""
    yield f"{'joint, half-gaps in mrad, noise in rps':52}  detected, missed, undecided; error median, most; >10 %; held"
    for share in (0.03, 0.06, 0.1, 0.17, 0.3):
        joint = load_joint(coulomb_friction=share * DEFAULT.load.gravity_torque)
        for name, calibration in (("own", calibrated(joint)), ("default", sensor_calibration())):
            settings = Settings(gear_ratio=40.0, calibration=calibration)
            yield gap_line(
                f"friction {share:.0%}, {name} calibration", joint, (0.7, 1.5, 2.6, 3.5), 0.2, draws, settings
            )
    for gaps in ((0.15,), (0.3,), (0.7, 1.5), (2.6, 3.5)):
        for noise in (0.12, 0.35, 0.7):
            yield gap_line("default", DEFAULT, gaps, noise, draws, Settings())
    for beside in (0.3, 0.8):
        yield gap_line(f"default, tone of {beside} rps", DEFAULT, (0.5, 1.5), 0.2, draws, Settings(), beside)
    for change in ({"gear_ratio": 55.0}, {"gear_ratio": 30.0}, {"omega_ref": 2 * pi * 70}, {"load_inertia": 0.55}):
        joint = load_joint(**change)
        name = f"{next(iter(change))} {next(iter(change.values())):.4g}, own calibration"
        try:
            settings = Settings(gear_ratio=joint.gear.gear_ratio, calibration=calibrated(joint))
        except BenchError as refusal:
            yield f"{name}: {refusal}"
            continue
        yield gap_line(name, joint, (0.7, 1.5), 0.2, draws, settings)
    settings = Settings(gear_ratio=40.0)
    yield gap_line("viscous friction of 14%", load_joint(viscous_friction=0.129), (0.7, 1.5), 0.2, draws, settings)


def without_blocks(rng, speed, blocks):
    """Return a speed without so many random blocks of 8 to 80 ms."""
    kept = np.ones(len(speed), dtype=bool)
    for _ in range(blocks):
        first = int(rng.integers(100, len(speed) - 100))
        kept[first : first + int(rng.uniform(0.008, 0.08) / 0.002)] = False
    return speed[kept]


def worn(rng):
    """Return a half-gap of 0.5 to 3.5 mrad, and the speed of a joint with it, with noise, of 9 to 15 load turns."""
    gap, friction = rng.uniform(0.5e-3, 3.5e-3), rng.choice([0.0, 0.05])
    joint = load_joint(coulomb_friction=friction * DEFAULT.load.gravity_torque)
    speed = simulate(joint, half_gap=gap, duration=16 * joint.turn).speed
    first = int(rng.integers(200))
    speed = speed[first : first + int(rng.integers(9 * 200, 15 * 200))]
    return gap, speed + rng.uniform(0.05, 0.4) * rng.uniform(-0.5, 0.5, len(speed))


def lost_blocks(draws):
    """Yield a line a number of lost blocks: the verdicts on worn joints, and on joints without a gap."""
    yield f"{'joints and blocks lost':36}  no backlash, wrong side of the limit, half-gap >20 % off; undecided; said"
    for blocks in range(6):
        found = []
        for draw in draws:
            rng = np.random.default_rng([draw, 60, blocks])
            gap, speed = worn(rng)
            settings = Settings(gear_ratio=rng.choice([40.0, None]), resamples=40)
            found.append((gap, estimate(Recording(0.0, 0.002, without_blocks(rng, speed, blocks)), settings)))
        flags = (
            [made.verdict == "no backlash" for _, made in found],
            [made.verdict == ("early" if gap > EARLY_RAD else "progressed") for gap, made in found],
            [abs(made.backlash_rad / gap - 1) > 0.2 and made.verdict in ALARMS for gap, made in found],
            [made.verdict == "undecided" for _, made in found],
            [any("lost" in note for note in made.notes) for _, made in found],
        )
        yield f"{f'worn, {blocks}':36}  {'; '.join(map(rate, flags))}"
    few = draws[: len(draws) // 4]
    yield f"{'no gap, blocks lost, disturbance':36}  alarm; undecided; said lost; of {len(few)} recordings"
    ripple = simulate(half_gap=0.0).speed
    for family, make in HEALTHY.items():
        for blocks in (0, 3):
            found = []
            for draw in few:
                rng = np.random.default_rng([draw, 61, blocks])
                speed = ripple + make(rng) + rng.uniform(0.1, 0.5) * rng.uniform(-0.5, 0.5, len(ripple))
                settings = Settings(gear_ratio=rng.choice([40.0, None]), resamples=0)
                found.append(estimate(Recording(0.0, 0.002, without_blocks(rng, speed, blocks)), settings))
            flags = (
                [made.verdict in ALARMS for made in found],
                [made.verdict == "undecided" for made in found],
                [any("lost" in note for note in made.notes) for made in found],
            )
            yield f"{f'{family}, {blocks}':36}  {'; '.join(map(rate, flags))}"


CHANGED = {
    "as calibrated": {},
    "payload +30 %": {"load_inertia": 1.3, "gravity_torque": 1.3},
    "payload -30 %": {"load_inertia": 0.7, "gravity_torque": 0.7},
    "payload +10 %": {"load_inertia": 1.1, "gravity_torque": 1.1},
    "stiffness -30 %": {"stiffness": 0.7},
    "stiffness +30 %": {"stiffness": 1.3},
    "damping -50 %": {"damping": 0.5},
    "gain of the speed loop -20 %": {"speed_gain": 0.8},
    "gain of the speed loop +20 %": {"speed_gain": 1.2},
}


def other_joints(draws, noises=(0.1, 0.3, 0.75)):
    """Yield a line a change of the joint and noise: how often it is said, and the error where it is not."""
    yield f"{'joint, noise in rps':36}  said; no backlash; error of the half-gap, median, most, where it is given"
    for name, factors in CHANGED.items():
        joint = load_joint(**{key: factor * DEFAULT.parameters[key] for key, factor in factors.items()})
        for noise in noises:
            found = []
            for gap in (0.3e-3, 0.5e-3, 1.1e-3, 2.1e-3, 3.1e-3):
                motion = simulate(joint, half_gap=gap, duration=13 * joint.turn)
                for draw in draws:
                    rng = np.random.default_rng([draw, 62, round(1e6 * gap), round(100 * noise)])
                    speed = motion.speed[int(rng.integers(200)) :][: len(TIME)]
                    speed = speed + noise * rng.uniform(-0.5, 0.5, len(speed))
                    found.append((gap, estimate(Recording(0.0, 0.002, speed), Settings(resamples=0))))
            errors = [abs(made.backlash_rad / gap - 1) for gap, made in found if made.backlash_rad > 0]
            said = rate([any("calibrate this joint" in note for note in made.notes) for _, made in found])
            missed = rate([made.verdict == "no backlash" for _, made in found])
            of = f"{np.median(errors):.1%}, {np.max(errors):.1%}, {len(errors)} of {len(found)}" if errors else "none"
            yield f"{f'{name}, {noise}':36}  {said}; {missed}; {of}"


def calibrated(joint):
    gaps = np.linspace(0.3e-3, 3.8e-3, 8)
    return replace(calibrate(joint, gaps), **response(joint, gaps))


def gap_line(name, joint, gaps, noise, draws, settings, beside=0.0):
    """Return the line on recordings of half-gaps near these, in mrad, with a tone of ``beside`` rps."""
    verdicts, errors, held = [], [], []
    for gap in gaps:
        for draw in draws:
            rng = np.random.default_rng([draw, round(1e3 * gap), round(1e3 * noise)])
            half_gap = 1e-3 * gap * rng.uniform(0.85, 1.15)
            motion = simulate(joint, half_gap=half_gap, duration=13 * joint.turn)
            first = int(rng.integers(joint.turn / 0.002))
            speed = motion.speed[first:][: round(12 * joint.turn / 0.002) + 1]
            speed = speed + noise * rng.uniform(-0.5, 0.5, len(speed))
            if beside:
                phase, frequency = rng.uniform(0, 2 * pi), np.exp(rng.uniform(*np.log([3, 60])))
                speed = speed + beside * np.sin(2 * pi * frequency * 0.002 * np.arange(len(speed)) + phase)
            found = estimate(Recording(0.0, 0.002, speed), replace(settings, resamples=40))
            verdicts.append(found.verdict)
            if found.verdict in ALARMS and not np.isnan(found.backlash_rad):
                errors.append(abs(found.backlash_rad / half_gap - 1))
                held.append(found.interval_rad[0] <= half_gap <= found.interval_rad[1])
    shares = "; ".join(
        rate([verdict in kinds for verdict in verdicts]) for kinds in (ALARMS, ("no backlash",), ("undecided",))
    )
    of = (
        f"{np.median(errors):.1%}, {np.max(errors):.1%}; {rate(np.array(errors) > 0.1)}; {rate(held)}" if errors else ""
    )
    return f"{f'{name}, {gaps}, {noise}':52}  {shares}; {of}"


if __name__ == "__main__":
    main()
