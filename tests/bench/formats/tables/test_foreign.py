"""Results of other tools in the shapes in which their users have them, with made-up numbers."""

import json

import numpy as np
import pandas as pd
import pytest

import bench
from bench import BenchError, Results
from bench.formats.importing import import_results

PROBLEMS, OPTIMIZERS, RUNS = ["Sphere", "Ackley"], ["GWO", "PSO", "DE"], 4


def value(problem, optimizer, run):
    return round(10.0 * problem + 3.5 * optimizer + 0.25 * run + 0.125, 3)


def long(head, cells="{problem},{optimizer},{run},{value}", problems=PROBLEMS, start=1):
    rows = [
        cells.format(problem=problem, optimizer=optimizer, run=run + start, value=value(p, o, run), seed=100 + run)
        for p, problem in enumerate(problems)
        for o, optimizer in enumerate(OPTIMIZERS)
        for run in range(RUNS)
    ]
    return "\n".join([head, *rows]) + "\n"


def columns(p, separator=",", index="", decimal="."):
    """A problem: an optimizer a column, a run a row."""
    head = separator.join([*([index] if index is not None else []), *OPTIMIZERS])
    rows = [
        separator.join(
            [
                *([str(run)] if index is not None else []),
                *(f"{value(p, o, run)}".replace(".", decimal) for o in range(3)),
            ]
        )
        for run in range(RUNS)
    ]
    return "\n".join([head, *rows]) + "\n"


def by_problem(o):
    """An optimizer: a problem a column, a run a row."""
    rows = [",".join([str(run), *(str(value(p, o, run)) for p in range(2))]) for run in range(RUNS)]
    return "\n".join([",Sphere,Ackley", *rows]) + "\n"


def records(**names):
    return [
        {
            names.get("problem", "problem"): problem,
            names.get("optimizer", "optimizer"): optimizer,
            names.get("run", "run"): run,
            names.get("value", "value"): value(p, o, run),
        }
        for p, problem in enumerate(PROBLEMS)
        for o, optimizer in enumerate(OPTIMIZERS)
        for run in range(RUNS)
    ]


def nested(pairs=False):
    return json.dumps(
        {
            optimizer: {
                problem: [[[0.5, 0.5], value(p, o, run)] if pairs else value(p, o, run) for run in range(RUNS)]
                for p, problem in enumerate(PROBLEMS)
            }
            for o, optimizer in enumerate(OPTIMIZERS)
        }
    )


def matrix(o, p, last=False):
    """A CEC entry: a column a run, a row a share of the budget."""
    rows = [[value(p, o, run) + extra for run in range(RUNS)] for extra in (1e3, 50, 0)]
    return (
        "\n".join(" ".join(f"{cell:.8e}" for cell in row) for row in [*rows, *([[200000] * RUNS] if last else [])])
        + "\n"
    )


CELLS = "{problem},{optimizer},{run},{value}"
LONG = {
    "pandas, long": ("r.csv", "Function,Algorithm,Run,Fitness", CELLS),
    "seeds and times": (
        "summary.csv", "algorithm,problem,seed,final_fitness,best_fitness,elapsed_time",
        "{optimizer},{problem},{seed},99,{value},1.5",
    ),
    "a combinatorial experiment": (
        "experiment_results.csv", "Instance,Algorithm,Run,InitialFitness,FinalFitness,TimeMs",
        "{problem},{optimizer},{run},99,{value},15",
    ),
    "no run numbers": ("r.csv", "Test Function,Optimizer,Best Value", "{problem},{optimizer},{value}"),
    "CEC with evaluations": (
        "r.csv", "Algorithm,Function,Dim,Run,FES,Error", "{optimizer},{problem},10,{run},100000,{value}",
    ),
    "a value of an unknown name": ("r.csv", "Function,Algorithm,Run,f_min", CELLS),
    "TSV": ("r.tsv", "func\talgo\ttrial\tfun", "{problem}\t{optimizer}\t{run}\t{value}"),
    "EvoloPy": (
        "experiment.csv", "Optimizer,objfname,ExecutionTime,Iter1,Iter2,Iter3",
        "{optimizer},{problem},1.5,999,500,{value}",
    ),
    "jMetalPy": (
        "QualityIndicatorSummary.csv", "Algorithm,Problem,IndicatorName,ExecutionId,IndicatorValue",
        "{optimizer},{problem},IGD,{run},{value}",
    ),
    "PlatEMO, one row a run": (
        "raw.csv", "Algorithm,Problem,M,D,Seed,IGD,Execution_Time_s", "{optimizer},{problem},1,30,{seed},{value},2",
    ),
    "courses over generations": (
        "r.csv", "problem,algorithm,seed,n_gen,f_best",
        "{problem},{optimizer},{seed},1,999\n{problem},{optimizer},{seed},2,{value}",
    ),
    "pymoo: courses over evaluations": (
        "r.csv", "problem,algorithm,seed,n_eval,F",
        "{problem},{optimizer},{seed},100,999\n{problem},{optimizer},{seed},200,{value}",
    ),
}  # fmt: skip
"""Tables with a row a run or a value: name of the file, head, cells."""

