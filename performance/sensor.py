"""Measure the accuracy of the virtual sensor on simulated recordings with noise and a random start.

    python performance/sensor.py [--draws 10] [--resamples 200]

The recordings are those of levels 2 to 20 of section 7.2.1 with both levels of noise of section 7.3, and as many
signals of noise alone: white, coloured, and with the load's ripple of a joint without backlash. Print the relative
errors of the amplitude and of the fit's |A|, the errors of the backlash, how often the intervals hold the truth, and
the shares of right verdicts.
"""

import argparse
from time import perf_counter

import numpy as np
import pandas as pd

from problems.backlash.joint import simulate
from problems.backlash.recordings import Recording
from problems.backlash.sensor.estimate import EARLY_RAD, Settings, estimate
from problems.backlash.signature.datasets import noisy, peak_to_peak


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=10)
    parser.add_argument("--resamples", type=int, default=200)
    options = parser.parse_args()
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
        print(f"  right verdicts: {own['right'].mean():.0%}")
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
        "right": found.verdict == truth,
        "seconds": seconds,
    }


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
