"""The JavaScript of Vega, Vega-Lite and Vega-Embed, from the optional package vl-convert-python."""

from __future__ import annotations

import os
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from platformdirs import user_cache_dir

from bench.errors import BenchError
from bench.helpers.atomic import replacing

PACKAGE = "vl-convert-python"


def available() -> bool:
    """Return whether the optional package is installed."""
    return _version() != ""


@cache
def library() -> str:
    """Return the libraries as one script that defines ``vegaEmbed``; the same for each version of the package.

    Bundling takes some two seconds of processor time, so that the script is kept in the user's cache, as
    ``vega-VERSION.js``.
    """
    path = Path(os.environ.get("BENCH_CACHE") or user_cache_dir("backlash-bench")) / f"vega-{_version()}.js"
    with suppress(OSError, UnicodeDecodeError):
        kept = path.read_text(encoding="utf-8")
        if kept.endswith(_END):
            return kept
    made = _bundled()
    with suppress(OSError, BenchError):  # a read-only cache is not an error
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as temporary:
            temporary.write_text(made, encoding="utf-8", newline="\n")
    return made


_END = "\n/* end of Vega */"


def _bundled() -> str:
    import vl_convert

    bundle: str = vl_convert.javascript_bundle("window.vegaEmbed = vegaEmbed;")
    licence = (
        f"/* Vega {vl_convert.get_vega_version()}, Vega-Lite and Vega-Embed: copyright University of Washington "
        "Interactive Data Lab and contributors, BSD 3-Clause licence, github.com/vega */"
    )
    return f'{licence}\n(() => {{ "use strict";\n{bundle}\n}})();{_END}'


@cache
def _version() -> str:
    try:
        return version(PACKAGE)
    except PackageNotFoundError:
        return ""