SHAPES = {shape: {name: long(head, cells)} for shape, (name, head, cells) in LONG.items()} | {
    "a notebook's frame with index": {
        "r.csv": pd.DataFrame(
            records(problem="Problem", optimizer="Algorithm", run="Run", value="Best_Fitness")
        ).to_csv()
    },
    "German spreadsheet": {
        "r.csv": long("Funktion;Function;Algorithm;Run;Best fitness", "x;{problem};{optimizer};{run};{value}").replace(
            ".", ","
        )
    },
    "SAES and others: columns are optimizers": {
        "data.csv": "".join(
            (
                columns(p).replace("\n", f"\n{problem},").removesuffix(f"{problem},")
                if p == 0
                else "".join(f"{problem},{line}\n" for line in columns(p).splitlines()[1:])
            )
            for p, problem in enumerate(PROBLEMS)
        ).replace(",GWO", "problem,run,GWO", 1)
    },
    "mealpy: a file an optimizer, a problem a column": {
        f"best_fit/{optimizer}_best_fit.csv": by_problem(o) for o, optimizer in enumerate(OPTIMIZERS)
    },
    "scipy notebooks: a file a problem": {f"{problem}.csv": columns(p) for p, problem in enumerate(PROBLEMS)},
    "decimal commas, a file a problem": {
        f"results_{problem}.csv": columns(p, ";", None, ",") for p, problem in enumerate(PROBLEMS)
    },
    "CEC 2017: a matrix a problem": {
        f"{optimizer}_{p + 1}_10.txt": matrix(o, p) for o, optimizer in enumerate(OPTIMIZERS) for p in range(2)
    },
    "CEC 2022: the last row has evaluations": {
        f"{optimizer}_F{p + 1}_D10.txt": matrix(o, p, last=True)
        for o, optimizer in enumerate(OPTIMIZERS)
        for p in range(2)
    },
    "NiaPy, JSON": {"runner.json": nested()},
    "NiaPy, JSON of points and values": {"runner.json": nested(pairs=True)},
    "JSON lines": {
        "r.jsonl": "".join(f"{json.dumps(each | {'x': [0.5, 0.5]})}\n" for each in records(run="rep", value="best_f"))
    },
    "JSON records": {
        "r.json": json.dumps(records(problem="benchmark", optimizer="solver", run="repetition", value="cost"))
    },
    "JSON as pandas writes it": {"r.json": pd.DataFrame(records(value="Fitness")).to_json()},
    "runs in columns": {
        "r.csv": "Algorithm,Function,Run 1,Run 2,Run 3,Run 4\n"
        + "".join(
            f"{optimizer},{problem}," + ",".join(str(value(p, o, run)) for run in range(RUNS)) + "\n"
            for p, problem in enumerate(PROBLEMS)
            for o, optimizer in enumerate(OPTIMIZERS)
        )
    },
    "a folder a problem, a file an optimizer, a value a line": {
        f"{problem}/{optimizer}.txt": "".join(f"{value(p, o, run)}\n" for run in range(RUNS))
        for p, problem in enumerate(PROBLEMS)
        for o, optimizer in enumerate(OPTIMIZERS)
    },
    "names of both in the file": {
        f"{optimizer}_{problem}.csv": "run,best\n" + "".join(f"{run},{value(p, o, run)}\n" for run in range(RUNS))
        for p, problem in enumerate(PROBLEMS)
        for o, optimizer in enumerate(OPTIMIZERS)
    },
}


