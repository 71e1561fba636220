"""Draw the thesis's Figs. 4.5 to 4.8, of the transmission, the signals and the disturbance, for any joint."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from bench.helpers import replacing
from bench.plots import style
from problems.backlash.joint import DEFAULT, Joint, simulate
from problems.backlash.joint.simulator import variable_stiffness
from problems.backlash.signature.calibration import EQUATION_4_7, Calibration

DELTA, SHORT, AMPLITUDE = "half-gap δ in 1e-6 rad", "δ in 1e-6 rad", "amplitude A in rpm"


def save_figures(folder: Path, joint: Joint, calibration: Calibration) -> list[Path]:
    """Write the four figures as svg into a folder, created if missing, and return their paths.

    Raises:
        BenchError: for files that cannot be written.
    """
    paths = []
    with style.context():
        for name, figure in (
            ("stiffness", stiffness(joint, calibration.half_gap.tolist())),
            ("signals", signals(joint, float(calibration.half_gap[-1]))),
            ("disturbances", disturbances(joint, calibration.half_gap.tolist())),
            ("calibration", calibration_curve(calibration, thesis=joint == DEFAULT)),
        ):
            path = folder / f"{name}.svg"
            with replacing(path) as temporary:
                folder.mkdir(parents=True, exist_ok=True)
                FigureCanvasSVG(figure).print_svg(temporary, metadata={"Date": None})  # type: ignore[no-untyped-call]
            paths.append(path)
    return paths


def stiffness(joint: Joint, half_gaps: Sequence[float]) -> Figure:
    """Return Fig. 4.5: the stiffness of eq. 4.5 across the smallest and the largest gap of some half-gaps in rad."""
    figure = Figure(figsize=(style.COLUMN, 2.2), layout="constrained")
    ax = figure.subplots()
    twist = np.linspace(-1.5 * half_gaps[-1], 1.5 * half_gaps[-1], 2001)
    for gap, color in zip((half_gaps[0], half_gaps[-1]), style.PALETTE[:2], strict=True):
        found = variable_stiffness(twist, gap, joint.gear.stiffness, joint.gear.sharpness)
        ax.plot(1e6 * twist, found, color=color, linewidth=1.0, label=f"{1e6 * gap:.0f}")
    ax.set_xlabel("angle across the transmission in 1e-6 rad")
    ax.set_ylabel("stiffness in N m/rad")
    ax.legend(title=SHORT, title_fontsize="small")
    return figure


def signals(joint: Joint, gap: float) -> Figure:
    """Return Fig. 4.6, simulated: position, speed and current of the motor over one load turn, without and with a gap.

    The position is drawn less the reference speed's, of which a disturbance is a small part.
    """
    figure = Figure(figsize=(style.PAGE, 3.6), layout="constrained")
    axes = figure.subplots(3, sharex=True)
    for half_gap_rad, color in ((0.0, style.REFERENCE), (gap, style.PALETTE[0])):
        motion = simulate(joint, half_gap=half_gap_rad, duration=joint.turn).fine
        position = motion.position - joint.drive.omega_ref * motion.time
        for ax, values in zip(axes, (position, motion.speed, motion.current), strict=True):
            ax.plot(motion.time, values, color=color, linewidth=0.8, label=f"{1e6 * half_gap_rad:.0f}")
    for ax, label in zip(axes, ("position less\nreference in rad", "speed in rps", "current in A"), strict=True):
        ax.set_ylabel(label)
    axes[-1].set_xlabel("time in s, over one load turn")
    axes[0].legend(title=SHORT, title_fontsize="small")
    return figure


def disturbances(joint: Joint, half_gaps: Sequence[float]) -> Figure:
    """Return Fig. 4.7: the motor speed less its reference over one load turn, one line a half-gap in rad."""
    figure = Figure(figsize=(style.PAGE, 2.8), layout="constrained")
    ax = figure.subplots()
    shades = colormaps["viridis_r"].resampled(256)
    largest = half_gaps[-1]
    scale = Normalize(half_gaps[0] - 0.1 * largest, largest)  # skips the palest colours, which are hard to see on white
    for gap in half_gaps:
        motion = simulate(joint, half_gap=gap, duration=joint.turn).fine
        deviation = motion.speed - joint.nominal_speed
        ax.plot(motion.time, deviation, color=shades(scale(gap)), linewidth=0.8, label=f"{1e6 * gap:.0f}")
    ax.set_xlim(0, joint.turn)
    ax.set_xlabel("time in s, over one load turn")
    ax.set_ylabel("speed less reference in rps")
    if len(half_gaps) <= style.MANY_NAMES:
        figure.legend(loc="outside right upper", title=SHORT, title_fontsize="small", reverse=True)
    return figure


def calibration_curve(calibration: Calibration, *, thesis: bool = False) -> Figure:
    """Return Fig. 4.8: the simulated pairs and the curve from amplitude to half-gap, with eq. 4.7 on request."""
    figure = Figure(figsize=(style.COLUMN, 2.6), layout="constrained")
    ax = figure.subplots()
    between = np.linspace(*calibration.range, 301)
    if thesis:
        published = np.polyval(EQUATION_4_7, between)
        ax.plot(between, published, "--", color=style.REFERENCE, linewidth=1.0, label="eq. 4.7 of the thesis")
    curve = 1e6 * np.array([calibration.backlash(a) for a in between])
    ax.plot(between, curve, color=style.PALETTE[0], linewidth=1.0, label="calibration")
    ax.plot(calibration.amplitude, 1e6 * calibration.half_gap, "o", color="black", markersize=3, label="simulated")
    ax.set_xlabel(AMPLITUDE)
    ax.set_ylabel(DELTA)
    ax.legend()
    return figure
