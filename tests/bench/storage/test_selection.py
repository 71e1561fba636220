"""A study selects cells of a store, which keeps all it has: changed code is another cell, a new label is not."""

from collections import Counter
from dataclasses import replace

import pytest

from bench import BenchError, Study
from bench.storage.cells import Cells
from bench.storage.selection import select
from bench.study import Entry
from bench.study.cell import with_inputs

CODE = {label: label for label in "abcd"}
DIMENSIONS = {"p": 2, "q": 3, "first": 2}


class Now:
    """What optimizers would be made from now: the state of one file, by label."""

    def __init__(self, code):
        self.code = code

    def changed(self, recorded, label=""):
        return [name for name, (state, _) in recorded.items() if self.code.get(label) != state]


def study(*labels, problems=("p", "q"), **changes):
    entries = tuple(Entry("x", label) if isinstance(label, str) else label for label in labels)
    return Study("s", tuple(Entry(label, label) for label in problems), entries, trials=3, budget=10, **changes)


def made_from(cells, code):
    return {cell.optimizer: {"file:f.py": (code[cell.labels[1]], [])} for cell in cells}


def held(ran, code=CODE, trials=3):
    """Return the cells of a store in which a study ran."""
    cells = ran.cells(DIMENSIONS)
    numbered = dict(enumerate(cells.values(), start=1))
    made = made_from(cells.values(), code)
    return Cells(numbered, dict(enumerate(cells, start=1)), "id", made, Counter(dict.fromkeys(numbered, trials)))


def again(ran, now, code=CODE, now_code=None):
    return select(now.cells(DIMENSIONS), now.trials, held(ran, code), Now(now_code or code))


def test_the_same_study_selects_the_same_cells_and_says_nothing():
    chosen = again(study("a", "b"), study("a", "b"))
    assert chosen.cells == study("a", "b").cells(DIMENSIONS)
    assert chosen.notes == []
    assert chosen.labels_in(held(study("a", "b"))) == {1: ("p", "a"), 2: ("p", "b"), 3: ("q", "a"), 4: ("q", "b")}


def test_changed_code_is_another_cell_and_the_file_is_named():
    chosen = again(study("a", "b"), study("a", "b"), now_code=CODE | {"a": "new"})
    assert chosen.notes == ["a changed (f.py) and is version 2 now: 6 trials to make; the 6 of version 1 are kept"]
    assert chosen.labels_in(held(study("a", "b"))) == {2: ("p", "b"), 4: ("q", "b")}


def test_a_version_that_is_there_already_is_taken_up_again():
    cells = held(study("a"))
    more = {
        number: cell._replace(optimizer=with_inputs(cell.optimizer, 2))
        for number, cell in enumerate(study("a").cells(DIMENSIONS).values(), start=3)
    }
    cells = Cells(
        cells.all | more,
        {3: ("p", "a"), 4: ("q", "a")},
        "id",
        cells.made | made_from(more.values(), {"a": "new"}),
        cells.trials | Counter(dict.fromkeys(more, 2)),
    )
    chosen = select(study("a").cells(DIMENSIONS), 3, cells, Now(CODE))
    assert chosen.notes == ["a changed (f.py) and is version 1 now: 0 trials to make; the 4 of version 2 are kept"]
    assert chosen.labels_in(cells) == {1: ("p", "a"), 2: ("q", "a")}
    assert [*cells.versions["a"].values()] == [[1, 2], [3, 4]]
    third = select(study("a").cells(DIMENSIONS), 3, cells, Now({"a": "third"}))
    assert third.notes == ["a changed (f.py) and is version 3 now: 6 trials to make; the 4 of version 2 are kept"]


