"""A board from archives: its ranks, its provenance, and what it refuses."""

import re
import shutil
import zipfile

import numpy as np
import pandas as pd
import pytest

from bench import BenchError, Study, columns, run
from bench.board import write_board
from bench.board.ranks import mean_ranks
from bench.formats.archive import pack
from bench.objective import Trace
from bench.plugins.registry import DISTRIBUTION
from bench.sandbox import bubblewrap
from bench.storage.folder import Folder
from bench.storage.selection import Selection
from bench.study import Fingerprints
from bench.trial import Trial
from tests.bench.storage.filled import recell

RECORD = {
    "started": "2026-01-01T00:00:00+00:00", "ended": "2026-01-02T00:00:00+00:00", "python": "3.12.1",
    "packages": {DISTRIBUTION: "1.2.3"},
}  # fmt: skip
PROBLEMS = ("bbob-f01-d2-i1", "bbob-f02-d2-i1")


def row(fun):
    if fun is None:
        return {"status": "failed", "error": "RuntimeError: no"}
    return {
        "status": "ok", "fun": fun, "nfev": 60, "wall_s": 0.5, "cpu_s": 0.5, "objective_s": 0.1, "stop": "budget",
        "outside_box": 0, "x": {"x1": fun, "x2": 0.0}, "metrics": {}, "trace": Trace(np.array([1]), np.array([fun])),
    }  # fmt: skip


def packed(path, scores, record=RECORD, known=False, **study):
    """Pack a study in which each optimizer's trials on every problem end at the scores given by its label."""
    folder = Folder(path.with_suffix(""))
    folder.path.mkdir(parents=True)
    agents = {label: 2 + sum(map(ord, label)) % 40 for label in scores}
    content = {
        "name": "small", "trials": 2, "budget": 60, "problems": [{"names": [*PROBLEMS]}],
        "optimizers": [{"name": "scatter", "label": label, "agents": number} for label, number in agents.items()],
    }  # fmt: skip
    made = Study.from_dict(content | study)
    folder.claim(made, Selection(made.cells(made.check() if known else Fingerprints({}, {}, {}))))
    with folder.store.writer() as writer:
        number = writer.environment(record)
        for problem in PROBLEMS:
            for label, values in scores.items():
                for trial, fun in enumerate(values):
                    writer.add(Trial(problem, label, trial, 7), columns.packed(row(fun)), number)
    folder.write_environments()
    file = pack(folder.path, path).path
    shutil.rmtree(folder.path)
    return file


def rows(board):
    table = pd.read_csv(board.page.parent / "board.csv")
    return [(each.optimizer, each.archive, each.place, each.mean_rank) for each in table.itertuples()]


@pytest.fixture
def two(tmp_path):
    """Two archives of one setting and other seeds."""
    return [
        packed(tmp_path / "a.zip", {"good": (1.0, 2.0), "lost": (3.0, None)}, seed=1),
        packed(tmp_path / "b.zip", {"best": (0.0, 0.5), "tied": (1.0, 2.0)}, seed=2),
    ]


def contents(folder):
    return {each.relative_to(folder).as_posix(): each.read_bytes() for each in folder.rglob("*") if each.is_file()}


def test_optimizers_of_one_setting_are_ranked_together(two, tmp_path):
    board = write_board(two, tmp_path / "board")
    assert rows(board) == [
        ("best", "b.zip", 1, 1.0), ("good", "a.zip", 2, 2.5), ("tied", "b.zip", 2, 2.5), ("lost", "a.zip", 4, 4.0)
    ]  # fmt: skip


def test_the_first_page_opens_with_a_ranking(two, tmp_path):
    page = write_board(two, tmp_path / "site").page.read_text(encoding="utf-8")
    assert page.index("4 optimizers ranked on") < page.index("each unpacked and compared")


def test_every_row_says_where_it_comes_from(two, tmp_path):
    page = write_board(two, tmp_path / "board").page.read_text()
    table = page.partition("bbob-f01")[2].partition("</table>")[0]
    found = [each for each in table.split("<tr>") if "<td" in each]
    assert len(found) == 4
    for each in found:
        assert re.search(r'href="studies/[ab]-zip-[0-9a-f]{8}.html">[ab].zip</a>', each)
        assert "bench 1.2.3, Python 3.12.1" in each
        assert "2026-01-02" in each
        assert re.search(r">[0-9a-f]{12}<", each)


