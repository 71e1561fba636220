"""Measure the accuracy of the virtual sensor on simulated recordings with noise and a random start.

    python validation/sensor.py [--draws 10] [--resamples 200]
    python validation/sensor.py --elsewhere

The recordings are those of levels 2 to 20 of section 7.2.1 with both levels of noise of section 7.3, and as many
signals of noise alone: white, coloured, and with the load's ripple of a joint without backlash. Print the relative
errors of the amplitude and of the fit's |A|, the errors of the backlash, how often the intervals hold the truth, and
the right, open and wrong verdicts. With --elsewhere, print the errors of the backlash, in 1e-6 rad, where the default
calibration is used for joints with another motor speed or gear ratio, without noise.
"""

import argparse
from dataclasses import replace
from math import pi
from time import perf_counter

import numpy as np
import pandas as pd

from problems.backlash import EARLY_RAD
from problems.backlash.joint import Joint, simulate
from problems.backlash.recordings import Recording
from problems.backlash.sensor.estimate import Settings, estimate
from problems.backlash.signature.calibration import sensor_calibration
from problems.backlash.signature.datasets import noisy, peak_to_peak


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=10)
    parser.add_argument("--resamples", type=int, default=200)
    parser.add_argument("--elsewhere", action="store_true")
    options = parser.parse_args()
    if options.elsewhere:
        print(elsewhere().round(0).astype(int).to_string())
        return
    settings = Settings(resamples=options.resamples)
    estimate(noisy(3), settings)  # compile before the clock starts
    rows = []
    for noise in ("low", "high"):
        for level in range(2, 21):
            for draw in range(options.draws):
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
        ", ".join(f"{kind} {right} of {of}" for kind, right, of in healthy(options.draws)),
    )


def row(noise, level, made, found, seconds):
    low, high = found.amplitude_interval_rps
    least, most = found.interval_rad
    truth = "early" if made.half_gap <= EARLY_RAD else "progressed"
    return {
        "noise": noise,
        "level": level,
        "amplitude": found.amplitude_rps / made.peak - 1,
        "fit's |A|": abs(found.variables["A"]) / made.peak - 1,
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
            ("speed", Joint(omega_ref=2 * pi * 100 * factor)),
            ("gear ratio", Joint(gear_ratio=40 * factor)),
        ):
            settings = Settings(resamples=0, gear_ratio=joint.gear_ratio, calibration=everywhere)
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
        for draw in range(draws):
            rng = np.random.default_rng(draw)
            white = peak_to_peak(1, noise) * rng.uniform(-0.5, 0.5, len(ripple))
            coloured = np.convolve(white, 0.8 ** np.arange(30), "same")
            for kind, speed in (("white", 100 + white), ("coloured", 100 + coloured), ("with ripple", ripple + white)):
                signals[kind].append(Recording(0.0, 0.002, speed))
        for kind, recordings in signals.items():
            verdicts = [estimate(recording, settings).verdict for recording in recordings]
            yield f"{kind}, {noise}", verdicts.count("no backlash"), len(verdicts)


if __name__ == "__main__":
    main()
