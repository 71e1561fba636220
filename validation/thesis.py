"""Compute what docs/explanation/thesis.md says of the thesis's claims.

    python validation/thesis.py
    python validation/thesis.py --runs

The first command reads the committed trials of the thesis's comparison and the printed tables (seconds). The second one
makes runs (ten minutes or more): CMA-ES on the noisy recordings of Table 7.3, from starts that differ a little and with
the first setting (7.1.1); joints with the gaps of 7.1.2, with other gears (chapter 4), and the wrist (8.3).
"""

import argparse
from dataclasses import dataclass, replace
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
from scipy.stats import spearmanr

import bench
from optimizers.cma_es import CMAES
from problems.backlash.joint import DEFAULT, load_joint, simulate, with_noise
from problems.backlash.published.recordings import table_7_3
from problems.backlash.recordings import Recording
from problems.backlash.report.fitting_errors import ORDER, SWARMS, ordered, published
from problems.backlash.sensor.estimate import Settings, estimate
from problems.backlash.signature.calibration import EQUATION_4_7
from problems.backlash.signature.datasets import dataset

RESULTS = Path(__file__).resolve().parents[1] / "results"
PEAK = {level: 60 * dataset(level).peak for level in range(1, 21)}  # rpm
BAND = 3.8672 / 2  # rpm; Delta A / 2 of section 7.2.3
NAMES = list(SWARMS)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", action="store_true")
    parts = (
        (noise, starts, first_setting, two_recordings, gears, wrist, joint_5)
        if parser.parse_args().runs
        else (table_7_2, figure_7_4, printed)
    )
    for part in parts:
        for line in part():
            print(line, flush=True)


def committed():
    """Return the committed trials, with the dataset, the expected amplitude and the relative error."""
    trials = pd.read_csv(RESULTS / "thesis" / "trials.csv")
    trials["level"] = trials["problem"].str[-2:].astype(int)
    trials["expected"] = trials["level"].map(PEAK)
    trials["error"] = trials["amplitude_rpm"] - trials["expected"]
    return trials


def table_7_2():
    """Yield lines on the agreement with Table 7.2; each cell is a mean of 30 runs, there as here."""
    cells = committed().groupby(["level", "optimizer"])["fun"]
    means, sds, theirs = cells.mean().unstack(), cells.std().unstack()[NAMES], published()[NAMES]
    ratio = means[NAMES] / theirs
    off = (ratio - 1).abs().to_numpy()
    chi2 = (((means[NAMES] - theirs) / sds) ** 2 * 30 / 2).sum()
    near = f"half within {np.median(off):.1%}, at most {off.max():.1%}"
    yield f"Table 7.2: {(off <= 0.25).sum()} of {off.size} cells within 25%, {near}"
    yield f"order {' < '.join(ORDER)}: {ordered(means[NAMES])} of 18 rows here, {ordered(theirs)} printed"
    yield "mean of a swarm's cells, here / printed - 1: " + words(100 * (ratio.mean() - 1), "+.1f", "%")
    yield f"chi² {chi2.sum():.1f} over 72 cells with the SDs here: " + words(chi2, ".1f")
    yield f"printed: lowest {counts(theirs.idxmin(axis=1))}; highest {counts(theirs.idxmax(axis=1))}"


def figure_7_4():
    """Yield lines on what section 7.2.3 reads off Fig. 7.4."""
    trials = committed()
    yield f"smallest step of the amplitude: {np.diff(list(PEAK.values())).min():.3f} rpm"
    yield "below the expected amplitude: " + words(
        100 * (trials["error"] < 0).groupby(trials["optimizer"]).mean(), ".0f", "%"
    )
    cells = trials.groupby(["level", "optimizer"])["amplitude_rpm"]
    sd = cells.std().unstack()
    relative = sd.div(pd.Series(PEAK), axis=0).dropna()
    for name, scatter, digits in (("SD, rpm", sd, ".1f"), ("SD / A", relative, ".2f")):
        ranks = pd.Series({each: spearmanr(scatter.index, scatter[each])[0] for each in scatter})
        for level in (3, 20):
            yield f"{name}, dataset {level}: " + words(scatter.loc[level], digits)
        yield f"{name}, rank correlation with the gap: " + words(ranks, "+.2f")
    boxes = (cells.quantile(0.75) - cells.quantile(0.25)).unstack()[NAMES]
    yield f"smallest box of the four swarms: {counts(boxes.idxmin(axis=1))}"
    yield from second_half(trials[trials["optimizer"].isin(NAMES)])


