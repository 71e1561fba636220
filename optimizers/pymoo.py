"""The single-objective optimizers of pymoo, as ``pymoo:DE`` and so on."""

from __future__ import annotations

import inspect
import warnings
from copy import deepcopy
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import version
from itertools import product
from typing import Any, ClassVar, Literal

import numpy as np

from bench.errors import BenchError
from bench.objective import Objective
from bench.optimizer import Optimizer, parameter
from bench.plugins.derived import derive
from bench.problem import Floats
from optimizers.cma_es import CMAES, SILENT, UNLIMITED
from optimizers.common.bibtex import JONES, STORN
from optimizers.common.family import Adapter, Family, global_random_state

FOLDER = "pymoo.algorithms.soo.nonconvex"

MEMBERS: dict[str, tuple[str, str, str]] = {
    "BIPOPCMAES": ("cmaes", "restarts sigma tolfun tolx incpopsize pop_size normalize",
                   "CMA-ES with restarts in two regimes of population sizes, as pymoo's copy of cma's fmin runs it."),
    "BRKGA": ("brkga", "n_elites n_offsprings n_mutants bias", "A biased random-key genetic algorithm."),
    "CMAES": ("cmaes", "sigma tolfun tolx restarts incpopsize bipop pop_size normalize",
              "CMA-ES, as pymoo's copy of cma's fmin runs it."),
    "DE": ("de", "pop_size variant F CR jitter prob_mut n_offsprings", "Differential evolution with a mutation."),
    "DIRECT": ("direct", "eps penalty n_max_candidates n_max_archive archive_reduct", "DIRECT, dividing rectangles."),
    "EPPSO": ("pso_ep", "pop_size topology init_V", "A particle swarm whose weights evolve with its particles."),
    "ES": ("es", "n_offsprings pop_size rule phi gamma", "A (mu, lambda) evolution strategy with its own step sizes."),
    "G3PCX": ("g3pcx", "pop_size n_offsprings n_parents family_size",
              "The generalized generation gap model with parent-centric crossover."),
    "GA": ("ga", "pop_size n_offsprings eliminate_duplicates",
           "A genetic algorithm: tournaments, simulated binary crossover, polynomial mutation."),
    "ISRES": ("isres", "n_offsprings pop_size rule phi gamma alpha", "The improved stochastic ranking strategy."),
    "NRBO": ("nrbo", "pop_size deciding_factor", "The Newton-Raphson-based optimizer."),
    "NelderMead": ("nelder", "n_sample_points", "The simplex of Nelder and Mead, with parameters for its dimension."),
    "PSO": ("pso", "pop_size w c1 c2 adaptive initial_velocity max_velocity_rate pertube_best",
            "A particle swarm, adaptive by fuzzy states."),
    "RandomSearch": ("random_search", "n_points_per_iteration", "Uniform random search."),
    "SRES": ("sres", "n_offsprings pop_size rule phi gamma", "The stochastic ranking evolution strategy."),
    "SimpleCMAES": ("cmaes", "sigma n_sample_points normalize", "CMA-ES by cma's ask and tell."),
}  # fmt: skip
"""pymoo's classes that are members: the module, the parameters under pymoo's names, and a description."""

LEFT_OUT = {
    "it searches binary strings": "BGA",
    "no seed repeats its runs: it draws from a generator that the operating system seeds": "NicheGA PatternSearch",
    "it wraps a package that pymoo does not install": "Optuna",
}
"""The other single-objective algorithms of pymoo, which are no members, by the reason."""

KEYWORDS: dict[str, Any] = {"F": 0.5, "CR": 0.2, "jitter": False, "prob_mut": 0.1}
"""Defaults of the parameters that DE accepts as keywords only: those of pymoo's ``Variant``."""

CHOICES: dict[str, tuple[str, ...]] = {
    "init_V": ("zero", "random"),
    "initial_velocity": ("random", "zero"),
    "topology": ("star", "ring"),
    "variant": tuple(
        "/".join(("DE", *parts))
        for parts in product(("best", "rand", "target-to-best"), "12", ("bin", "exp", "hypercube", "line"))
    ),
}

MINIMA: dict[str, float] = {
    "CR": 0, "F": 0, "bias": 0, "family_size": 1, "incpopsize": 1, "n_elites": 1, "n_max_archive": 2,
    "n_max_candidates": 1, "n_mutants": 0, "n_offsprings": 1, "n_parents": 3, "n_points_per_iteration": 1,
    "n_sample_points": 1, "pop_size": 3, "prob_mut": 0, "restarts": 0, "rule": 0.001, "sigma": 1e-9,
}  # fmt: skip
MAXIMA: dict[str, float] = {"CR": 1, "archive_reduct": 1, "bias": 1, "prob_mut": 1, "rule": 0.5}

