"""IOHprofiler's format before JSON: what it holds comes back, and files that are refused."""

import pytest

from bench import BenchError, Results, load_problem
from bench.formats.importing import import_results

COLUMNS = '"function evaluation" "current f(x)" "best-so-far f(x)" "current af(x)+b" "best af(x)+b" sigma'
HEAD = 'suite = "Mine", funcId = 3, funcName = "Bowl", DIM = {d}, maximization = "F", algId = "rs", algInfo = "", '
INFO = "\n".join(
    [
        HEAD.format(d=2) + 'note = "a, b", dynamicAttribute = "seed"',
        "%",
        "data_f3_Bowl/IOHprofiler_f3_DIM2.dat, 1:7|0.125;10, 2:4|3;11,",
        "1:5|2.5;12",
        HEAD.format(d=5),
        "%",
        "data_f3_Bowl\\IOHprofiler_f3_DIM5.dat, 1:2|1e-08",
    ]
)
TWO = f"""{COLUMNS}
1 +5.00000e+00 +5.00000e+00 +6.00000e+00 +6.00000e+00 0.1
7 +1.25000e-01 +1.25000e-01 +1.12500e+00 +1.12500e+00 0.1
9 +4.00000e+00 +1.25000e-01 +5.00000e+00 +1.12500e+00 0.1
{COLUMNS}
4 3.0000000000 3.0000000000 5.0000000000 5.0000000000 None
{COLUMNS}
1\t2.5\t2.5\t2.5\t2.5\t0.5
5\t2.5\t2.5\t2.5\t2.5\t0.5
"""
FIVE = '"function evaluation" "best-so-far f(x)"\n1 9.0\n2 0.0000000100\n'


def written(folder, info=INFO, two=TWO, five=FIVE, suffix=".dat"):
    (folder / "data_f3_Bowl").mkdir(parents=True)
    (folder / "IOHprofiler_f3_Bowl.info").write_text(info)
    for dimension, text in ((2, two), (5, five)):
        (folder / f"data_f3_Bowl/IOHprofiler_f3_DIM{dimension}{suffix}").write_text(text)
    return folder


@pytest.mark.parametrize("suffix", [".dat", ".cdat", ".tdat"])
def test_runs_come_back(tmp_path, suffix):
    found = import_results(written(tmp_path / "x", suffix=suffix), tmp_path / "back")
    assert (found.format, found.trials, found.problems, found.optimizers) == ("ioh-info", 4, 3, 1)
    results = Results(tmp_path / "back")
    frame = results.frame[["problem", "optimizer", "trial", "fun", "nfev"]]
    assert frame.to_numpy().tolist() == [
        ["mine-f03-d2-i1", "rs", 0, 0.125, 9],
        ["mine-f03-d2-i1", "rs", 1, 2.5, 5],
        ["mine-f03-d2-i2", "rs", 0, 3.0, 4],
        ["mine-f03-d5-i1", "rs", 0, 1e-8, 2],
    ]
    assert results.traces["mine-f03-d2-i1", "rs", 0].evaluations.tolist() == [1, 7]


def test_the_first_format_has_single_quotes_no_names_and_an_index_for_each_instance(tmp_path):
    folder = tmp_path / "old"
    (folder / "data_fbowl").mkdir(parents=True)
    for instance in (1, 2):
        (folder / f"IOHprofiler_fbowl_i{instance}.info").write_text(
            f"suite = 'Mine', funcId = 'bowl', DIM = 2, algId = 'A (1+1)', algInfo = 'x'\n%\n"
            f"data_fbowl/IOHprofiler_fbowl_DIM2_i{instance}.dat, {instance}:500|2.00000e+00, {instance}:0|0.0\n"
        )
        (folder / f"data_fbowl/IOHprofiler_fbowl_DIM2_i{instance}.dat").write_text(
            '"function evaluation" "best-so-far f(x)"\n1 3.00000e+00\n20 2.00000e+00\n'
        )
    import_results(folder, tmp_path / "back")
    frame = Results(tmp_path / "back").frame
    assert frame["problem"].tolist() == ["mine-bowl-d2-i1", "mine-bowl-d2-i2"]
    assert frame["optimizer"].unique().tolist() == ["A (1+1)"]
    assert frame["nfev"].tolist() == [500, 500]  # the index counts them where the log has improvements only


