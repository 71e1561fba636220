"""Programs that return violations, simulators that read and write files, and a program that is started again."""

import shutil
import subprocess
import sys

import numpy as np
import pytest

from bench import load_problem, load_results, run, solve
from bench.execution.side_by_side import evaluated
from bench.execution.verify import verify
from bench.helpers.errors import PointError
from bench.results.results import StoredResults
from bench.trial.scoring import scored
from tests.problems.simulators import BOX, SIMULATORS, X

COUNTED = """
import json, sys
print(json.dumps({"protocol": 1, "lower": [0, 0], "upper": [4, 4], "violations": 1}), flush=True)
for line in sys.stdin:
    x, y = json.loads(line)["x"]
    open("COUNT", "a").write(line)
    if x > 3.9:
        sys.exit("it crashed")
    print(json.dumps({"f": x + y, "g": [1 - x]}), flush=True)
"""


def limits(x):
    height, width, ribs = x
    return [4e8 / (width * height**3 * (1 + ribs / 10)) - 1, 3e7 / (width * height**2) - 80]


@pytest.fixture
def counted(tmp_path):
    """Return the name of a program with a constraint, and the file in which it notes each evaluation."""
    path = tmp_path / "counted.py"
    path.write_text(COUNTED.replace("COUNT", str(tmp_path / "count")))
    return f"command:'{sys.executable}' '{path}'", tmp_path / "count"


@pytest.fixture
def example(tmp_path):
    def loaded(kind):
        if kind == "files.sh":
            return load_problem(f"command:{SIMULATORS / 'files.sh'} '{{in}}' '{{out}}'", violations=2, **BOX)
        if (compiler := shutil.which("cc")) is None:
            pytest.skip("no C compiler is installed")
        subprocess.run([compiler, "-O2", "-o", tmp_path / "limits", SIMULATORS / kind, "-lm"], check=True)
        return load_problem(f"command:{tmp_path / 'limits'}")

    return loaded


@pytest.mark.parametrize("parallel", [1, 2])
@pytest.mark.parametrize("kind", ["limits.c", "files.sh"])
def test_each_example_returns_the_value_and_its_violations(example, kind, parallel):
    with evaluated(example(kind), parallel) as problem:
        values = problem.evaluate(X.copy())
        violations = problem.violations(X.copy())
    assert values == pytest.approx([1e-3 * (10 * x[1] + 3 * x[0]) + 0.2 * x[2] for x in X], rel=1e-14)
    np.testing.assert_allclose(violations, [limits(x) for x in X], rtol=1e-13)


@pytest.mark.parametrize("parallel", [1, 2])
def test_an_evaluation_gives_value_and_violations_at_once(counted, parallel):
    name, count = counted
    found = solve(name, "random-search", budget=40, on_error="worst", parallel=parallel)
    assert len(count.read_text().splitlines()) == 40
    assert found.x[0] >= 1
    assert found.metrics["violation"] == 0
    assert found.usage.failures == sum("[3.9" in line for line in count.read_text().splitlines())


def test_points_that_fail_are_infeasible_and_are_run_once(counted):
    name, count = counted
    x = np.array([[3.95, 1.0], [2.0, 1.0], [0.5, 1.0]])
    with evaluated(scored(load_problem(name), "lexicographic", "worst")) as problem:
        found = problem.assess(x, np.random.default_rng(0))
    assert found.values.tolist() == [np.inf, 3.0, np.inf]
    assert found.shown.tolist() == [np.inf, 3.0, pytest.approx(1.5e100)]
    assert len(count.read_text().splitlines()) == 3