LIBRARY = """
    @article{blank2020,
      author = {Blank, Julian and Deb, Kalyanmoy},
      title = {pymoo: Multi-Objective Optimization in {Python}},
      journal = {IEEE Access},
      volume = {8},
      pages = {89497--89509},
      year = {2020},
      doi = {10.1109/ACCESS.2020.2990567},
    }
"""

WORKS = {
    "BRKGA": """
    @article{goncalves2011,
      author = {Gon{\\c{c}}alves, Jos{\\'e} Fernando and Resende, Mauricio G. C.},
      title = {Biased random-key genetic algorithms for combinatorial optimization},
      journal = {Journal of Heuristics},
      volume = {17},
      pages = {487--525},
      year = {2011},
      doi = {10.1007/s10732-010-9143-1},
    }
""",
    "CMAES": CMAES.bibtex,
    "DE": STORN,
    "DIRECT": JONES,
    "ISRES": """
    @article{runarsson2005,
      author = {Runarsson, Thomas Philip and Yao, Xin},
      title = {Search Biases in Constrained Evolutionary Optimization},
      journal = {IEEE Transactions on Systems, Man, and Cybernetics, Part C},
      volume = {35},
      number = {2},
      pages = {233--243},
      year = {2005},
      doi = {10.1109/TSMCC.2004.841906},
    }
""",
    "NelderMead": """
    @article{nelder1965,
      author = {Nelder, J. A. and Mead, R.},
      title = {A Simplex Method for Function Minimization},
      journal = {The Computer Journal},
      volume = {7},
      number = {4},
      pages = {308--313},
      year = {1965},
      doi = {10.1093/comjnl/7.4.308},
    }
""",
    "PSO": """
    @inproceedings{kennedy1995,
      author = {Kennedy, James and Eberhart, Russell},
      title = {Particle Swarm Optimization},
      booktitle = {Proceedings of ICNN'95, International Conference on Neural Networks},
      pages = {1942--1948},
      year = {1995},
      doi = {10.1109/ICNN.1995.488968},
    }
""",
    "SRES": """
    @article{runarsson2000,
      author = {Runarsson, Thomas P. and Yao, Xin},
      title = {Stochastic Ranking for Constrained Evolutionary Optimization},
      journal = {IEEE Transactions on Evolutionary Computation},
      volume = {4},
      number = {3},
      pages = {284--294},
      year = {2000},
      doi = {10.1109/4235.873238},
    }
""",
}
"""BibTeX of the works that some members come from; all members cite pymoo's too."""

OPERATORS = "Its operators (selection, crossover, mutation, survival) are no scalars and keep pymoo's defaults."
TWENTY_POINTS = "It starts from the best of 20 points, and their number cannot be changed."

UNMAPPED: dict[str, tuple[str, ...]] = {
    "BIPOPCMAES": (TWENTY_POINTS,),
    "BRKGA": (OPERATORS, "Its mutants are drawn by pymoo, and repaired when they are evaluated."),
    "CMAES": (TWENTY_POINTS,),
    "DE": ("The distribution index of its mutation is pymoo's.",),
    "DIRECT": ("It starts at the centre of the box, and no seed changes its run.",),
    "EPPSO": ("The weights of its swarm adapt themselves within pymoo's bounds, and have no start value.",),
    "G3PCX": ("The probabilities of its crossover and mutation keep pymoo's values.",),
    "GA": (OPERATORS,),
    "NelderMead": ("The size of its first simplex is fixed in pymoo's code, and its tolerances keep pymoo's values.",),
    "RandomSearch": ("Its points are drawn by pymoo, and repaired when they are evaluated.",),
}

AGENTS = {"pop_size": "agents"}
"""Parameters with another name here than in pymoo."""