@pytest.mark.parametrize("other", [{"budget": 61}, {"constraints": "death"}])
def test_another_setting_has_a_table_of_its_own(two, tmp_path, other):
    third = packed(tmp_path / "c.zip", {"other": (9.0, 9.0)}, **other)
    found = rows(write_board([*two, third], tmp_path / "board"))
    assert ("other", "c.zip", 1, 1.0) in found
    assert ("lost", "a.zip", 4, 4.0) in found


def test_more_problems_are_another_setting(two, tmp_path):
    more = {"problems": [{"names": [*PROBLEMS, "bbob-f03-d2-i1"]}]}
    third = packed(tmp_path / "c.zip", {"other": (0.1, 0.1)}, **more)
    found = rows(write_board([*two, third], tmp_path / "board"))
    assert [place for label, _, place, _ in found if label == "best"] == [1]


def test_an_optimizer_without_trials_on_a_problem_has_no_rank(tmp_path):
    only = {"problems": [{"names": ["bbob-f01-d2-i1", "bbob-f02-d2-i1"]}]}
    folder = Folder(tmp_path / "part")
    folder.path.mkdir()
    study = {"name": "part", "trials": 1, "budget": 60, "optimizers": [{"name": "scatter"}, {"name": "early"}]}
    folder.claim(Study.from_dict(study | only))
    with folder.store.writer() as writer:
        number = writer.environment(RECORD)
        for problem, label in (
            ("bbob-f01-d2-i1", "scatter"),
            ("bbob-f02-d2-i1", "scatter"),
            ("bbob-f01-d2-i1", "early"),
        ):
            writer.add(Trial(problem, label, 0, 7), columns.packed(row(1.0)), number)
    folder.write_environments()
    board = write_board([pack(folder.path, tmp_path / "part.zip").path], tmp_path / "board")
    table = pd.read_csv(tmp_path / "board" / "board.csv")
    assert list(table["optimizer"]) == ["scatter", "early"]
    assert table["mean_rank"].isna().tolist() == [False, True]
    assert "without a trial on some problem has no rank" in board.page.read_text()


def test_a_setting_in_which_nothing_can_be_ranked_is_shown_without_ranks(tmp_path):
    file = packed(tmp_path / "a.zip", {"x": (1.0,)}, problems=[{"names": [*PROBLEMS, "bbob-f03-d2-i1"]}])
    board = write_board([file], tmp_path / "board")
    assert pd.read_csv(tmp_path / "board" / "board.csv")["place"].isna().all()
    assert "0 optimizers ranked on" in board.page.read_text()


def test_imported_trials_are_ranked_among_themselves(two, tmp_path):
    imported = {"optimizers": [{"name": "imported:x", "label": "x"}]}
    files = [
        packed(tmp_path / f"{name}.zip", {"x": (0.0, value)}, **imported) for name, value in (("c", 0.1), ("d", 0.2))
    ]
    found = write_board([*two, *files], tmp_path / "board")
    assert rows(found)[-2:] == [("x", "c.zip", 1, 1.0), ("x", "d.zip", 1, 1.0)]
    table = pd.read_csv(tmp_path / "board" / "board.csv")
    assert table.loc[table["optimizer"] == "x", "seed"].tolist() == ["unknown", "unknown"]


def test_the_same_trials_count_once(two, tmp_path):
    copy = packed(tmp_path / "c.zip", {"good": (1.0, 2.0), "new": (8.0, 8.0)}, seed=1)
    board = write_board([*two, copy], tmp_path / "board")
    assert [archive for label, archive, _, _ in rows(board) if label == "good"] == ["a.zip"]
    assert "good of c.zip has the trials of good of a.zip" in board.page.read_text()


def test_ranks_follow_rivals_beaten_then_chance():
    # On one problem: 0 beats both; 1 and 2 beat none or one.
    mean, chance = mean_ranks([[np.array([0.0])], [np.array([1.0])], [np.array([2.0])]])
    assert (mean.tolist(), chance.tolist()) == ([1, 2, 3], [1, 0.5, 0])
    mean, _ = mean_ranks([[np.array([1.0])], [np.array([1.0 + 1e-12])], [np.array([np.inf, np.inf])]])
    assert mean.tolist() == [1.5, 1.5, 3]
    mean, chance = mean_ranks([[np.array([1.0])]])
    assert mean.tolist() == [1.0]
    assert np.isnan(chance).all()


