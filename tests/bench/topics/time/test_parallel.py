"""The section on several workers: who is first where, and no section where calls are not known."""

import pandas as pd

from bench import Results
from bench.topics.findings import Findings
from bench.topics.time.parallel import order_changes, section


def ranks(first):
    """Build ranks of two optimizers from {(workers, seconds): the first one}."""
    rows = [(*place, name, 1.0 if name == best else 2.0) for place, best in first.items() for name in ("a", "b")]
    return pd.DataFrame(rows, columns=["workers", "seconds", "optimizer", "rank"])


def test_one_that_is_first_everywhere_is_named_once():
    everywhere = ranks({(p, c): "b" for p in (1, 8) for c in (0.001, 60.0)})
    assert order_changes(everywhere) == (
        "b has the lowest rank at every cost from 1 ms to 1 min an evaluation, with 1 to 8 workers."
    )


def test_where_the_order_changes_is_said_along_both_axes():
    changing = ranks({(1, 0.1): "b", (1, 5.0): "a", (2, 0.1): "b", (2, 5.0): "a", (8, 0.1): "b", (8, 5.0): "b"})
    assert order_changes(changing) == (
        "The order changes. With evaluations of 5 s, the lowest rank is that of a with 1 to 2 workers, then b with 8 "
        "workers. With one worker, it is that of b at 100 ms an evaluation, then a at 5 s an evaluation."
    )


def test_the_section_has_a_map_and_the_times_behind_it(make, tmp_path):
    calls = {label: {"calls": number} for label, number in (("a", 5), ("b", 100), ("c", 20))}
    found = section(Findings(Results(make(tmp_path / "s", changes=calls))))
    figure, table = found.items
    assert (figure.name, table.name) == ("fastest-map", "parallel-ranks")
    assert [*table.frame] == ["1", "2", "4", "8", "16", "32", "64"]
    assert {"workers", "seconds", "turns", "time"} <= {*table.data}


def test_without_calls_there_is_no_section(make, tmp_path):
    assert section(Findings(Results(make(tmp_path / "s")))) is None
