"""Sentences that cite works, written plain, for pandoc and for LaTeX."""

from hypothesis import example, given
from hypothesis import strategies as st

from bench.bibtex import parse
from bench.report.prose import LATEX, MARKDOWN, TEXT, cited_keys, paragraphs, templates


def filled(template, **values):
    return paragraphs(templates().from_string(template).render(values))


def test_three_ways():
    works = {work.key: work for work in parse("@misc{a, author={A}, year=1} @misc{b, author={B}, year=2}")}
    (prose,) = filled(
        "Of {{ x }} we say\n[@a; @b].\n{% if x %}\nSo p [@{{ key }}], q and r.\n{% endif %}", x="x_1", key="a"
    )
    assert cited_keys([prose]) == ["a", "b"]
    assert TEXT.write(prose, works) == "Of x_1 we say (A, 1; B, 2). So p (A, 1), q and r."
    assert MARKDOWN.write(prose, works) == r"Of x\_1 we say [@a; @b]. So p [@a], q and r."
    assert LATEX.write(prose, works) == r"Of x\_1 we say~\cite{a,b}. So p~\cite{a}, q and r."


def test_blank_lines_separate_paragraphs_and_none_is_empty():
    assert filled("a\nb\n\n{% if no %}\nc\n{% endif %}\n\n{{ x }} d", no=0, x="x\n\ny") == ["a b", "x y d"]


@given(st.text())
@example(" [@a] {{ y }}")
@example("[[ [@a]")
def test_data_is_never_read_as_a_template(label):
    (prose,) = filled("a {{ x }}.", x=label)
    assert cited_keys([prose]) == []
    assert TEXT.write(prose, {}) == " ".join(f"a {label}.".split())
