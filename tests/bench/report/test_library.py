"""What is inside the page besides its own words: Vega's scripts as npm has them, and data that end no element."""

import hashlib
import json
from pathlib import Path

from bench.report import library


def test_json_cannot_end_its_element_and_reads_back():
    text = "</script><!--\u2028\u2029&amp; \ud7ff"
    assert json.loads(library.as_json([text])) == [text]
    assert not set("<>&\u2028\u2029") & set(library.as_json([text]))


def test_the_library_is_what_npm_has_with_its_licenses_and_cannot_end_its_element():
    folder = Path(library.__file__).with_name("vega")
    hashes = {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in library.SCRIPTS}
    assert hashes == library.SCRIPTS
    assert {path.name for path in folder.iterdir()} == {"LICENSES", *library.SCRIPTS}
    text = library.library()
    assert text.startswith("/*\nThe three scripts")
    assert text.count("*/", 0, 40_000) == 1  # no license ends the comment
    assert "</script" not in text
    assert "<!--" not in text