class TestBbob:
    """Sphere in 2 dimensions, whose f_opt is 79.48: raw values lack it."""

    LOG = f"{COLUMNS}\n1 4.0 4.0 83.48 83.48 0\n6 0.25 0.25 79.73 79.73 0\n"
    INFO = (
        'suite = "{suite}", funcId = 1, funcName = "Sphere", DIM = 2, maximization = "F", algId = "rs"\n'
        "%\ndata/log.dat, 1:6|{final}\n"
    )

    @pytest.fixture(autouse=True)
    def coco(self):
        pytest.importorskip("cocoex", reason="the optimal values of bbob come from coco-experiment")

    def bbob(self, folder, suite="BBOB", final="79.73", log=LOG):
        (folder / "data").mkdir(parents=True)
        (folder / "data/log.dat").write_text(log)
        (folder / "IOHprofiler_f1_Sphere.info").write_text(self.INFO.format(suite=suite, final=final))
        return folder

    @pytest.mark.parametrize("suite", ["BBOB", "No suite", "unknown_suite"])
    @pytest.mark.parametrize("final", ["79.73", "0.25"])  # versions differ in it
    def test_it_gets_this_project_s_names_and_objective_values(self, tmp_path, suite, final):
        import_results(self.bbob(tmp_path / "x", suite, final), tmp_path / "back")
        (row,) = Results(tmp_path / "back").frame.to_dict("records")
        assert row["problem"] == "bbob-f01-d2-i1"
        assert row["fun"] == 0.25 + load_problem("bbob-f01-d2-i1").optimum

    def test_another_optimum_is_refused(self, tmp_path):
        log = self.LOG.replace("83.48", "84.48").replace("79.73", "80.73")
        with pytest.raises(BenchError, match=r"run 1, has f_opt = 80\.48 for bbob-f01-d2-i1, whose optimum is 79\.48"):
            import_results(self.bbob(tmp_path / "x", final="80.73", log=log), tmp_path / "back")


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"info": INFO.replace('"F"', '"T"')}, "f3_Bowl.info, line 1, is of maximisation"),
        ({"info": INFO.replace("Mine", "PBO")}, "is of maximisation"),
        ({"info": INFO.replace("DIM = 5", "DIM = x")}, "line 5, has no dimension"),
        ({"info": INFO.replace("data_f3_Bowl/", "../other/")}, "line 3, names .* outside the folder"),
        ({"info": INFO[: INFO.index("data_f3_Bowl\\")]}, "line 5, names no run; the index is cut short"),
        ({"info": INFO.replace("2:4|3;11", "2:4")}, "line 3, has '2:4' where a run such as"),
        ({"info": INFO.replace("2:4|3;11", "2:4|x")}, "line 3, has the run '2:4|x', which cannot be read"),
        ({"info": ""}, "is empty, and no index of IOHprofiler"),
        ({"info": "1:2|3\n"}, "line 1, is no index of IOHprofiler"),
        ({"info": INFO.replace("\n1:5|2.5;12", "")}, "has 3 runs and .*info names 2; one of them is cut short"),
        ({"info": INFO.replace("DIM5.dat", "DIM7.dat")}, r"the log data_f3_Bowl/IOHprofiler_f3_DIM7.dat is missing"),
        ({"two": TWO[:-4]}, "DIM2.dat is cut short in line 9"),
        ({"two": TWO[: TWO.index("7 +1")]}, "has 1 runs and .* names 3"),
        ({"two": TWO.replace("9 +4.00000e+00 +1.25000e-01", "9 +4.00000e+00 +4.00000e+00")}, "rises with evaluation 9"),
        ({"two": TWO.replace("\n7 +1", "\n12 +1")}, "line 4, has evaluation 9 after evaluation 12"),
        ({"two": TWO.replace("4 3.0", "4 x", 1).replace("3.0000000000 5", "x 5", 1)}, "line 6, is no row of"),
        ({"two": TWO.replace("best-so-far f(x)", "other")}, "line 1, has no column 'best-so-far f"),
        ({"five": FIVE.replace("2 0.0000000100\n", "")}, r"run 1, ends at 9.0 and its index has 1e-08; one of them is"),
        ({"five": FIVE[: FIVE.index("1 9")]}, "run 1, has no evaluation; the log may be cut short"),
    ],
)
def test_what_is_broken_is_named_and_nothing_is_imported(tmp_path, changes, sentence):
    with pytest.raises(BenchError, match=sentence):
        import_results(written(tmp_path / "x", **changes), tmp_path / "back")
    assert [each.name for each in tmp_path.iterdir()] == ["x"]


def test_it_is_no_index_of_coco(tmp_path):
    folder = written(tmp_path / "x")
    (folder / "bbobexp_f1.info").write_text("funcId = 1\n")
    with pytest.raises(BenchError, match="holds results of coco and of ioh-info; import one of them at a time"):
        import_results(folder, tmp_path / "back")