@dataclass(frozen=True)
class PymooOptimizer(Adapter):
    """An algorithm of pymoo, which evaluates a generation as one batch.

    The start population, or the points of which a local search takes the best, come from ``objective.initial``.
    The budget replaces pymoo's default termination, a set of tolerances and limits. Criteria of the algorithm itself
    end a run early, and are declared: the tolerances of cma and of Nelder and Mead's simplex, and a mating that finds
    nothing new. pymoo sees values above 1e100, +inf among them, as 1e100.
    """

    solver: ClassVar[Any]  # pymoo's class
    own: ClassVar[tuple[str, ...]]  # the parameters of its constructor, by pymoo's names

    def __post_init__(self) -> None:
        """Check every parameter, by pymoo's own rules too; raises BenchError for one that does not fit."""
        super().__post_init__()
        self._algorithm()

    def _algorithm(self) -> Any:
        """Return pymoo's object; raises BenchError for parameters that pymoo refuses."""
        options = {name: getattr(self, AGENTS.get(name, name)) for name in self.own}
        try:
            return deepcopy(self.solver(**options))  # its operators are shared defaults of the constructor
        except Exception as error:  # pymoo raises AssertionError, ValueError and plain Exception alike
            raise BenchError(f"pymoo refuses these parameters of {type(self).__name__}: {error}") from error

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent, or the algorithm ends by a criterion of its own."""
        with global_random_state(rng), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the harness records what pymoo and cma warn of
            algorithm = self._algorithm()
            reason = prepare(algorithm, objective)
            problem = self._problem(objective)
            seed = int(rng.integers(1, 2**31))  # cma takes 0 for no seed
            algorithm.setup(problem, termination=algorithm.termination, seed=seed)
            while algorithm.has_next():
                algorithm.next()
        objective.stop(reason)

    def _problem(self, objective: Objective) -> Any:
        """Return the objective as pymoo's problem."""
        from pymoo.core.problem import Problem

        class Box(Problem):  # type: ignore[misc]
            def _evaluate(problem, x: Floats, out: dict[str, Any], *_: Any, **__: Any) -> None:  # noqa: N805
                out["F"] = self.finite_values(objective, x)[:, np.newaxis]

        return Box(n_var=objective.dimension, n_obj=1, xl=objective.lower, xu=objective.upper)


def prepare(algorithm: Any, objective: Objective) -> str:
    """Set the algorithm's start and length; returns the only reason for which it can end early."""
    from pymoo.algorithms.soo.nonconvex.nelder import NelderAndMeadTermination, NelderMead
    from pymoo.core.population import Population
    from pymoo.core.termination import NoTermination

    if hasattr(algorithm, "initialization"):
        algorithm.initialization.sampling = lambda _, n, **__: Population.new(X=objective.initial(n))
    if hasattr(algorithm, "max_iteration"):
        algorithm.max_iteration = -(-objective.budget // algorithm.pop_size)
    for options in ("options", "opts"):
        if hasattr(algorithm, options):
            getattr(algorithm, options).update(UNLIMITED | SILENT)
            algorithm.termination = NoTermination()
            return "a tolerance of cma"
    if isinstance(algorithm, NelderMead):
        algorithm.termination = NelderAndMeadTermination(n_max_iter=np.inf, n_max_evals=np.inf)
        return "x_tol, f_tol or a flat simplex"
    algorithm.termination = NoTermination()
    return "no new offspring"


class Pymoo(Family):
    """The family ``pymoo:<class>``: pymoo's single-objective algorithms for real variables."""

    name = "pymoo"
    module = "pymoo"
    extra = "pymoo"
    left_out = LEFT_OUT

    def members(self) -> list[str]:
        """Return the names in MEMBERS."""
        return list(MEMBERS)

    def derive(self, member: str) -> type[Optimizer]:
        """Return the optimizer class of a pymoo class."""
        from pymoo.config import Config

        Config.warnings["not_compiled"] = False  # else pymoo prints that it runs without its compiled modules
        module, names, text = MEMBERS[member]
        solver = getattr(import_module(f"{FOLDER}.{module}"), member)
        own = tuple(names.split())
        return derive(
            PymooOptimizer, f"pymoo:{member}", {AGENTS.get(name, name): declared(solver, name) for name in own},
            self.load, __doc__=text, bibtex=WORKS.get(member, "") + LIBRARY, code=f"pymoo {version('pymoo')}",
            unmapped=UNMAPPED.get(member, ()), solver=solver, own=own,
        )  # fmt: skip


pymoo = Pymoo()


def declared(solver: type, name: str) -> tuple[Any, Any]:
    """Return type and default, with its range, of a parameter of a pymoo class."""
    signatures = [inspect.signature(vars(each)["__init__"]).parameters for each in solver.__mro__[:-1]]
    default = next((each[name].default for each in signatures if name in each), KEYWORDS.get(name))
    if name in CHOICES:
        return Literal[CHOICES[name]], default
    kind = (int | None) if default is None else type(default)
    return kind, parameter(default, minimum=MINIMA.get(name), maximum=MAXIMA.get(name))
