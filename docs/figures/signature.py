"""A recording of a simulated joint with backlash: the motor's speed over one load turn, and the fitted signature."""

from matplotlib.figure import Figure

import bench


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    problem = bench.load_problem("noisy-12", noise="low")
    shown = problem.time <= problem.time[0] + problem.period
    fit = problem.model(problem.reference().x)
    figure = Figure()
    ax = figure.subplots()
    ax.plot(problem.time[shown], problem.signal[shown], color=ink, alpha=0.6, linewidth=0.8, label="recorded")
    ax.plot(problem.time[shown], fit[shown], color="#E69F00", label="fitted signature")
    ax.set(xlabel="time (s)", ylabel="speed less its mean (rps)")
    ax.legend(loc="upper right")
    return figure
