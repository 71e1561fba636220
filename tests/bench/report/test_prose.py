"""Sentences of a template: one line each, with the data of the facts as they are."""

import sys

import pytest
from jinja2 import UndefinedError

from bench.report.prose import speaker

WORDS = """{% macro lead(best) %}
{% if best %}
{{ best }} leads
   {{- " alone" if alone }}.
{% endif %}
{% endmacro %}"""


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Return the name of a package with a template of sentences."""
    (tmp_path / "worded").mkdir()
    (tmp_path / "worded" / "__init__.py").touch()
    (tmp_path / "worded" / "words.j2").write_text(WORDS)
    monkeypatch.syspath_prepend(tmp_path)
    yield "worded"
    sys.modules.pop("worded", None)


def test_a_sentence_is_one_line_and_empty_where_it_does_not_apply(package):
    say = speaker(package, alone=True)
    assert (say("lead", "gwo"), say("lead", "")) == ("gwo leads alone.", "")


def test_a_label_is_never_read_as_a_template(package):
    assert speaker(package, alone=False)("lead", "{{ 7 * 7 }}<b>") == "{{ 7 * 7 }}<b> leads."


def test_a_fact_that_is_missing_is_an_error(package):
    with pytest.raises(UndefinedError):
        speaker(package)("lead", "gwo")
