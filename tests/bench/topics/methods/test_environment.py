"""The report distinguishes machines and versions, and which trials came from which."""

from tests.bench.topics.methods.records import RECORD


def table(section):
    (shown,) = section.items
    return shown


def content(section, name):
    return next(file.content for file in section.files if file.path == f"tables/{name}.csv")


def test_fifty_environments_can_still_be_read(render):
    section = render([RECORD | {"python": f"3.11.{i}"} for i in range(50)], [1 + i % 50 for i in range(24)])
    ((label, warning, _),) = section.lines
    assert label == "several environments"
    assert warning.startswith("The trials come from 24 different environments")
    assert warning.endswith("D differs from A by Python 3.11.0 → 3.11.3; and 20 more.")
    assert list(table(section).frame) == ["A", "B", "C", "D"]
    assert list(table(section).data.columns[[1, 26, 27, 50]]) == ["A", "Z", "AA", "AX"]
    assert content(section, "environment-trials")["environment"].nunique() == 24


def test_the_state_of_code_is_shown(render):
    items = table(render([RECORD | {"git": {"commit": "f" * 40, "dirty": True}}])).data.set_index("item")["A"]
    assert items["commit"] == f"{'f' * 40} with uncommitted changes"
    assert items["harness"] == RECORD["harness"]


def test_the_customary_tests_are_a_file_by_which_the_page_claims_nothing(render):
    section = render([RECORD])
    (file,) = (file for file in section.files if file.path == "tables/customary.csv")
    assert file.about.startswith("The tests that reviewers ask for; the page claims nothing by them. Friedman's test")
    assert {"mean_rank", "p_holm", "better", "alike", "worse"} <= set(file.content)
    assert not any("Friedman" in text for text in section.text)
    assert section.lists_files
