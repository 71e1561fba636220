"""Programs as optimizers: the protocol, what breaks it, and the clients of examples/command."""

import os
import shutil
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

from bench import BenchError, FunctionProblem, Study, load_optimizer, solve

CLIENTS = Path(__file__).parents[2] / "examples" / "command"
INTERPRETERS = {"climb.js": "node", "climb.R": "Rscript", "climb.m": "octave-cli --quiet", "climb.jl": "julia"}
HEAD = """
import json, sys
first = json.loads(input())
def ask(**request):
    print(json.dumps(request), flush=True)
    return json.loads(input())
"""


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """A busy machine may take long to end a process; who waits for an end waits no longer than that."""
    monkeypatch.setattr("bench.helpers.programs.GRACE", 30.0)


@pytest.fixture
def sphere():
    return FunctionProblem(lambda x: (x**2).sum(axis=1) + 0.1, [-2.0, -1.0, -3.0], [1.0, 3.0, 2.0])


@pytest.fixture
def program(tmp_path):
    """Return a function that returns the optimizer of a program in Python, from its text."""

    def made(text, head=HEAD, **options):
        path = tmp_path / "mine.py"
        path.write_text(head + text, encoding="utf-8")
        return load_optimizer(f"command:'{sys.executable}' '{path}'", **options)

    return made


def outcome(result):
    return result.x.tolist(), result.fun, result.trace.evaluations.tolist(), result.trace.values.tolist()


@pytest.fixture(scope="session")
def climb(tmp_path_factory):
    """Return the name of the optimizer of a client."""

    def named(client):
        if client.endswith(".c"):
            compiler = shutil.which("cc")
            if compiler is None:
                pytest.skip("no C compiler is installed")
            made = tmp_path_factory.mktemp("client") / "climb"
            subprocess.run([compiler, "-O2", "-o", made, CLIENTS / client, "-lm"], check=True)
            return f"command:{made}"
        interpreter = INTERPRETERS[client]
        if shutil.which(interpreter.split()[0]) is None:
            pytest.skip(f"{interpreter.split()[0]} is not installed")
        if client.endswith(".R") and subprocess.run(["Rscript", "-e", "loadNamespace('jsonlite')"]).returncode:
            pytest.skip("R's package jsonlite is not installed")
        return f"command:{interpreter} {CLIENTS / client}"

    return named


@pytest.mark.parametrize("client", ["climb.c", *INTERPRETERS])
def test_each_client_makes_the_trials_of_the_plug_in_in_python_to_the_last_bit(climb, client, sphere):
    name = climb(client)
    expected = outcome(solve(sphere, f"{CLIENTS / 'climb.py'}:Climb", budget=60, seed=4))
    assert outcome(solve(sphere, name, budget=60, seed=4)) == expected


class TestProtocol:
    def test_the_last_line_says_that_the_budget_has_ended(self, program, sphere, tmp_path):
        note = tmp_path / "note"
        text = f"""
while 'f' in (said := ask(x=[first['lower']] * 2)):
    pass
open({str(note)!r}, 'w').write(json.dumps(said))"""
        assert solve(sphere, program(text), budget=5).nfev == 5
        assert note.read_text() == '{"stop": "budget"}'


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("print('hello')", "wrote hello; wanted is a line of JSON"),
        ("print('[' * 100_000)", r"wrote \[\[\[.*…; wanted is"),
        ("print('{}')", "wrote {}; wanted is"),
        ("ask(x=[[1, 2]])", r"sent the points \[\[1, 2\]\]; wanted is a list of points, each of 3 numbers"),
        ("ask(log={'step': [1]})", "logged .*; wanted is at most 20 names of numbers"),
        ("ask(initial=0)", 'wrote {"initial": 0}'),
        ("ask(initial=30)", "asked for 30 initial points, which exceeds the budget; wanted is at most 5, the budget"),
        ("ask(x=[[1, 2, 3]], stop='now')", "wrote"),
        ("sys.exit('no licence')", "ended with code 1; it complained: no licence"),
        ("import os; os.kill(os.getpid(), 9)", "ended by signal 9"),
    ],
)
def test_what_breaks_the_protocol_is_one_sentence(program, sphere, text, expected):
    with pytest.raises(BenchError, match=f"the program .* mine.py {expected}") as raised:
        solve(sphere, program(text), budget=5)
    assert "\n" not in str(raised.value)


def test_a_program_that_closes_its_output_and_goes_on_is_one_sentence(program, sphere, monkeypatch):
    monkeypatch.setattr("bench.helpers.programs.GRACE", 0.1)
    with pytest.raises(BenchError, match="closed its standard output; wanted is another line, or its end"):
        solve(sphere, program("import os, time; os.close(1); time.sleep(600)"), budget=5)


def test_a_line_that_never_ends_is_given_up(program, sphere):
    with pytest.raises(BenchError, match="wrote xxx"):
        solve(sphere, program("while True: print('x' * 2**20, end='')"), budget=5)


@pytest.mark.parametrize(
    "last", ["print('junk', flush=True)", "ask(x=[first['lower']]); ask(stop='now')", "ask(x=[first['lower']] * 9)"]
)
def test_the_program_ends_with_its_trial(program, sphere, tmp_path, last, monkeypatch):
    monkeypatch.setattr("bench.helpers.programs.GRACE", 0.1)
    note = tmp_path / "pid"
    text = f"import os, time\nopen({str(note)!r}, 'w').write(str(os.getpid()))\n{last}\ntime.sleep(600)"
    with suppress(BenchError):
        solve(sphere, program(text), budget=5)
    with pytest.raises(ProcessLookupError):
        os.kill(int(note.read_text()), 0)


class TestStudy:
    def study(self, **optimizer):
        entry = {"name": "command", "label": "mine", **optimizer}
        problems = [{"name": "bbob-f01-d2-i1"}]
        return Study.from_dict({"name": "s", "budget": 10, "problems": problems, "optimizers": [entry]})

    def test_it_takes_the_words_of_a_command_and_a_sweep_of_the_program_s_options(self):
        study = self.study(command=["Rscript", "my script.R"], options={"sigma": [1, 2]})
        assert [each.name for each in study.optimizers] == ["command:Rscript 'my script.R'"] * 2
        assert [each.label for each in study.optimizers] == ["mine[sigma=1]", "mine[sigma=2]"]


@pytest.mark.slow
def test_a_program_keeps_the_contract(climb):
    from bench import check_optimizer

    assert check_optimizer(climb("climb.c"), bias=False).passed  # it clips its steps to the bounds, which is a bias
