"""Print the biases of the built-in optimizers that ``bench check`` measures, as a table in Markdown.

Run with ``python validation/diagnosis.py``; names after it pick optimizers. To diagnose another, add it to OPTIMIZERS.
"""

import sys
from typing import Any

from bench import load_optimizer
from bench.check.bias import diagnose
from bench.check.verdict import Verdict

OPTIMIZERS: list[tuple[str, dict[str, Any]]] = [
    ("random-search", {}),
    ("gwo", {}),
    ("gwo", {"agents": 300}),
    ("gwo", {"variant": "cascade"}),
    ("alo", {}),
    ("alo", {"agents": 300}),
    ("alo", {"variant": "paper"}),
    ("goa", {}),
    ("goa", {"agents": 300}),
    ("goa", {"variant": "full-distance"}),
    ("da", {}),
    ("da", {"agents": 300}),
    ("cma-es", {}),
    ("cma-es", {"agents": 300, "handling": "box", "start": "midpoint"}),
    ("cma-es-fast", {}),
    ("bipop-cma-es", {}),
    ("bipop-cma-es", {"variant": "pycma", "sigma": 0.25}),
]


def cell(verdict: Verdict) -> str:
    """Return the number that a verdict is based on, in bold where the optimizer did not pass."""
    number = "-" if verdict.figure is None else f"{verdict.figure:.2g}"
    return number if verdict.passed else f"**{number}**"


def main() -> None:
    print("| optimizer | centre bias: ratio | structural bias: p | on a bound: share | starts: p |")
    print("|-|-:|-:|-:|-:|")
    for name, options in OPTIMIZERS:
        if sys.argv[1:] and name not in sys.argv[1:]:
            continue
        label = ", ".join([f"`{name}`", *(f"{key} = {value}" for key, value in options.items())])
        verdicts = diagnose(load_optimizer(name, **options))
        print(f"| {label} | {' | '.join(map(cell, verdicts))} |", flush=True)
        for verdict in verdicts:
            print(f"{label}: {verdict.check}: {verdict.finding}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