def test_the_order_of_arguments_changes_no_byte(two, tmp_path):
    write_board(two, tmp_path / "one")
    write_board(two[::-1], tmp_path / "other")
    assert contents(tmp_path / "one") == contents(tmp_path / "other")
    write_board(two, tmp_path / "one")  # replaces an earlier board
    assert contents(tmp_path / "one") == contents(tmp_path / "other")


def test_scripts_in_labels_and_titles_are_texts(tmp_path):
    evil = "<script>alert(1)</script>"
    record = {"packages": {DISTRIBUTION: evil}, "python": [evil], "ended": 5, "command": evil, evil: {evil: evil}}
    scores = {evil: (1.0, 2.0), '"><img src=x>': (2.0, 3.0)}
    file = packed(tmp_path / "a&<b>.zip", scores, record, title=f"{evil} & co")
    write_board([file], tmp_path / "board")
    for name, content in contents(tmp_path / "board").items():
        if name.endswith(".html"):
            page = content.decode()
            assert evil not in page
            assert "<img" not in page
            assert "&lt;script&gt;alert(1)" in page
            assert "a&amp;&lt;b&gt;.zip" in page


def test_the_pages_load_nothing_and_link_to_files_of_the_board(two, tmp_path):
    board = write_board(two, tmp_path / "board")
    for page in (tmp_path / "board").rglob("*.html"):
        for address in re.findall(r'(?:href|src)="([^"#]+)"', page.read_text()):
            assert (page.parent / address).resolve().is_file()
    assert "default-src 'none'" in board.page.read_text()


# what is refused


def change(file):
    """Change one byte of the trials in an archive."""
    with zipfile.ZipFile(file) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    content["trials.sqlite"] = content["trials.sqlite"][:-1] + bytes([content["trials.sqlite"][-1] ^ 1])
    with zipfile.ZipFile(file, "w") as archive:
        for name, each in content.items():
            archive.writestr(name, each)


def assert_refused(sources, output, match):
    with pytest.raises(BenchError, match=match) as refused:
        write_board(sources, output)
    assert "\n" not in str(refused.value)
    assert not output.exists()


def test_a_changed_archive_is_refused_by_name(two, tmp_path):
    change(two[1])
    assert_refused(two, tmp_path / "board", r"b\.zip: trials\.sqlite was changed")


def test_two_archives_of_one_name_are_refused(two, tmp_path):
    (tmp_path / "there").mkdir()
    again = packed(tmp_path / "there" / "A.zip", {"other": (1.0, 2.0)})
    assert_refused([*two, again], tmp_path / "board", r"two archives have the name a\.zip")


def test_one_study_in_two_archives_is_refused(two, tmp_path):
    again = packed(tmp_path / "c.zip", {"good": (1.0, 2.0), "lost": (3.0, None)}, seed=1, name="renamed")
    assert_refused([*two, again], tmp_path / "board", r"a\.zip and c\.zip hold the same study with the same seed")


@pytest.mark.parametrize("file", ["missing.zip", "none.zip"])
def test_what_is_no_archive_is_refused(tmp_path, file):
    (tmp_path / "none.zip").write_text("none")
    assert_refused([tmp_path / file], tmp_path / "board", file)


def test_other_files_are_not_replaced(two, tmp_path):
    (tmp_path / "board").mkdir()
    (tmp_path / "board" / "index.html").write_text("mine")
    with pytest.raises(BenchError, match="holds other files than a board"):
        write_board(two, tmp_path / "board")
    assert (tmp_path / "board" / "index.html").read_text() == "mine"


@pytest.mark.parametrize("output", ["file", "file/board"])
def test_an_output_that_cannot_be_written_is_refused(two, bench_here, tmp_path, output):
    (tmp_path / "file").write_text("mine")
    done = bench_here("site", *two, "-o", tmp_path / output)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.slow
@pytest.mark.parametrize("output", [".", "link", "new/deep"])
def test_folders_that_are_empty_linked_or_new_are_filled(two, bench_here, tmp_path, output):
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty" / "target").mkdir()
    place = tmp_path / "empty" / "target" if output == "." else tmp_path / "empty"
    (tmp_path / "empty" / "link").symlink_to(tmp_path / "empty" / "target")
    done = bench_here("site", *two, "-o", output, cwd=place)
    assert (done.returncode, done.stderr) == (0, "")
    folder = tmp_path / "empty" / ("new/deep" if output == "new/deep" else "target")
    assert {each.name for each in folder.iterdir()} == {"index.html", "board.csv", "studies"}


