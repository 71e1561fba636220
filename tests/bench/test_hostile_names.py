"""Names are data: whatever labels, titles and files are called, nothing is written elsewhere, run or rendered."""

import pytest

from bench import BenchError, Study, load_results, run
from bench.storage.merge import merge

LABELS = [
    "../../escaped", "/etc/escaped", "..", "<script>alert(1)</script>", "\\input{/etc/passwd}", "$(touch escaped)",
    "a'); DROP TABLE results;--", "con", "x" * 200, "\N{PILE OF POO} é 漢", "-restart +2",
    '" onmouseover="alert(1)', "%s %(x)s {0} {{7*7}}", "a;b,c d", "&amp; & ~#_^",
]  # fmt: skip


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with a study of hostile names that was run, all of it three levels down."""
    place = tmp_path_factory.mktemp("names")
    (place / "a" / "b").mkdir(parents=True)
    study = Study.from_dict(
        {"name": "names", "title": "<b>bold</b> \\textbf{title} & more", "trials": 2, "budget": 30,
         "problems": [{"name": "sphere-2", "label": label} for label in LABELS[:8]],
         "optimizers": [{"name": "scatter", "agents": 5, "label": label} for label in LABELS]}
    )  # fmt: skip
    run(study, place / "a" / "b" / "out", n_jobs=1)
    return place


def test_every_label_comes_back_as_it_was(place):
    frame = load_results(place / "a" / "b" / "out")
    assert frame["optimizer"].unique().tolist() == LABELS
    assert frame["problem"].unique().tolist() == LABELS[:8]
    assert frame["status"].eq("ok").all()


@pytest.mark.parametrize("kind", ["problems", "optimizers"])
@pytest.mark.parametrize(
    "label",
    ["=cmd|' /C calc'!A0", "=1", "-2+3+cmd|' /C calc'!A0", "@SUM(1)", "-SUM(A1:A2)",
     "a\x1b[31mred", "a\nb", "a\x00b", "a\N{RIGHT-TO-LEFT OVERRIDE}b", ""],
)  # fmt: skip
def test_labels_that_would_deceive_a_spreadsheet_or_a_terminal_are_refused(kind, label):
    data = {"name": "s", "problems": [{"name": "sphere-2"}], "optimizers": [{"name": "scatter"}]}
    data[kind][0]["label"] = label
    with pytest.raises(BenchError, match=r"a spreadsheet would compute|control character|all of them texts"):
        Study.from_dict(data)


def test_status_rm_and_merge_take_them_for_names(bench_here, place, tmp_path):
    out = place / "a" / "b" / "out"
    done = bench_here("status", out)
    assert "DROP TABLE" in done.stdout
    done = bench_here("rm", out, "--optimizer", LABELS[6], "--problem", LABELS[0], "--dry-run")
    assert "2 trials would be removed" in done.stdout
    assert merge([out], tmp_path / "united").rows == 2 * 8 * len(LABELS)


@pytest.mark.parametrize("name", ["../x", "a/b", "/etc", "..", "a b", "a\x00", "<b>", "x" * 101, ".hidden"])
def test_a_study_s_name_names_a_folder_and_no_other_place(name):
    with pytest.raises(BenchError, match="as it names a folder"):
        Study.from_dict({"name": name, "problems": [{"name": "sphere-2"}], "optimizers": [{"name": "scatter"}]})
