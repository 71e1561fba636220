"""Functions of other libraries for ``bench check SUITE --against libraries.py:NAME``.

Each takes the number of a function, or its name where the suite has names, a dimension and an instance, and returns a
problem with the library's own box and, where it shows it, its optimum.
"""

import importlib

from bench import FunctionProblem


def opfunu(year):
    """Return the adapter of a year's CEC functions in opfunu, which takes a point a call."""

    def load(function, dimension, instance):
        made = getattr(importlib.import_module("opfunu").cec_based, f"F{function}{year}")(ndim=dimension)
        known = {"optimum": made.f_global, "optimum_point": made.x_global}
        return FunctionProblem(made.evaluate, made.lb, made.ub, vectorized=False, **known)

    return load


opfunu2014, opfunu2017, opfunu2019, opfunu2020, opfunu2022 = map(opfunu, (2014, 2017, 2019, 2020, 2022))


def ioh2022(function, dimension, instance):
    """Return ioh's function of CEC 2022, whose first instance is the competition's."""
    ioh = importlib.import_module("ioh")
    made = ioh.get_problem(1000 + function, 1, dimension, ioh.ProblemClass.CEC2022)
    known = {"optimum": made.optimum.y, "optimum_point": made.optimum.x}
    return FunctionProblem(made, made.bounds.lb, made.bounds.ub, vectorized=False, **known)


def ioh_bbob(function, dimension, instance):
    """Return ioh's function of bbob."""
    ioh = importlib.import_module("ioh")
    made = ioh.get_problem(function, instance, dimension, ioh.ProblemClass.BBOB)
    known = {"optimum": made.optimum.y, "optimum_point": made.optimum.x}
    return FunctionProblem(made, made.bounds.lb, made.bounds.ub, vectorized=False, **known)


def evox2022(function, dimension, instance):
    """Return EvoX's function of CEC 2022, in double precision."""
    torch = importlib.import_module("torch")
    torch.set_default_dtype(torch.float64)
    made = importlib.import_module("evox.problems.numerical.cec2022").CEC2022(function, dimension)
    box = [-100] * dimension, [100] * dimension
    return FunctionProblem(lambda x: made.evaluate(torch.tensor(x)).numpy(), *box, vectorized=True)


def pygmo2014(function, dimension, instance):
    """Return pygmo's function of CEC 2014."""
    made = importlib.import_module("pygmo").problem(importlib.import_module("pygmo").cec2014(function, dimension))
    return FunctionProblem(lambda x: made.fitness(x)[0], *made.get_bounds(), vectorized=False)


def pymoo_bbob(function, dimension, instance):
    """Return pymoo's function of bbob."""
    problem = importlib.import_module("pymoo.problems").get_problem
    made = problem(f"bbob-f{function:02d}-{instance}", n_var=dimension)
    return FunctionProblem(lambda x: made.evaluate(x).ravel(), made.xl, made.xu, vectorized=True)


def bbobtorch(function, dimension, instance):
    """Return BBOBtorch's function of bbob, whose instance is a seed of its own."""
    torch = importlib.import_module("torch")
    made = getattr(importlib.import_module("bbobtorch"), f"create_f{function:02d}")(dimension, seed=instance)
    known = {"optimum": float(made.f_opt), "optimum_point": made.x_opt.double().numpy()}
    box = made.x_min.double().numpy(), made.x_max.double().numpy()
    return FunctionProblem(lambda x: made(torch.tensor(x).float()).double().numpy(), *box, vectorized=True, **known)


def niapy(function, dimension, instance):
    """Return NiaPy's function of that name, with its optimum at the place that the literature has."""
    name = {"schwefel-2-26": "Schwefel", "discus": "Discus"}.get(function, function.replace("-", " ").title())
    made = getattr(importlib.import_module("niapy.problems"), name.replace(" ", ""))(dimension=dimension)
    place = [PLACES.get(function, 0.0)] * dimension
    return FunctionProblem(made.evaluate, made.lower, made.upper, vectorized=False, optimum_point=place)


def pymoo(function, dimension, instance):
    """Return pymoo's function of that name, likewise."""
    made = importlib.import_module("pymoo.problems").get_problem(function.partition("-2-26")[0], n_var=dimension)
    place = 0.5 if function == "sphere" else PLACES.get(function, 0.0)
    known = {"optimum_point": [place] * dimension}
    return FunctionProblem(lambda x: made.evaluate(x).ravel(), made.xl, made.xu, vectorized=True, **known)


PLACES = {"rosenbrock": 1.0, "levy": 1.0, "schwefel-2-26": 420.968746, "styblinski-tang": -2.903534, "happy-cat": -1.0}
"""Where functions have their optimum, in each variable, but at 0."""