def sheets(folder):
    with pd.ExcelWriter(folder / "r.xlsx") as book:
        for p, problem in enumerate(PROBLEMS):
            pd.DataFrame({name: [value(p, o, r) for r in range(RUNS)] for o, name in enumerate(OPTIMIZERS)}).to_excel(
                book, sheet_name=problem, index=False
            )


def sheets_of_optimizers(folder):
    with pd.ExcelWriter(folder / "result-d=30.xlsx") as book:
        for o, name in enumerate(OPTIMIZERS):
            pd.DataFrame([[value(p, o, r) for r in range(RUNS)] for p in range(2)]).to_excel(
                book, sheet_name=name, index=False, header=False
            )


def parquet(folder):
    pd.DataFrame(records(problem="function_name", optimizer="Algorithm Name", run="trial_id")).to_parquet(
        folder / "r.parquet"
    )


FILES = {each.__name__: each for each in (sheets, sheets_of_optimizers, parquet)}


@pytest.mark.parametrize("shape", [*SHAPES, *FILES])
def test_a_strangers_table_is_read_at_the_first_try(tmp_path, shape):
    source = tmp_path / "source"
    source.mkdir()
    for name, text in SHAPES.get(shape, {}).items():
        (source / name).parent.mkdir(exist_ok=True)
        (source / name).write_text(text, encoding="utf-8")
    FILES.get(shape, lambda _: None)(source)
    files = [each for each in source.rglob("*") if each.is_file()]
    import_results(files[0] if len(files) == 1 else source, tmp_path / "out")
    frame = Results(tmp_path / "out").frame
    cells = frame.groupby(["problem", "optimizer"])["fun"].agg(sorted)
    assert len(cells) == 6
    expected = sorted([value(p, o, run) for run in range(RUNS)] for p in range(2) for o in range(3))
    assert np.allclose(sorted(cells.tolist()), expected), cells
    assert set(frame["optimizer"]) == set(OPTIMIZERS)
    problems = sorted({name.split("-d")[0] for name in frame["problem"]})
    assert problems in (["Ackley", "Sphere"], ["f1", "f2"])


def imported(folder, text, name="r.csv", **options):
    (folder / name).write_text(text, encoding="utf-8")
    return import_results(folder / name, folder / "out", **options)


def test_it_says_what_was_taken_for_what(tmp_path):
    notes = imported(
        tmp_path, long("Function,Algorithm,Run,Time (s),Fitness", "{problem},{optimizer},{run},2,{value}")
    ).notes
    assert notes == (
        "columns: Function = problem; Algorithm = optimizer; Run = run; Fitness = value; not used: Time (s)",
        "4 runs of 3 optimizers on 2 problems; lower is better",
        "runs on different problems share numbers: where these are seeds, they may depend on each other",
    )


def test_shared_seeds_are_kept_and_said(tmp_path):
    notes = imported(tmp_path, long("function,algorithm,seed,f_best", "{problem},{optimizer},{seed},{value}")).notes
    assert "runs on different problems share seeds: they may depend on each other" in notes
    assert set(Results(tmp_path / "out").frame["seed"]) == {100, 101, 102, 103}


def test_columns_and_direction_can_be_mended(tmp_path):
    text = long("Thing,Who,nr,Yield")
    columns = {"problem": "thing", "optimizer": "Who", "run": "nr", "value": "Yield"}
    notes = imported(tmp_path, text, columns=columns, maximise=True).notes
    assert notes[1].endswith("higher is better: values are negated")
    frame = Results(tmp_path / "out").frame
    assert sorted(-frame["fun"]) == sorted(value(p, o, r) for p in range(2) for o in range(3) for r in range(RUNS))


