"""The page on many recordings."""

import math
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from bench import BenchError
from problems.backlash.sensor import page
from problems.backlash.sensor.batch import Estimated, Failed
from problems.backlash.sensor.estimate import Settings
from problems.backlash.sensor.trend import trends


class Words(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.words, self.links = [], []
        self.feed(text)

    def handle_data(self, data):
        self.words.append(data)

    def handle_starttag(self, tag, attrs):
        self.links += [value for name, value in attrs if name in ("href", "src") and not value.startswith("#")]


def test_it_has_verdicts_trends_and_fits_in_one_file(make_estimate, tmp_path):
    names = [f"2024-0{month}.csv" for month in range(1, 5)]
    good = [Estimated(Path(name), make_estimate(0.001 + 0.0002 * i)) for i, name in enumerate(names)]
    outcomes = [*good, Failed(Path("bad.csv"), "bad.csv has 0 samples")]
    settings = Settings()
    path = page.write(tmp_path / "page.html", outcomes, [*names, "bad.csv"], trends(good, settings), settings)
    read = Words(path.read_text(encoding="utf-8"))
    text = " ".join(" ".join(read.words).split())
    assert "5 recordings, 0 with progressed backlash, 1 not estimated." in text
    assert "bad.csv has 0 samples" in text
    assert "half-gap 1.000 mrad in 2024-01, 1.600 in 2024-04" in text
    assert "; the limit of 2.1 mrad is not predicted to be reached" in text
    assert text.count("Recording, fit and residual of") >= 4
    assert "Download" not in text
    assert not read.links


def test_without_an_estimate_or_a_place_it_says_so(make_estimate, tmp_path):
    failed = [Failed(Path("bad.csv"), "no")]
    path = page.write(tmp_path / "page.html", failed, ["bad.csv"], [], Settings())
    assert "1 recording, 0 with progressed backlash, 1 not estimated." in path.read_text(encoding="utf-8")
    hidden = Estimated(Path("a.csv"), make_estimate(math.nan, interval_rad=(np.nan, np.nan)))
    assert page.write(tmp_path / "page.html", [hidden], ["a.csv"], [], Settings()).exists()
    with pytest.raises(BenchError, match="cannot be written"):
        page.write(tmp_path / "no" / "page.html", failed, ["bad.csv"], [], Settings())
