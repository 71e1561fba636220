"""The families ``cec2011`` … ``cec2022``: the CEC competitions on real-parameter optimization, computed by minionpy.

minionpy (MIT licence) has the organisers' C code for 2014 to 2022 and a C++ translation of their Matlab code for 2011.
Sources, all technical reports of Nanyang Technological University, Singapore, unless noted:

- 2011: Das and Suganthan 2010, Problem Definitions and Evaluation Criteria for CEC 2011 Competition on Testing
  Evolutionary Algorithms on Real World Optimization Problems, Jadavpur University. f04, f21 and f22 are left out: by
  minionpy's own comparison with the Matlab code at 1,000 points, 986, 75 and 89 of their values are wrong. 239 values
  of f03 differ by up to 5e-6, relatively
- 2014: Liang, Qu and Suganthan 2013, Problem Definitions … CEC 2014 …, 201311
- 2017: Awad, Ali, Liang, Qu and Suganthan 2016, Problem Definitions … CEC 2017 …; f02 was withdrawn by the organisers.
  The report defines f06 as a rotated expanded Schaffer F6; the organisers' code computes F7 of the shifted point
- 2019: Price, Awad, Ali and Suganthan 2018, Problem Definitions … for the 100-Digit Challenge …
- 2020: Yue, Price, Suganthan, Liang, Ali, Qu, Awad and Biswas 2019, Problem Definitions … CEC 2020 …, 201911;
  the competition left f06 and f07 out in 5 dimensions
- 2022: Kumar, Price, Mohamed, Hadi and Suganthan 2021, Problem Definitions … CEC 2022 …; the same holds for its f03
"""

from __future__ import annotations

import tomllib
from functools import partial
from importlib.resources import files
from pathlib import Path

import numpy as np

from bench import Problem
from bench.contract.families import Grid, Member
from bench.contract.typing import Floats
from bench.helpers.errors import require
from problems.common import Suite, SuiteProblem, features_of

LEFT_OUT = {"cec2011": (4, 21, 22), "cec2017": (2,)}
"""The functions that a suite has no problem for, by number."""

REAL_WORLD = (6, 30, 1, 1, 30, 30, 20, 7, 126, 12, 120, 240, 6, 13, 15, 40, 140, 96, 96, 96, 26, 22)
"""The dimensions of the problems of 2011."""

OPTIMA = {("cec2011", 1): 0.0, ("cec2019", 3): 13.7120622568 - 12.375**2 / 12.046875}
"""Optimal values that minionpy does not have, by suite and number.

Of the problems of 2011, only the first has a proven optimum: its data are made by known parameters. f03 of 2019 is the
energy of six atoms plus a constant with ten decimals, so that the optimum is 1; their octahedron, the lowest energy
known (Hoare and Pal 1971), is 9e-12 below it: with s = 1/r⁶, the least of (12 + 3/8²) s² - 2 (12 + 3/8) s.
"""

SUITES: dict[str, dict[str, list[str]]] = tomllib.loads(
    files("problems").joinpath("cec.toml").read_text(encoding="utf-8")
)
"""What the functions of each group of each suite are called, in the order of their numbers."""


def _dimensions(suite: str, number: int) -> tuple[int, ...]:
    """Return the dimensions that a competition has a function in."""
    if suite == "cec2011":
        return (REAL_WORLD[number - 1],)
    if suite == "cec2019":
        return ({1: 9, 2: 16, 3: 18}.get(number, 10),)
    if suite == "cec2020":
        return (10, 15, 20) if number in (6, 7) else (5, 10, 15, 20)
    return (10, 20) if suite == "cec2022" else (10, 30, 50, 100)


_DATA_2020 = dict(zip(range(1, 11), (1, 2, 3, 7, 4, 16, 6, 22, 24, 25), strict=True))
"""Where the data of a function of 2020 lie: it took over functions of 2014 and 2017, whose numbers the files keep."""


def _optimum_point(suite: str, number: int, dimension: int, package: Path) -> Floats | None:
    """Return the point where the organisers moved a function's optimum to, from minionpy's copy of their data.

    None where there is no such point: the functions of 2011 and the first three of 2019 are not moved, and Levy's
    function of 2017 (f09) has its optimum beside it. The organisers' code does not move f04 of 2020 either.
    """
    if suite == "cec2011" or (suite == "cec2019" and number < 4) or (suite, number) == ("cec2017", 9):
        return None
    if (suite, number) == ("cec2020", 4):
        return np.zeros(dimension)
    file = _DATA_2020[number] if suite == "cec2020" else number
    data = package / "cec_input_data" / f"input_data_{suite[3:]}" / f"shift_data_{file}.txt"
    return np.array(data.read_text(encoding="utf-8").split()[:dimension], dtype=np.float64)


def _suite(suite: str) -> Suite:
    functions = [(group, title) for group, titles in SUITES[suite].items() for title in titles]
    numbers = [number for number in range(1, len(functions) + 1) if number not in LEFT_OUT.get(suite, ())]
    dimensions = {f"f{number:02d}": _dimensions(suite, number) for number in numbers}
    titles = {f"f{number:02d}": functions[number - 1][1] for number in numbers}
    groups = [group for group, _ in functions]
    return Suite(Grid(suite, dimensions, titles=titles), partial(_problem, suite, groups))


def _problem(suite: str, groups: list[str], name: str, member: Member) -> Problem:
    minionpy = require("minionpy", "suites", f"problem {name!r} needs")
    number = int(member.function[1:])
    function = getattr(minionpy, f"CEC{suite[3:]}Functions")(number, member.dimension)
    lower, upper = np.array(function.get_bounds(), dtype=np.float64).T
    features = features_of(suite, member, groups[number - 1])
    optimum = OPTIMA.get((suite, number), function.get_f_opt())
    best = _optimum_point(suite, number, member.dimension, Path(str(minionpy.__file__)).parent)

    def evaluate(x: Floats) -> Floats:
        values = np.array(function(x.tolist()), dtype=np.float64)  # lists take half the time of arrays
        values[np.isnan(values)] = np.inf
        return values

    known = {"optimum": optimum, "optimum_point": best, "features": features}
    return SuiteProblem(evaluate, lower, upper, name=name, **known)


cec2011 = _suite("cec2011")
cec2014 = _suite("cec2014")
cec2017 = _suite("cec2017")
cec2019 = _suite("cec2019")
cec2020 = _suite("cec2020")
cec2022 = _suite("cec2022")
