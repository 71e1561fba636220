"""The formats csv and parquet, read back with pandas and pyarrow."""

import math
import re
import sys

import numpy as np
import pandas as pd
import pytest

from bench import BenchError
from bench.formats.exporting import export
from bench.formats.tables import writer as tabular
from tests.bench.formats.made import FAILED, exported, make, needs, some_fail


class TestTables:
    @pytest.mark.parametrize("kind", ["csv", "parquet"])
    def test_everything_comes_back(self, kind, tmp_path):
        needs(kind)
        results = make(tmp_path / "s", {"sphere-2": 2, "never": 2}, ("NA", "a"), row=some_fail)
        folder = exported(results, kind, tmp_path / "out")
        if kind == "csv":  # every float by Python's own reader, which rounds correctly in every version
            trials, improvements = (
                pd.read_csv(folder / f"{name}.csv", dtype=str, keep_default_na=False).replace({"": None})
                for name in ("trials", "improvements")
            )
            improvements = improvements.astype({"trial": int, "evaluations": int, "value": object})
            improvements["value"] = [float(text) for text in improvements["value"]]
        else:
            trials, improvements = (pd.read_parquet(folder / f"{name}.parquet") for name in ("trials", "improvements"))
        frame = results.frame
        assert list(trials) == list(frame)
        assert np.isinf(frame["fun"]).sum() == 6  # of 'never', two of whose eight trials failed
        for name in frame:
            if name == "error":
                ends = frame[name].str.replace("\r\n", "\n").str.replace("\r", "\n")
                assert trials[name].fillna("").tolist() == ends.fillna("").tolist()
            elif name in tabular.TEXTS:
                assert trials[name].fillna("").tolist() == frame[name].fillna("").tolist()
            else:
                values = [math.nan if pd.isna(value) else float(value) for value in trials[name]]
                np.testing.assert_array_equal(values, frame[name].to_numpy(float))
        assert [int(seed) for seed in trials["seed"]] == frame["seed"].tolist()  # more digits than a float holds
        assert list(improvements) == ["problem", "optimizer", "trial", "evaluations", "value"]
        kept = {key: trace for key, trace in results.traces.items() if len(trace.values)}
        groups = dict(list(improvements.groupby(["problem", "optimizer", "trial"])))
        assert groups.keys() == kept.keys()
        for key, trace in kept.items():
            assert groups[key]["evaluations"].tolist() == trace.evaluations.tolist()
            assert groups[key]["value"].tolist() == trace.values.tolist()

    def test_counts_are_whole_numbers_beside_failures(self, tmp_path):
        folder = exported(make(tmp_path / "s", row=some_fail), "csv", tmp_path / "out")
        text = pd.read_csv(folder / "trials.csv", dtype=str)
        assert text["nfev"].dropna().str.fullmatch(r"\d+").all()
        assert text["nfev"].isna().sum() == 4

    def test_parquet_keeps_types_even_of_columns_without_values(self, tmp_path):
        needs("parquet")
        import pyarrow.parquet as pq

        folder = exported(make(tmp_path / "s", row=lambda *_: FAILED), "parquet", tmp_path / "out")
        types = {field.name: str(field.type) for field in pq.read_schema(folder / "trials.parquet")}
        assert types["stop"].removeprefix("large_") == "string"
        assert types["nfev"] == types["seed"] == "int64"
        improvements = pq.read_table(folder / "improvements.parquet")
        assert improvements.num_rows == 0
        assert [str(field.type).removeprefix("large_") for field in improvements.schema] == [
            "string", "string", "int64", "int64", "double",
        ]  # fmt: skip


def test_parquet_without_pyarrow_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(BenchError, match=re.escape("pip install 'backlash-bench[parquet]'")):
        export(make(tmp_path / "s", trials=1), "parquet", tmp_path / "out")
    assert not (tmp_path / "out").exists()