def test_the_last_version_is_taken_while_it_has_no_trial():
    cells = held(study("a"))
    number, cell = 3, study("a").cells(DIMENSIONS)["p", "a"]
    later = cell._replace(optimizer=with_inputs(cell.optimizer, 2))
    cells = Cells(cells.all | {number: later}, {number: ("p", "a")}, "id", cells.made, cells.trials)
    chosen = select(study("a", problems=("p",)).cells(DIMENSIONS), 3, cells, Now({"a": "third"}))
    assert chosen.cells["p", "a"] == later


def test_a_new_label_of_the_same_keeps_trials_and_seeds():
    chosen = again(study("a", "b"), study(Entry("x", "c"), "b"), now_code=CODE | {"c": CODE["a"]})
    assert chosen.seeds["p", "c"] == ("p", "a")
    assert chosen.notes == ["the optimizer a is called c now, and keeps its 6 trials"]


def test_a_new_label_with_other_code_is_called_otherwise_and_another_version():
    cells = held(study("a"))
    renamed = Cells(cells.all, {1: ("p", "c"), 2: ("q", "c")}, "id", cells.made, cells.trials)
    chosen = select(study("a").cells(DIMENSIONS), 3, renamed, Now({"a": "new"}))
    assert chosen.notes == [
        "the optimizer c is called a now, and changed (f.py) and is version 2 now: its 6 trials are kept"
    ]


def test_a_renamed_problem_keeps_trials_and_seeds():
    now = replace(study("a"), problems=(Entry("p", "first"), Entry("q", "q")))
    chosen = again(study("a"), now)
    assert chosen.seeds["first", "a"] == ("p", "a")
    assert chosen.notes == ["the problem p is called first now, and keeps its 3 trials"]


def test_two_entries_that_differ_in_their_labels_alone_are_two_cells():
    alike = {"a": "", "b": ""}
    cells = study("a", "b").cells(DIMENSIONS)
    assert len(set(cells.values())) == 4
    assert again(study("a"), study("a", "b"), alike).seeds["p", "b"] == ("p", "b")


def test_a_label_that_comes_back_gets_its_cells_back():
    alike = {"a": "", "b": ""}
    cells = held(study("a"), alike)
    renamed = Cells(cells.all, {1: ("p", "b"), 2: ("q", "b")}, "id", cells.made, cells.trials)
    chosen = select(study("a", "b").cells(DIMENSIONS), 3, renamed, Now(alike))
    assert chosen.seeds["p", "a"] == ("p", "a")
    assert chosen.seeds["p", "b"] == ("p", "b")


def test_a_label_that_may_mean_two_others_is_refused():
    alike = dict.fromkeys("abc", "")
    with pytest.raises(
        BenchError, match="the optimizer 'c' is new to the folder, and may be 'a', 'b', which the study no"
    ):
        again(study("a", "b"), study("c"), alike)


def test_what_a_study_no_longer_names_is_kept_and_counted():
    chosen = again(study("a", "b"), study("a", problems=("p",)))
    assert chosen.notes == [
        "the problem q is no longer in the study: its 6 trials are kept",
        "the optimizer b is no longer in the study: its 6 trials are kept",
    ]


def test_other_evaluations_and_seeds_are_named_together():
    chosen = again(study("a"), replace(study("a"), seed=4, budget="10 * d"))
    assert chosen.notes == ["evaluations changed, seed changed from 0 to 4: 6 trials to make; the 6 before are kept"]


def test_trials_join_the_version_that_was_made_from_no_other_state():
    cells = held(study("a"))
    cell = cells.all[1]
    assert cells.fitting(cell, [{}, {"file:lazy.py": ("l", [])}]) == cell  # read late by one of them
    other = cells.fitting(cell, [{}, {"file:f.py": ("edited", [])}])
    assert other == cell._replace(optimizer=with_inputs(cell.optimizer, 2))
    cells.all[9] = other
    cells.add(other, [{}, {"file:f.py": ("edited", [])}])
    assert cells.fitting(cell, [{}, {"file:f.py": ("edited", [])}]) == other
    assert cells.fitting(other, [{}, {"file:f.py": ("a", [])}]) == cell
