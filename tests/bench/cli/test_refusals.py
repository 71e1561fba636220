"""Input that a command refuses: one sentence, exit code 2, and nothing written."""

import pytest

from tests.bench.cli.test_gate import write
from tests.bench.cli.test_reproduce import HEAD

HEADER = f"{HEAD}function,optimizer,mean,sd\n"
FILES = {
    "bad.toml": "name = ",
    "deep.toml": "trials = " + "[" * 50_000,
    "odd.toml": 'name = "s"\nproblems = ["sphere-2"]\noptimizers = ["hillclimber"]\n',
    "sets.toml": 'name = "s"\ntargets = "runlength"\nproblems = ["sphere-2"]\noptimizers = ["scatter"]\n',
    "ring.toml": 'name = "s"\nconstraints = "repair"\nproblems = ["ring-2"]\noptimizers = ["scatter"]\n',
    "own.py": "x = 1\n",
    "no-table.csv": "a,b\n1,2\n",
    "unheard.csv": f"{HEADER}sphere,Unheard,0.5,0.5\n",
    "mine.csv": f"{HEADER}sphere,Mine,0.5,0.5\n",
    "a.zip": "PK",
}


@pytest.fixture(scope="module")
def place(tmp_path_factory, testing_plugins):
    """A folder with such files, and with the folders of studies."""
    place = tmp_path_factory.mktemp("refusals")
    for name, text in FILES.items():
        (place / name).write_text(text)
    write(place, "old", trials=2)
    write(place, "same", trials=2)
    write(place, "two", optimizers=("mine", "scatter"), trials=2)
    write(place, "fewer", problems=("sphere-2",), trials=2)
    write(place, "short", budget=30, trials=2)
    write(place, "unknown", problems=("p",), trials=2)
    write(place, "unknown-too", problems=("p",), trials=2)
    return place


REFUSED = [
    ("runn", "No such command 'runn'"),
    ("run", "name a study: 'bench run quick' runs a small one"),
    ("run nosuch", "unknown study 'nosuch'"),
    ("run bad.toml", "is not valid TOML"),
    ("run deep.toml", "is not valid TOML: it is nested more than 100 levels deep"),
    ("run missing.toml", "cannot be read"),
    ("run odd.toml", "unknown optimizer 'hillclimber'; did you mean 'hill-climber'?"),
    ("run ring.toml -o no", "problem 'ring-2' has no rule that repairs violated constraints"),
    ("run sets.toml -o no", "has running times on bbob and bbob-noisy"),
    ("run quick --jobs x", "--jobs must be a whole number, not 'x'"),
    ("run quick --jobs 0", "--jobs must be a whole number from 1 to 1000, or -1 for every"),
    ("run quick --backend nope", "unknown backend 'nope'"),
    ("run quick --backend dask", "needs --scheduler"),
    ("run quick --backend local --scheduler tcp://localhost:1", "no other backend takes one"),
    ("run quick --timeout -3", "the timeout of a trial must be a positive number of seconds"),
    ("run quick --memory nan", "the memory of a trial must be a positive number of gigabytes"),
    ("run quick --shard 3", "as in 3/20"),
    ("run quick --output /proc/nothing/here", "the output folder /proc/nothing/here cannot be written"),
    ("solve sphere-2 scatter --budget lots", "--budget must be a whole number from 1 to 1e+15"),
    ("solve signature-12 gwp", "unknown optimizer 'gwp'; did you mean 'gwo'?"),
    ("solve signature-99 gwo", "unknown problem 'signature-99'"),
    ("solve rastrigin gwo", "did you mean 'classical-rastrigin-d2-i1', 'classical-rastrigin-d3-i1' or "),
    ("solve qwz gwo", "unknown problem 'qwz'; the families are bbob, "),
    ("solve signature-12 gwo --set agents", "'agents' is not KEY=VALUE"),
    ("check nothing", "unknown optimizer 'nothing'"),
    ("check nothing-*", "no problem matches 'nothing-*'"),
    ("check bbob-f99-d2-i1", "bbob has no function 'f99'"),
    ("check no/such.py:Mine", "cannot be read"),
    ("check own.py:Absent", "holds no optimizer called 'Absent'"),
    ("check scatter --set agents=none", "agents"),
    ("list optimisers", "no kind, family, suite or plug-in is called 'optimisers'; did you mean 'optimizers'?"),
    ("list --json problem", "no kind, family, suite or plug-in is called 'problem'; did you mean 'problems'?"),
    ("list broken", "failed to load: ModuleNotFoundError"),
    ("list problems cec202", "unknown family of problems 'cec202'; did you mean 'cec2020' or 'cec2022'?"),
    ("list studies thesis", "'studies' has no families or suites; leave out 'thesis'"),
    ("list studies --search nowhere", "no plug-in has 'nowhere' in its name or description"),
    ("new study mine --output bad.toml/mine.toml", "cannot be written"),
    ("status nowhere", "holds no study.toml"),
    ("report .", "holds no study.toml"),
    ("report old old", "given twice"),
    ("report old short --output no", "only runs of one budget can be compared"),
    ("report old --output no --targets precise", "must be 'precisions', 'runlength', 'relative', 'quantiles' or 'tol"),
    ("report old --output no --targets tolerance", "need a problem with an expected metric"),
    ("export old --format xls", "xls"),
    ("export nowhere --format csv", "holds no study.toml"),
    ("rm old", "name what to remove"),
    ("rm old --optimizer mime", "no optimizer 'mime'; did you mean 'mine'?"),
    ("rm old --problem sphere-4", "no problem 'sphere-4'; did you mean"),
    ("plan old --power 0", "the power is a chance"),
    ("plan old --gap 0.5", "the gap is an A12"),
    ("unpack a.zip -o no", "a.zip"),
    ("simulate /proc/a.csv --level 3", "cannot be written"),
    ("gate two old", "two holds 2 optimizers (mine and scatter); choose one with --optimizer"),
    ("gate old same --optimizer mime", "old holds no optimizer 'mime'; did you mean 'mine'?"),
    ("gate old fewer", "there are no trials on sphere-3 of mine (fewer); run them, or compare"),
    ("gate old old", "old is given twice"),
    ("gate old same --not-worse-than 5", "the margin is 5.0, but must be above 0 and below 0.5"),
    ("gate unknown unknown-too --target 1", "no target can be set on p, whose optimum is unknown or beaten"),
    ("reproduce no-table.csv", "no-table.csv has no column of functions; its columns are a, b"),
    ("reproduce unheard.csv", "no cell of unheard.csv can be run: no optimizer is called 'Unheard'"),
    ("reproduce mine.csv --optimizer Other=gwo", "--optimizer 'Other=gwo' must be PRINTED=NAME; the table prints Mine"),
]


@pytest.mark.parametrize(("words", "sentence"), REFUSED)
def test_what_a_command_refuses_is_one_sentence_and_exit_code_two(bench_here, place, words, sentence):
    before = sorted(place.iterdir())
    done = bench_here(*words.split(), cwd=place)
    assert done.returncode == 2
    assert sentence in done.stderr
    assert done.stderr.startswith("bench: ")
    assert done.stderr.count("\n") == 1
    assert sorted(place.iterdir()) == before
