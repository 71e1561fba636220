"""Sentences that cite works, written plain, for pandoc and for LaTeX."""

from hypothesis import given
from hypothesis import strategies as st

from bench.bibtex import parse
from bench.report.prose import LATEX, MARKDOWN, TEXT, Cite, sentence, series


def test_three_ways():
    works = {work.key: work for work in parse("@misc{a, author={A}, year=1} @misc{b, author={B}, year=2}")}
    paragraph = [
        sentence("Of {x} we say [@a; @b].", x="x_1"),
        sentence("So {list}.", list=series([["p", Cite(("a",))], ["q"], ["r"]])),
    ]
    assert TEXT.write(paragraph, works) == "Of x_1 we say (A, 1; B, 2). So p (A, 1), q and r."
    assert MARKDOWN.write(paragraph, works) == r"Of x\_1 we say [@a; @b]. So p [@a], q and r."
    assert LATEX.write(paragraph, works) == r"Of x\_1 we say~\cite{a,b}. So p~\cite{a}, q and r."


@given(st.text())
def test_data_is_never_read_as_a_template(label):
    assert sentence("{x}", x=label) == ["", label, ""]
    assert sentence("{x}", x=" [@a] {y}") == ["", " [@a] {y}", ""]
