"""Count the planted defects that ``bench check`` finds in optimizers and problems, and its false alarms in good ones.

    python validation/planted_defects.py > validation/planted_defects.txt

The first 22 are those that the rules were written for. The ten new ones, in ``validation/planted``, were written down
before they were run. A defect is found where a rule fails, or where a parameter is named that has no effect and has one
in the sound method. The last column is the time of the processor, of all processes.
"""

import os
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

from planted import optimizers, problems

from bench.check.checker import Checkup, check_optimizer, check_problem
from bench.contract.optimizer import Optimizer

KNOWN = {
    "faulty_problems": (
        "Coarse", "CoarsePoints", "CoarseInside", "RoundedPoints", "Idle", "Chunked", "Wide", "Padded", "Tiring",
        "Drifting", "Local", "Unsearched",
    ),
    "unrepeatable": ("Fixed", "Stale", "Timed", "Counting", "Cached", "Legacy", "Hashing"),
    "faulty": ("Surplus", "Escaping", "Rounding"),
}  # fmt: skip
NEW = {
    problems: ("Cached", "Ageing", "WrongSide", "Undefined", "OneCoarse"),
    optimizers: ("DriftingLeaders", "LostBest", "CoolingClock", "OldState", "ForgottenValues"),
}
GOOD = (
    optimizers.Swarm, optimizers.Wolves, optimizers.Evolution, optimizers.Annealing, optimizers.HookeJeeves,
    optimizers.CommaStrategy, optimizers.Chains, optimizers.Asked, "random-search", "cma-es-fast", "bipop-cma-es",
    "gwo", "alo", "goa", "da", "minion:LSHADE", "minion:NelderMead", "scipy:differential_evolution",
    "mealpy:OriginalPSO", "mealpy:OriginalWOA",
)  # fmt: skip


def checked(plugin: object) -> Checkup:
    """Return the verdicts of the rules."""
    is_optimizer = isinstance(plugin, str) or (isinstance(plugin, type) and issubclass(plugin, Optimizer))
    return check_optimizer(plugin, bias=False) if is_optimizer else check_problem(plugin)  # type: ignore[arg-type]


def processor_seconds() -> float:
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def row(name: str, plugin: object, traits: bool) -> bool:
    """Print what is found in a plug-in, and return whether anything is."""
    before = processor_seconds()
    made = checked(plugin)
    found = [verdict.check for verdict in made if not verdict.passed]
    if traits:
        found += [
            verdict.finding.partition(" (")[0] for verdict in made if verdict.finding.startswith("without effect")
        ]
    print(f"  {name:28} {', '.join(found) or '-':48} {processor_seconds() - before:5.1f} s", flush=True)
    return bool(found)


def count(title: str, plugins: list[tuple[str, object]], traits: bool = True) -> None:
    """Print what is found in each, and the number of those in which anything is; a trait of a good one is no alarm."""
    print(title)
    found = [row(name, plugin, traits) for name, plugin in plugins]
    print(f"  {sum(found)} of {len(found)}\n", flush=True)


def members(modules: dict[ModuleType, tuple[str, ...]]) -> list[tuple[str, object]]:
    return [(name, getattr(module, name)) for module, names in modules.items() for name in names]


def main() -> None:
    package = ModuleType("tests")  # this repository's, though another package may have installed one of that name
    package.__path__ = [str(Path(__file__).parents[1] / "tests")]
    sys.modules["tests"] = package
    known = {import_module(f"tests.bench.check.{name}"): names for name, names in KNOWN.items()}
    count("Planted defects for which the rules were written", members(known))
    count("New ones", members(NEW))
    count("Good ones", [(each if isinstance(each, str) else each.__name__, each) for each in GOOD], False)


if __name__ == "__main__":
    main()
