import sys

import pytest

from bench.errors import BenchError
from problems.backlash.joint import writing


def test_parquet_without_pyarrow_is_reported_before_any_work(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(BenchError, match=r"needs pyarrow; install it with: pip install 'backlash-bench\[parquet\]'"):
        writing.check_output(tmp_path / "a.parquet", writing.KINDS, force=False)
