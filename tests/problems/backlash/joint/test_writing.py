import sys

import pytest

from bench.errors import BenchError
from problems.backlash.joint import writing


@pytest.mark.parametrize(("kind", "module"), [("parquet", "pyarrow"), ("xlsx", "openpyxl")])
def test_a_missing_extra_is_reported_before_any_work(tmp_path, monkeypatch, kind, module):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(BenchError, match=rf"needs {module}; install it with: pip install 'backlash-bench\[{kind}\]'"):
        writing.check_output(tmp_path / f"a.{kind}", writing.KINDS, force=False)
