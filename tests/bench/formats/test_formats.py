"""The list of formats, which commands, help and reference have."""

from pathlib import Path

import pytest

from bench.formats import EXPORTABLE, FORMATS, IMPORTABLE, described
from bench.formats.runs import FormatReader
from bench.formats.trials import FormatWriter

REFERENCE = Path(__file__).parents[3] / "docs" / "reference" / "formats.md"


@pytest.mark.parametrize("kind", IMPORTABLE)
def test_a_format_that_is_imported_has_a_reader(kind):
    assert isinstance(FORMATS[kind].reader, FormatReader)


@pytest.mark.parametrize("kind", EXPORTABLE)
def test_a_format_that_is_exported_has_a_writer(kind):
    assert isinstance(FORMATS[kind].writer, FormatWriter)


@pytest.mark.parametrize("kind", FORMATS)
def test_the_reference_names_every_format(kind):
    assert f"`{kind}`" in REFERENCE.read_text(encoding="utf-8")


def test_the_words_on_formats_have_each_by_its_name():
    assert described(["coco", "csv"]) == "coco: logs of COCO, for cocopp; csv: plain tables"
