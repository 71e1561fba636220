"""Spreadsheets: every cell as openpyxl reads it, and one sentence for a file that is none."""

import datetime
from io import BytesIO
from zipfile import ZipFile

import numpy as np
import openpyxl
import pytest

from bench import BenchError
from problems.backlash.recordings import read
from problems.backlash.recordings.tables import first_sheet


def book(tmp_path, fill):
    """Write a workbook whose first sheet ``fill`` has filled; return its path."""
    made = openpyxl.Workbook()
    fill(made, made.active)
    made.save(tmp_path / "a.xlsx")
    return tmp_path / "a.xlsx"


def cells(content):
    """Return the cells of a workbook's first sheet by rows, None for empty ones."""
    return first_sheet(content).astype(object).replace({np.nan: None}).to_numpy().tolist()


def judge(content):
    sheet = openpyxl.load_workbook(BytesIO(content), data_only=True).worksheets[0]
    return [list(row) for row in sheet.iter_rows(min_row=1, min_col=1, values_only=True)]


def changed(content, change):
    """Return a workbook with the XML of its first sheet changed."""
    made = BytesIO()
    with ZipFile(BytesIO(content)) as old, ZipFile(made, "w") as new:
        for name in old.namelist():
            part = old.read(name)
            new.writestr(name, change(part) if name == "xl/worksheets/sheet1.xml" else part)
    return made.getvalue()


def test_the_published_recordings_are_read_to_the_last_bit(published):
    contents = [path.read_bytes() for path in sorted(published.glob("Speeddata*.xlsx"))]
    for path in published.glob("Data_with_Noise_*.zip"):
        with ZipFile(path) as zipped:
            contents += map(zipped.read, zipped.namelist())
    assert len(contents) >= 5
    for content in contents:
        assert cells(content) == judge(content)


def test_every_kind_of_cell_is_read(tmp_path):
    def fill(made, sheet):
        rows = [
            ["time", None, "1,5", True],
            [0, 1e-300, 100.07, -1.5e300],
            [datetime.datetime(2024, 1, 2, 3, 4, 5), datetime.time(1, 2, 3), datetime.timedelta(hours=30), "#DIV/0!"],
        ]
        for row in rows:
            sheet.append(row)
        made.create_sheet("second").append(["another"])

    assert cells(book(tmp_path, fill).read_bytes()) == [
        ["time", None, "1,5", True],
        [0, 1e-300, 100.07, -1.5e300],
        [datetime.datetime(2024, 1, 2, 3, 4, 5), datetime.time(1, 2, 3), datetime.timedelta(hours=30), None],
    ]


def test_a_sheet_is_read_from_its_first_cell_to_its_last_filled_one(tmp_path):
    def fill(_, sheet):
        sheet["B3"], sheet["C4"] = "time", 1.5
        for empty in ("B9", "F4"):
            sheet[empty].font = openpyxl.styles.Font(bold=True)

    content = book(tmp_path, fill).read_bytes()
    assert b'<dimension ref="B3:F9"' in ZipFile(BytesIO(content)).read("xl/worksheets/sheet1.xml")
    for ref in (b"B3:F9", b"A1"):  # a declared extent may be wrong
        found = cells(changed(content, lambda xml, ref=ref: xml.replace(b'ref="B3:F9"', b'ref="' + ref + b'"')))
        assert found == [
            [None, None, None],
            [None, None, None],
            [None, "time", None],
            [None, None, 1.5],
        ]
    assert cells(book(tmp_path, lambda *_: None).read_bytes()) == []


def sheet(tmp_path):
    time = 0.002 * np.arange(50)

    def fill(_, sheet):
        for row in zip(time.tolist(), (100 + time).tolist(), strict=True):
            sheet.append(row)

    return book(tmp_path, fill).read_bytes()


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        pytest.param(lambda _: b"time,speed\n0,1\n", "it is damaged, or no xlsx workbook (", id="text"),
        pytest.param(lambda _: b"", "it is damaged, or no xlsx workbook (", id="empty"),
        pytest.param(lambda whole: whole[: len(whole) // 2], "it is damaged, or no xlsx workbook (", id="half"),
        pytest.param(lambda whole: whole.replace(b"PK\1\2", b"PK\7\7"), "it is damaged, or no xlsx", id="directory"),
        pytest.param(
            lambda whole: changed(whole, lambda xml: xml).replace(b"<v>100.01</v>", b"<v>900.01</v>"),
            "it is damaged, or no xlsx workbook (I/O error: Invalid checksum)",
            id="digit",
        ),
        pytest.param(lambda whole: changed(whole, lambda xml: xml[:900]), "it is damaged, or no xlsx", id="xml"),
        pytest.param(
            lambda _: bytes.fromhex("d0cf11e0a1b11ae1") + bytes(5000),
            "it is an old workbook (.xls) or has a password; save it as .xlsx without a password",
            id="xls",
        ),
    ],
)
def test_a_file_that_is_no_whole_workbook_is_one_sentence(tmp_path, spoil, said):
    (tmp_path / "b.xlsx").write_bytes(spoil(sheet(tmp_path)))
    with pytest.raises(BenchError) as caught:
        read(tmp_path / "b.xlsx")
    assert str(caught.value).startswith(f"recording {tmp_path / 'b.xlsx'} cannot be read: {said}")
    assert "\n" not in str(caught.value)