def second_half(swarms):
    """Yield a line a swarm on where the fits start that underestimate by more than the band.

    A fit to the second half of the oscillation alone starts at least half a period of the ringing after the best fit.
    """
    best = {
        level: bench.load_problem(f"signature-{level:02d}", unit="rpm").reference(constrained=True).x for level in PEAK
    }
    low = swarms[swarms["error"] < -BAND]
    x = np.array([best[level] for level in low["level"]])
    late = (
        low["x_t0"] + low["x_T1"] - x[:, 1] - x[:, 5] + 0.02
    ) % 0.2 - 0.02  # s, from -0.02 on; an impact every 0.2 s
    second = (late >= pi / x[:, 3]) & (late < 0.1)
    near = late < 0.5 * pi / x[:, 3]
    yield f"underestimates by more than {BAND:.2f} rpm: {len(low)} of {len(swarms)} runs of the swarms"
    yield "  that start half a period or more later than the best fit: " + words(
        100 * second.groupby(low["optimizer"]).mean(), ".0f", "%"
    )
    yield "  that start within a quarter of one, or up to 20 ms before: " + words(
        100 * near.groupby(low["optimizer"]).mean(), ".0f", "%"
    )
    damping = words(low.groupby("optimizer")["x_tau"].median(), ".1f")
    usual = np.median([fit[2] for fit in best.values()])
    yield f"  their median damping, 1/s: {damping}; of the best fits {usual:.1f}"


def printed():
    """Yield lines on what the printed Table 7.3 and section 7.1.2 say by themselves."""
    table = table_7_3().drop(0)
    theirs = table["theoretical"]
    ours = pd.Series(PEAK)[theirs.index] / 60
    below = 100 * (1 - ours / theirs)
    yield f"peaks here below Table 7.3's theoretical A by {below.min():.1f} to {below.max():.1f}%"
    error = (table["mean"] / theirs - 1).abs()
    halves = f"five smaller gaps {error[:5].mean():.1%}, five larger {error[5:].mean():.1%}"
    yield f"Table 7.3, rank correlation of error and gap: {spearmanr(theirs, error)[0]:+.2f}; {halves}"
    off = np.abs(np.polyval(EQUATION_4_7, 60 * table["mean"]) - np.polyval(EQUATION_4_7, 60 * theirs))
    yield f"Table 7.3 by eq. 4.7: at most {off.max():.0f}e-6 rad, {off[0]:.0f}e-6 rad at the smallest gap"
    yield f"delta by eq. 4.7 of A_1 and A_2: {np.polyval(EQUATION_4_7, [30.9033, 39.2197]).round(1)} e-6 rad"
    yield f"Table 7.4: mean of .6263 and .7246 is {(0.6263 + 0.7246) / 2:.5f}"


def noise():
    """Yield lines on the error of CMA-ES in 'bench run noise', by the truth here and by that of Table 7.3."""
    study = bench.Study.load("noise")
    wanted = [entry for entry in study.problems if entry.options.get("noise") == "low" and entry.name != "noisy-00"]
    only = replace(study, problems=tuple(wanted), optimizers=tuple(e for e in study.optimizers if e.name == "cma-es"))
    with TemporaryDirectory() as folder:
        bench.run(only, folder, verify=False)
        frame = bench.load_results(folder)
    found = frame.groupby("problem", observed=True)["amplitude_rpm"].mean() / 60
    found.index = found.index.astype(str).str[6:8].astype(int)
    table = table_7_3().loc[found.index]
    truths = {
        "the peak of the same simulated joint": pd.Series(PEAK)[found.index] / 60,
        "Table 7.3's theoretical A": table["theoretical"],
        "the fit to the recording without noise": pd.Series({level: clean_fit(level) for level in found.index}),
    }
    yield f"mean |A| here / printed mean - 1: {words(100 * (found / table['mean'] - 1), '+.0f', '%')}"
    for name, truth in truths.items():
        here, theirs = ((each / truth - 1).abs().mean() for each in (found, table["mean"]))
        yield f"mean relative error against {name}: {here:.2%} here, {theirs:.2%} of the printed means"


def clean_fit(level):
    problem = bench.load_problem(f"signature-{level:02d}", unit="rps")
    return abs(problem.reference().x[0])


@dataclass(frozen=True)
class Moved(CMAES):
    """CMA-ES whose start is moved from the box's midpoint by a share of the box's width in every variable."""

    share: float = 0.0

    def mean(self, objective):
        """Return the moved midpoint."""
        return (objective.lower + objective.upper) / 2 + self.share * (objective.upper - objective.lower)


def starts(runs=20):
    """Yield lines on how many runs of CMA-ES end elsewhere (RMSE differs by over 1%) by another start, or seed."""
    problem = bench.load_problem("signature-12", unit="rps")
    ends = {}
    for share in (0.0, 1e-9, 1e-4, 0.01, 0.05):
        searching = Moved(agents=300, handling="box", share=share)
        ends[share] = np.array([bench.solve(problem, searching, budget=60_000, seed=seed).fun for seed in range(runs)])
    best = problem.reference().value
    for share, values in ends.items():
        other = np.mean(np.abs(values / ends[0.0] - 1) > 0.01)
        found = np.mean(values <= 1.01 * best)
        ended = f"{other:.0%} of {runs} seeds end elsewhere, {found:.0%} at the best fit"
        yield f"CMA-ES from the midpoint moved by {share:g} of the box: {ended}"
    seeds = np.mean([abs(a / b - 1) > 0.01 for i, a in enumerate(ends[0.0]) for b in ends[0.0][:i]])
    yield f"CMA-ES from the midpoint, two seeds: {seeds:.0%} of pairs end apart"


