"""Works as BibTeX: entries are read as written, and named as a text names them."""

import pytest

from bench import BenchError
from bench.helpers.bibtex import parse

HOSTILE = (
    r"\input{/etc/passwd}", r"\write18{id}", r"\immediate\openout3=a", r"\catcode`\@=11", r"\def\x{}",
    r"\csname input\endcsname", r"\\\input x", "^^5cinput x", r"\loop\iftrue\repeat",
    r"\directlua{os.exit()}", r"\href{run:x}{y}",
)  # fmt: skip
"""TeX that reads, writes or runs a file, or never ends, when a paper that cites the entry is typeset."""


@pytest.mark.parametrize(
    ("bibtex", "name"),
    [
        ("@misc{a, author={Holm, Sture}, year={1979}}", "Holm, 1979"),
        ("@misc{a, author = {Dem{\\v{s}}ar, J. and Mor{\\'e}, J.}, year = 2006}", "Demšar and Moré, 2006"),
        ('@MISC{a, AUTHOR = "Jan van der Berg and B and C", YEAR = "1999"}', "van der Berg et al., 1999"),
        ("@misc{a, author={Harris, C. and others}, year={2020}}", "Harris et al., 2020"),
        ("@misc{a, author={Hodges, Jr., J. L.}, year={1958}}", "Hodges, 1958"),
        ("@misc{a, author={St\\'efan {van der Walt} and {\\O}st, A}, year={1}}", "van der Walt and Øst, 1"),
        ("@misc{a, author={{The A \\& B Team}}, year={1}}", "The A & B Team, 1"),
        ("@misc{a, editor={Öst, A}, year={1}}", "Öst, 1"),
        ("@misc{a, booktitle={year = {5}}}", "a, no year"),
    ],
)
def test_names_and_years(bibtex, name):
    (work,) = parse(bibtex)
    assert work.author_year == name


@pytest.mark.parametrize(
    ("bibtex", "why"),
    [
        ("@misc{a, x={}", "braces"),
        ("@misc{}", "key"),
        ("@misc{日, x=1}", "key"),
        ("@misc{a}", "key"),
        ("b", "no entry"),
        *((f"@misc{{a, note={{{tex}}}}}", "TeX that no reference needs") for tex in HOSTILE),
    ],
)
def test_what_is_no_entry_is_refused(bibtex, why):
    with pytest.raises(BenchError, match=why):
        parse(bibtex)
