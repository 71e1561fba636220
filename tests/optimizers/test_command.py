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


def test_a_client_has_at_most_forty_lines():
    assert {path.name for path in CLIENTS.glob("climb.*")} == {"climb.c", "climb.py", *INTERPRETERS}
    for path in CLIENTS.glob("climb.*"):
        assert len(path.read_text(encoding="utf-8").splitlines()) <= 40


class TestProtocol:
    def test_the_first_line_has_the_box_the_budget_a_seed_and_the_options(self, program, sphere):
        text = "ask(x=[first['lower']])\nask(stop=json.dumps([sorted(first), first['options'], first['budget']]))"
        result = solve(sphere, program(text, sigma=0.3, mode="fast"), budget=5)
        assert result.stop == (
            '[["budget", "dimension", "integer", "lower", "options", "protocol", "seed", "upper"], '
            '{"sigma": 0.3, "mode": "fast"}, 5]'
        )
        assert result.x.tolist() == sphere.lower.tolist()

    def test_numbers_travel_without_loss_both_ways(self, program):
        seen = []
        problem = FunctionProblem(lambda x: seen.append(x.copy()) or x[:, 0] / 3, [0.0], [1.0], vectorized=True)
        text = "f = ask(x=[[0.1], [1 / 3]])['f']; ask(x=[[f[1]]])"
        solve(problem, program(text), budget=5)
        assert [each[0] for x in seen for each in x.tolist()] == [0.1, 1 / 3, 1 / 9]

    def test_a_point_outside_the_box_is_answered_by_infinity(self, program, sphere):
        result = solve(sphere, program("f = ask(x=[[9, 9, 9]])['f'][0]; ask(stop=str(f))"), budget=5)
        assert result.stop == "inf"

    def test_repair_and_initial_cost_no_evaluation(self, program, sphere):
        text = "x = ask(initial=2)['x']; y = ask(repair=[[9, 9, 9]])['x']; ask(x=x + y)"
        result = solve(sphere, program(text), budget=5)
        assert result.nfev == 3

    def test_what_it_logs_is_kept_without_an_answer(self, program, sphere):
        text = """
print(json.dumps({"log": {"step": 0.5}}), flush=True)
ask(x=[first['lower']] * 2)
print(json.dumps({"log": {"step": 0.25}}), flush=True)
print(json.dumps({"stop": "done"}), flush=True)"""
        assert solve(sphere, program(text), budget=5).log == {"step": [(0, 0.5), (2, 0.25)]}

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


@pytest.mark.parametrize(
    ("name", "options", "expected"),
    [
        ("command:", {}, "names no program that can be run"),
        ("command:./no-such-program", {}, "names no program that can be run"),
        (f"command:{sys.executable}", {"sigma": float("inf")}, "must be texts, numbers, lists or tables"),
    ],
)
def test_a_wrong_command_is_one_sentence(name, options, expected):
    with pytest.raises(BenchError, match=expected):
        load_optimizer(name, **options)


class TestStudy:
    def study(self, **optimizer):
        entry = {"name": "command", "label": "mine", **optimizer}
        problems = [{"name": "bbob-f01-d2-i1"}]
        return Study.from_dict({"name": "s", "budget": 10, "problems": problems, "optimizers": [entry]})

    def test_it_takes_the_words_of_a_command_and_a_sweep_of_the_program_s_options(self):
        study = self.study(command=["Rscript", "my script.R"], options={"sigma": [1, 2]})
        assert [each.name for each in study.optimizers] == ["command:Rscript 'my script.R'"] * 2
        assert [each.label for each in study.optimizers] == ["mine[sigma=1]", "mine[sigma=2]"]

    @pytest.mark.parametrize("words", [None, "Rscript mine.R", [], [""], [1]])
    def test_wrong_words_are_one_sentence(self, words):
        with pytest.raises(BenchError, match="needs the words of its command"):
            self.study(**({} if words is None else {"command": words}))


@pytest.mark.slow
def test_a_program_keeps_the_contract(climb):
    from bench import check_optimizer

    assert check_optimizer(climb("climb.c"), bias=False).passed  # it clips its steps to the bounds, which is a bias