def test_the_command_leaves_out_what_is_refused_on_request_only(two, bench_here, tmp_path):
    change(two[1])
    done = bench_here("site", *two, "-o", tmp_path / "board")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert not (tmp_path / "board").exists()
    done = bench_here("site", *two, "-o", tmp_path / "board", "--keep-going")
    assert done.returncode == 1
    assert "b.zip: trials.sqlite was changed" in done.stderr
    assert "b.zip" not in (tmp_path / "board" / "index.html").read_text()


# trials made again

try:
    bubblewrap.find()
    REASON = ""
except BenchError as error:
    REASON = str(error)
sandboxed = pytest.mark.skipif(bool(REASON), reason=REASON or "bubblewrap can be used")


@sandboxed
@pytest.mark.slow
def test_trials_are_made_again(bench_here, tmp_path):
    study = {
        "name": "real", "trials": 2, "budget": 60, "problems": [{"name": "bbob-f01-d2-i1"}],
        "optimizers": [{"name": "random-search"}],
    }  # fmt: skip
    run(Study.from_dict(study), tmp_path / "real", jobs=1)
    file = pack(tmp_path / "real", tmp_path / "real.zip").path
    done = bench_here("site", file, "-o", tmp_path / "board", "--verify", 5)
    assert (done.returncode, done.stderr) == (0, "")
    assert pd.read_csv(tmp_path / "board" / "board.csv")["made_again"].tolist() == ["2 of 2"]
    assert ">2 of 2<" in (tmp_path / "board" / "index.html").read_text()
    [page] = (tmp_path / "board" / "studies").glob("*.html")
    assert page.read_text().count("the same bit by bit") == 2


@pytest.mark.slow
@sandboxed
def test_a_trial_that_differs_is_marked(bench_here, tmp_path):
    file = packed(
        tmp_path / "a.zip", {"forged": (-1e9,)}, known=True, optimizers=[{"name": "random-search", "label": "forged"}]
    )
    done = bench_here("site", file, "-o", tmp_path / "board", "--verify", 1)
    assert done.returncode == 1
    assert re.search(r"different: a\.zip: forged on bbob-f0[12]-d2-i1, trial 0 differs: ", done.stdout)
    assert '<span class="lost">0 of 1; 1 differ</span>' in (tmp_path / "board" / "index.html").read_text()


@pytest.mark.slow
@sandboxed
def test_seeds_that_were_chosen_are_found_out(tmp_path):
    study = Study.from_dict({
        "name": "real", "trials": 1, "budget": 60, "problems": [{"name": "bbob-f01-d2-i1"}],
        "optimizers": [{"name": "random-search"}],
    })  # fmt: skip
    run(study, tmp_path / "lucky", jobs=1)
    folder = Folder(tmp_path / "lucky")
    chosen = {labels: cell._replace(seed=1) for labels, cell in folder.store.held().by_labels.items()}
    recell(folder.store, {cell._replace(seed=0): cell for cell in chosen.values()})
    folder.claim(study.override(seed=1), Selection(chosen))
    board = write_board([pack(tmp_path / "lucky", tmp_path / "lucky.zip").path], tmp_path / "board", verify=1)
    assert board.archives[0].again[0].different


@pytest.mark.slow
@sandboxed
def test_a_trial_that_cannot_be_made_is_marked_with_the_reason(bench_here, tmp_path):
    missing = {"optimizers": [{"name": "not-installed-here", "label": "x"}]}
    file = packed(tmp_path / "a.zip", {"x": (1.0, 2.0)}, **missing)
    for name in ("one", "other"):
        done = bench_here("site", file, "-o", tmp_path / name, "--verify", 1)
        assert done.returncode == 0
        assert "0 of 1; unknown optimizer &#39;not-installed-here&#39;" in (tmp_path / name / "index.html").read_text()
    assert contents(tmp_path / "one") == contents(tmp_path / "other")


def test_no_trial_is_made_without_a_sandbox(two, tmp_path, monkeypatch):
    monkeypatch.setattr("shutil.which", lambda name: None)
    with pytest.raises(BenchError, match=r"needs bubblewrap .* which is not installed here"):
        write_board(two, tmp_path / "board", verify=1)
    assert not (tmp_path / "board").exists()