@pytest.mark.parametrize(
    ("text", "columns", "sentence"),
    [
        (
            "Problem,GWO,PSO\nF1,1.2e3 ± 4,2 ± 3\nF2,1 ± 1,2 ± 2\n",
            {},
            "'1.2e3 ± 4', a summary of runs.*bench reproduce",
        ),
        ("Problem,M,D,GWO,PSO\nF1,1,30,1.2e-1 (4.5e-2) +,2e-1 (1e-2)\n", {}, "summary of runs"),
        ("Function,Algorithm,Mean,Std\nF1,PSO,1,2\n", {}, "Mean, Std: a summary of runs"),
        (
            long("Function,Algorithm,Run,Fitness") + "Sphere,GWO,1,7\n",
            {},
            "several rows are of one run of GWO on Sphere",
        ),
        ("Function,Algorithm\nF1,PSO\n", {}, "no column of values among Function, Algorithm"),
        (long("Testfall,Verfahren,Wdh,Ergebnis"), {}, "Testfall, Verfahren, Wdh, Ergebnis; say.*problem=NAME, opt"),
        (long("Testfall,Verfahren,Wdh,Ergebnis"), {"value": "Ergebnis"}, "Testfall, Verfahren, Wdh; say which"),
        ("Lfd,GWO,PSO\n1,3.5,2\n2,1.5,7\n", {}, "Lfd, GWO, PSO; say which"),
        ("Function,Algorithm,a,b\nF1,GWO,1.5,2\nF1,PSO,3.5,7\n", {}, "a, b; say which"),
        ("Optimizer;F1\nGWO;1,5\nGWO;1.2.3\nPSO;7\n", {}, "column 'F1', data row 2, has '1.2.3', which is no number"),
        (long("Function,Algorithm,Run,Fitness"), {"optimizer": "Algo"}, "has no column 'Algo'"),
        (long("Function,Algorithm,Run,Fitness"), {"optimiser": "Algorithm"}, "a column is no 'optimiser'"),
    ],
)
def test_what_cannot_be_tested_is_refused_with_a_sentence(tmp_path, text, columns, sentence):
    with pytest.raises(BenchError, match=sentence):
        imported(tmp_path, text, columns=columns)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("text", "values", "note"),
    [
        ("Optimizer;F1;F2\nGWO;1.234,5;1,5\nPSO;1.200;2\n", [1.5, 2, 1200, 1234.5], "1 run of 2 optimizers on 2"),
        ('Optimizer,F1\nGWO,"1,234.5"\nPSO,"1,200"\n', [1200, 1234.5], "1 run of 2 optimizers on 1"),
        ("Optimizer,F1\nGWO,Failed\nGWO,7\nPSO,nan\nPSO,TIMEOUT\n", [7] + [np.inf] * 3, "3 runs failed, and count as"),
        ("iteration,GWO,PSO\n1,9,8\n2,7,6\n3,5,6\n", [5, 6], "1 run of 2 optimizers on 1"),
        ("evaluations,GWO,PSO\n10,9,8\n20,7,6\n30,5,6\n", [5, 6], "1 run of 2 optimizers on 1"),
        ("Function,Algorithm,gen,Fitness\nF1,GWO,1,9\nF1,GWO,2,7\nF1,PSO,1,8\n", [7, 8], "1 run of 2 optimizers on 1"),
        ("Function,Algorithm,FES,Fitness\nF1,GWO,50,9\nF1,GWO,50,7\n", [7, 9], "2 runs of 1 optimizer on 1"),
        ("Function,Algorithm,HV\nF1,GWO,0.5\nF1,PSO,nan\n", [-0.5, np.inf], "1 run failed, and counts as the worst"),
    ],
)
def test_numbers_failures_and_courses_are_read(tmp_path, text, values, note):
    notes = imported(tmp_path, text).notes
    assert any(each.startswith(note) for each in notes), notes
    results = Results(tmp_path / "out")
    assert sorted(results.frame["fun"]) == values
    assert ("; values are negated where higher is better" in results.study.title) == ("HV" in text)


def test_without_evaluations_the_words_speak_of_no_budget(tmp_path):
    imported(tmp_path, long("Function,Algorithm,Run,Fitness"))
    results = Results(tmp_path / "out")
    assert results.study.budget_words == "an unknown budget"
    assert results.frame["nfev"].isna().all()


def test_a_frame_of_another_tool_is_tidy(tmp_path):
    table = pd.DataFrame(records(problem="Function", optimizer="Algorithm", run="Run", value="Best"))
    with pytest.warns(UserWarning, match="Best = value"):
        frame = bench.load_results(table)
    assert list(bench.analysis.summarise(frame)["optimizer"].unique()) == OPTIMIZERS
    assert frame["fun"].tolist() == table["Best"].tolist()