@pytest.mark.slow
def test_trials_of_such_a_program_repeat(counted, tmp_path):
    study = {
        "name": "s", "trials": 1, "budget": 12, "on_error": "worst", "optimizers": ["cma-es"],
        "problems": [{"name": counted[0], "label": "counted"}],
    }  # fmt: skip
    assert not run(study, tmp_path / "out", n_jobs=1).failed
    assert (load_results(tmp_path / "out")["violation"] == 0).all()
    assert verify(tmp_path / "out", n_jobs=1).different == {}


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ('{"f": 1}', 'wrote {"f": 1}; wanted is a line of JSON such as {"f": 0.25, "g": [the 2 violations]}'),
        ('{"f": 1, "g": [1]}', 'wrote {"f": 1, "g": [1]}'),
        ('{"f": 1, "g": ["a", 2]}', "wrote"),
    ],
)
def test_an_answer_without_its_violations_is_one_sentence(tmp_path, answer, said):
    (tmp_path / "p.py").write_text(
        'import sys\nprint(\'{"protocol": 1, "lower": [0], "upper": [1], "violations": 2}\', flush=True)\n'
        f"for line in sys.stdin: print('{answer}', flush=True)\n"
    )
    problem = load_problem(f"command:'{sys.executable}' '{tmp_path / 'p.py'}'")
    with pytest.raises(PointError) as caught, evaluated(problem) as beside:
        beside.evaluate(np.ones((1, 1)))
    assert said in str(caught.value)


@pytest.fixture
def undeclared(tmp_path):
    """Return a function that makes a program, which does not say how many violations it returns."""

    def made(violations):
        (tmp_path / "p.py").write_text(
            'import json, sys\nprint(\'{"protocol": 1, "lower": [0], "upper": [1]}\', flush=True)\n'
            'for line in sys.stdin:\n    (x,) = json.loads(line)["x"]\n'
            f'    print(json.dumps({{"f": x}} | {violations}), flush=True)\n'
        )
        return f"command:'{sys.executable}' '{tmp_path / 'p.py'}'"

    return made


@pytest.mark.parametrize("parallel", [1, 2])
def test_the_first_answer_says_how_many_violations_there_are(undeclared, parallel):
    found = solve(undeclared('{"g": [0.5 - x, x - 2]}'), "random-search", budget=30, parallel=parallel)
    assert found.x[0] >= 0.5
    assert found.metrics == {"violation": 0.0}
    assert solve(undeclared("{}"), "random-search", budget=9, parallel=parallel).metrics == {}


@pytest.mark.parametrize("parallel", [1, 2])
def test_a_later_answer_with_another_number_is_one_sentence(undeclared, parallel):
    name = undeclared('{"g": [0.0] * (1 + (x > 0.5))}')
    points = np.array([[0.2], [0.7], [0.3], [0.9]])
    with evaluated(load_problem(name), parallel) as problem:
        problem.evaluate(points[:1])
        with pytest.raises(PointError) as caught:
            problem.evaluate(points)
    said = {1: 'such as {"f": 0.25, "g": [the 1 violation]}', 2: "returned 2 violations, and 1 in its first answer"}
    assert said[parallel] in str(caught.value)
    with evaluated(scored(load_problem(name), "lexicographic", "worst"), parallel) as problem:
        problem.evaluate(points[:1])
        assert problem.evaluate(points).tolist() == [0.2, np.inf, 0.3, np.inf]


def test_a_study_says_which_programs_have_constraints(undeclared, tmp_path):
    names = {"free": undeclared("{}"), "bound": undeclared('{"g": [0.5 - x]}').replace("p.py", "q.py")}
    (tmp_path / "q.py").write_text((tmp_path / "p.py").read_text())
    undeclared("{}")
    problems = [{"name": name, "label": label} for label, name in names.items()]
    run(
        {"name": "s", "trials": 1, "budget": 30, "optimizers": ["random-search"], "problems": problems},
        tmp_path / "out",
        n_jobs=1,
    )
    results = StoredResults(tmp_path / "out")
    assert [results.facts(label).constraints for label in names] == ["", "lexicographic"]


def test_the_numbers_of_a_line_are_the_value_and_violations(tmp_path):
    (tmp_path / "p.sh").write_text("#!/bin/sh\necho $1 -1 0.5\n")
    (tmp_path / "p.sh").chmod(0o755)
    problem = load_problem(f"command:{tmp_path / 'p.sh'}", lower=[0], upper=[1])
    with evaluated(problem) as beside:
        assert beside.evaluate(np.array([[0.5]])).tolist() == [0.5]
        assert beside.violations(np.array([[0.5]])).tolist() == [[-1.0, 0.5]]
    refused = load_problem(f"command:{tmp_path / 'p.sh'}", lower=[0], upper=[1], violations=0)
    with pytest.raises(PointError, match=r"printed 0\.5 -1 0\.5 last; wanted is the value"):
        refused.evaluate(np.array([[0.5]]))
