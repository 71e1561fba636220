"""bench tune: tune optimizers on training problems, and write the study that tests them on others."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from bench.cli.console import Jobs, Parameters, interruptible
from bench.errors import BenchError, require
from bench.helpers.atomic import replacing
from bench.helpers.console import duration, pairs, print_line, steps
from bench.helpers.text import option
from bench.numbers import MOST_TRIALS, require_positive, require_seed, require_whole
from bench.plugins import loading
from bench.study import Study
from bench.study.budget import Budget

if TYPE_CHECKING:
    from bench.tuning.tune import Best, TuningSetup


def command(
    optimizers: Annotated[list[str], typer.Argument(metavar="OPTIMIZER…", help="The optimizers, or patterns.")],
    train: Annotated[list[str], typer.Option(help="A problem to tune on, or a pattern; repeatable.")],
    test: Annotated[
        list[str] | None, typer.Option(help="A problem to test on afterwards, or a pattern; repeatable.")
    ] = None,
    leave_out: Annotated[
        str | None,
        typer.Option(metavar="GROUP", help="Test on this group of functions among those of --train, tune on the rest."),
    ] = None,
    configurations: Annotated[int, typer.Option(help="Configurations of each optimizer, the defaults first.")] = 50,
    trials: Annotated[int, typer.Option(help="Trials of a configuration on each training problem.")] = 3,
    budget: Annotated[str, typer.Option(help="Evaluations of a trial: a number, or such as '1e3 * d'.")] = "1e3 * d",
    objective: Annotated[
        str, typer.Option(help="What to minimise: aocc (one less the area over the convergence curve) or regret.")
    ] = "aocc",
    seed: Annotated[int, typer.Option(help="Seed of the tuning, and of the study that it writes.")] = 0,
    jobs: Jobs = -1,
    set_: Parameters = None,
    condition: Annotated[
        list[str] | None,
        typer.Option(help="Tune a condition of the comparison, too: agents, handling or start; repeatable."),
    ] = None,
    timeout: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Wall-clock limit of a trial; one that exceeds it failed.")
    ] = None,
    output: Annotated[
        Path,
        typer.Option("--output", "-o", help="The study to write (TOML); a journal beside it continues a tuning."),
    ] = Path("tuned.toml"),
) -> None:
    """Tune optimizers at the same budget each, and write a study of their default and tuned parameters.

    Training and test problems must differ. The same command continues a tuning that was interrupted, and ends with the
    same study. Parameters of --set are fixed for all optimizers. The conditions of a comparison, agents, handling and
    start, keep their defaults but for those of --condition.
    """
    from bench.report.wording import count
    from bench.tuning import study as studies
    from bench.tuning.tune import OBJECTIVES, TuningSetup, method, spaces
    from bench.tuning.tune import tune as tune_all

    for what, number in (("--configurations", configurations), ("--trials", trials)):
        require_whole(what, number, 1, MOST_TRIALS)
    require_seed("--seed", seed)
    if timeout is not None:
        require_positive("--timeout", timeout, unit="seconds")
    if objective not in OBJECTIVES:
        raise BenchError(f"--objective must be {' or '.join(OBJECTIVES)}, not {objective!r}")
    if output.suffix != ".toml":
        raise BenchError(f"the output {output} must end with .toml")
    optuna = require("optuna", "optuna", "tuning needs")
    names = list(dict.fromkeys(match for pattern in optimizers for match in loading.matching(pattern)))
    training, testing = studies.split(train, test or (), leave_out, seed)
    problems = studies.load(training)
    spent = Budget.read(budget, "--budget")
    setting = TuningSetup(objective, configurations, trials, spent, seed, tuple(training), pairs(set_), timeout)
    _refuse_others(output, setting)
    least = min(setting.budget.evaluations(problem.dimension) for problem in problems.values())
    axes = spaces(names, setting.fixed, least, condition or ())
    studies.untuned(output.stem, testing, names, setting)
    console = Console()
    for name, own_axes in axes.items():
        print_line(f"{name}: {'; '.join(map(str, own_axes))}", console=console)
    size = f"{count(configurations, 'configuration')} of each optimizer, {count(trials, 'trial')} on each of "
    print_line(f"{size}{count(len(training), 'training problem')}", console=console)
    with interruptible("configuration"), steps(console, "tune") as on_progress:
        bests = tune_all(axes, problems, setting, output.with_suffix(".journal"), jobs, on_progress)
    for best in bests:
        print_line(gained(best, OBJECTIVES[objective]), console=console)
    if not any(best.options for best in bests):
        print_line("no study is written, as it would compare the defaults with themselves", console=console)
        return
    about = {"left_out": leave_out or "", "method": method(optuna)}
    written = studies.tuned(output.stem, testing, bests, setting, **about)
    with replacing(output) as temporary:
        temporary.write_text(written.to_toml(), encoding="utf-8")
    print_line(f"study: {output}; test it with: bench run {output}", console=console)


def gained(best: Best, score: str) -> str:
    """Return a line on the tuning of an optimizer: its trials, and its gain in the ``score``."""
    record = best.record
    chosen = ", ".join(f"{key}={_short(value)}" for key, value in best.options.items())
    better = record.best < record.scores[0]
    return (
        f"{record.name}: {len(record.scores)} tried, {record.whole.count(False)} of them stopped early; "
        f"{record.evaluations:,} evaluations in {duration(record.seconds)} of runs; {score} {record.scores[0]:.4g} by "
        f"default{f', {record.best:.4g} with {chosen}' if better else ', and nothing tried is better'}"
    )


def _short(value: object) -> str:
    """Return a parameter's value with four significant digits."""
    return f"{value:.4g}" if isinstance(value, float) else option(value)


def _refuse_others(output: Path, setting: TuningSetup) -> None:
    """Raise BenchError where the output is a file that another tuning, or none, wrote."""
    if not output.exists():
        return
    noted = Study.load(output).tuning
    asked = (setting.objective, setting.runs, setting.budget, setting.seed, list(setting.train))
    if noted is None or (noted.objective, noted.runs, noted.budget, noted.seed, noted.train) != asked:
        what = "is no study that 'bench tune' wrote" if noted is None else "is the study of another tuning"
        raise BenchError(f"{output} is there already, and {what}; give another --output")
