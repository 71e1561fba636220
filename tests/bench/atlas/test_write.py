"""The folder of an atlas."""

import pytest

from bench.atlas.compare import compare
from bench.atlas.runs import Surveyed
from bench.atlas.table import Implementation, Method
from bench.atlas.write import method_page, write_atlas
from bench.errors import BenchError
from tests.bench.atlas.made import surveyed


def sample(shift=3.0, trials=12, differs=""):
    one = surveyed("lib:One", trials=trials, dead={"w": "0.1, 0.2"})
    other = surveyed("two", trials=trials, shift=shift, seed=1, repeatable=False, microseconds=2.0)
    lost = Surveyed(Implementation("m", "lost|one", "lost"), failed="it *cannot*")
    method = Method("m", "A method", "All have 5 agents.", 5, (Implementation("m", "lib:One", "lib:One", {}, differs),))
    return compare([one, other, lost]), [method]


def test_an_atlas_is_a_folder_of_pages_tables_and_a_map(tmp_path):
    found, methods = sample()
    page = write_atlas(found, methods, tmp_path / "atlas", trials=12, budget=60, seed=4)
    names = {each.name for each in page.parent.iterdir()}
    tables = {f"{each}.csv" for each in ("implementations", "pairs", "tests", "medians", "times")}
    assert names == {"index.md", "m.md", "map.svg", *tables}
    text = page.read_text(encoding="utf-8")
    assert "12 trials of 60 evaluations on each of 10 functions, d = 5; seed 4" in text
    assert "1 of 1 pair of implementations of one method is different" in text
    assert "[A method](m.md)" in text
    assert "without effect: w (tried 0.1, 0.2)" in text
    assert "failed: it \\*cannot\\*" in text
    assert "a seed does not repeat its runs" in text


def test_the_same_atlas_gives_the_same_bytes_and_replaces_an_earlier_one(tmp_path):
    for name, shift in (("one", 3.0), ("other", 0.0), ("other", 3.0)):
        write_atlas(*sample(shift), tmp_path / name, trials=12, budget=60, seed=4)
    for each in (tmp_path / "one").iterdir():
        assert each.read_bytes() == (tmp_path / "other" / each.name).read_bytes()


def test_no_page_has_a_time(tmp_path):
    found, methods = sample()
    page = write_atlas(found, methods, tmp_path / "atlas", trials=12, budget=60, seed=4)
    assert "microseconds" not in "".join(each.read_text(encoding="utf-8") for each in page.parent.glob("*.md"))
    assert (page.parent / "times.csv").read_text(encoding="utf-8").splitlines()[1:] == [
        "m,lib:One,1.0", "m,two,2.0", "m,lost|one,"
    ]  # fmt: skip


def test_a_page_says_which_difference_is_documented():
    without = method_page(*(lambda found, methods: (found, methods[0], "size"))(*sample()))
    assert "No documented difference is known here for `lib:One` against `two`." in without
    assert "**different**" in without


def test_a_page_of_too_few_trials_says_so():
    found, [method] = sample(trials=3)
    text = method_page(found, method, "size")
    assert "So few trials can show no difference" in text
    assert "not found different" in text


@pytest.mark.parametrize("name", ["thesis.tex", "README.md", "gwo.md"])
def test_a_folder_with_other_files_is_kept(tmp_path, name):
    (tmp_path / name).touch()
    (tmp_path / "implementations.csv").write_text("method,label\nm,one\n", encoding="utf-8")
    (tmp_path / "m.md").touch()
    with pytest.raises(BenchError, match=f"holds other files than an atlas, such as {name}"):
        write_atlas(*sample(), tmp_path, trials=12, budget=60, seed=4)


def test_a_file_is_no_folder_of_an_atlas(tmp_path):
    (tmp_path / "atlas").touch()
    with pytest.raises(BenchError, match="holds other files"):
        write_atlas(*sample(), tmp_path / "atlas", trials=12, budget=60, seed=4)