def first_setting(runs=10):
    """Yield a line on CMA-ES with the 3,500 agents and 100 iterations of section 7.1.1."""
    problem = bench.load_problem("signature-12", unit="rps", amplitude_factor=1.0)
    searching = CMAES(agents=3500, handling="box", start="midpoint")
    ends = [bench.solve(problem, searching, budget=350_000, seed=seed).fun for seed in range(runs)]
    best = problem.reference().value
    found = np.mean(np.array(ends) <= 1.01 * best)
    yield f"3,500 agents: {min(ends):.4f} to {max(ends):.4f} rps, {found:.0%} of {runs} at the best fit, {best:.4f} rps"


def two_recordings():
    """Yield a line a joint with a gap of section 7.1.2, at the speed of the bench and with noise like Fig. 7.1's."""
    for gap, theirs, seed in ((0.00068539, 0.515055, 1), (0.00095394, 0.653661, 2)):
        speed = simulate(load_joint(speed_rps=98.04), half_gap=gap).speed
        noisy = with_noise(speed, 0.4, np.random.default_rng(seed))
        found = estimate(Recording(0.0, 0.002, noisy), Settings(gear_ratio=40.0, calibration=None, resamples=0))
        size = abs(found.fit.variables["A"])
        yield f"half-gap {gap:g} rad: |A| {size:.3f} rps, printed {theirs:.3f}; RMSE {found.fit.rmse_rps:.2f} rps"


def gears():
    """Yield a line a kind of joint: the verdicts without a gap and with one of 1.1 mrad."""
    kinds = {
        "the bench": {},
        "gear ratio 20": {"gear_ratio": 20.0},
        "gear ratio 80": {"gear_ratio": 80.0},
        "gear ratio 160": {"gear_ratio": 160.0},
        "half its stiffness": {"stiffness": 0.5 * DEFAULT.gear.stiffness},
        "four times its stiffness": {"stiffness": 4 * DEFAULT.gear.stiffness},
        "three times its damping": {"damping": 3 * DEFAULT.gear.damping},
        "a third of its damping": {"damping": DEFAULT.gear.damping / 3},
        "speed of 30 rps": {"omega_ref": 2 * pi * 30},
    }
    for name, change in kinds.items():
        joint, cells = load_joint(**change), []
        for gap in (0.0, 0.0011):
            speed = simulate(joint, half_gap=gap, duration=12 * joint.turn).speed
            speed = speed + 0.1 * np.random.default_rng(1).uniform(-0.5, 0.5, len(speed))
            recording = Recording(0.0, 0.002, speed)
            try:
                found = estimate(recording, Settings(gear_ratio=joint.gear.gear_ratio, calibration=None, resamples=0))
                cells.append(found.verdict)
            except bench.BenchError:  # such as a speed that the controller does not hold
                cells.append("refused")
        yield f"{name}: without a gap {cells[0]}; with one {cells[1]}"


def wrist():
    """Yield a line a joint and state of 'bench run wrist'."""
    with TemporaryDirectory() as folder:
        bench.run("wrist", folder, verify=False)
        frame = bench.load_results(folder)
    for problem, group in frame.groupby("problem", observed=True):
        sizes = group["amplitude_rpm"] / 60
        yield f"{problem}: |A| {sizes.mean():.3f} ± {sizes.std():.3f} rps"


def joint_5(draws=20):
    """Yield lines on the best fits to joint 5 of the wrist over draws of its noise."""
    fits = {
        state: np.array(
            [abs(bench.load_problem(f"wrist-5-{state}", draw=draw).reference().x[0]) for draw in range(draws)]
        )
        for state in ("healthy", "tampered")
    }
    for state, sizes in fits.items():
        yield f"joint 5, {state}: |A| of the best fit {sizes.mean():.3f} ± {sizes.std(ddof=1):.3f} rps"
    wrong = np.mean(np.subtract.outer(fits["tampered"], fits["healthy"]) < 0)
    yield f"joint 5, a healthy draw above a tampered one: {wrong:.0%} of pairs"


def words(values, digits, unit=""):
    return ", ".join(f"{name} {value:{digits}}{unit}" for name, value in values.items())


def counts(names):
    return ", ".join(f"{name} {count}" for name, count in names.value_counts().items())


if __name__ == "__main__":
    main()
