"""The page on many recordings."""

import re
from pathlib import Path

from problems.backlash.sensor import page
from problems.backlash.sensor.batch import Estimated, Failed
from problems.backlash.sensor.estimate import Settings
from problems.backlash.sensor.trend import joints_of
from tests.bench.reports import Document


def test_it_has_verdicts_trends_and_fits_in_one_file(make_estimate, tmp_path):
    names = [f"2024-0{month}.csv" for month in range(1, 5)]
    good = [Estimated(Path(name), make_estimate(0.001 + 0.0002 * i)) for i, name in enumerate(names)]
    outcomes = [*good, Failed(Path("bad.csv"), "bad.csv has 0 samples")]
    settings = Settings()
    path = page.write(tmp_path / "page.html", outcomes, [*names, "bad.csv"], joints_of(good, settings), settings)
    read = Document(path.read_text(encoding="utf-8"))
    text = read.text
    assert "1 joint, 0 with progressed backlash at last; 5 recordings, 1 not estimated." in text
    (row,) = re.findall(r"<tr>.*?</tr>", path.read_text().partition("<tbody>")[2].partition("</tbody>")[0], re.DOTALL)
    assert '<td data-title="latest verdict" class="warn">early</td>' in row
    assert re.sub("<.*?>", "|", row.replace("\n", "")).split("|")[2:-1:2] == [
        "joint", "early", "1.60 (1.50 to 1.70)", "no trend: +0.200 a month (+0.200 to +0.200)",
        "unknown: no growth in the latest 4 recordings", "2024-04",
    ]  # fmt: skip
    assert "bad.csv has 0 samples" in text
    assert "half-gap 1.000 mrad in 2024-01, 1.600 in 2024-04" in text
    assert "; the limit of 2.1 mrad is not predicted to be reached" in text
    assert text.count("Recording, fit and residual of") >= 4
    assert "Download" not in text
    assert all(link.startswith("#") for link in read.values("href") + read.values("src"))
