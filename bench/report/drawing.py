"""Draw figures as SVG and PDF, in other processes while this one prepares more; the same bytes wherever it is."""

from __future__ import annotations

import base64
import io
import pickle
import warnings
from collections.abc import Iterable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from types import TracebackType
from typing import Any, NamedTuple

import matplotlib.figure
from fontTools import subset  # that of matplotlib, which needs it
from joblib import cpu_count
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG

from bench.plots import style
from bench.sandbox.pool import Pool

MOST = 3  # processes beside this one, which takes about as long to prepare figures as one of them to draw them


SHAPING = ("GSUB", "GPOS", "GDEF", "kern")  # tables of a font for ligatures and kerning


class Drawing(NamedTuple):
    """A figure as SVG and as PDF."""

    svg: bytes
    pdf: bytes


def draw(figure: matplotlib.figure.Figure) -> Drawing:
    """Draw a figure in the style of reports; raises what matplotlib raises."""
    svg, pdf = io.BytesIO(), io.BytesIO()
    with style.context(), _glyphs_alone(), warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the font may lack letters of a label
        canvas = FigureCanvasSVG(figure)
        if (engine := figure.get_layout_engine()) is not None:  # compute the layout once for both formats
            engine.execute(figure)
            figure.set_layout_engine("none")
        canvas.print_svg(svg, metadata={"Date": None})  # type: ignore[no-untyped-call]
        FigureCanvasPdf(figure).print_pdf(pdf, metadata={"CreationDate": None})  # type: ignore[no-untyped-call]
    return Drawing(svg.getvalue(), pdf.getvalue())


@contextmanager
def _glyphs_alone() -> Iterator[None]:
    """Embed fonts in PDFs without the tables that shape a line of text, which no reader of a PDF looks at.

    To cut these down to the glyphs in use takes half of the time of a small figure's PDF, and matplotlib has no option
    to leave them out.
    """
    usual = getattr(subset.Options, "_drop_tables_default", [])  # another name would cost time alone
    subset.Options._drop_tables_default = [*usual, *SHAPING]
    try:
        yield
    finally:
        subset.Options._drop_tables_default = usual


class Drawer:
    """Draws figures one by one, in this process or in others.

    Args:
        jobs: the processes to use, this one included; -1 for one a core.
    """

    def __init__(self, jobs: int) -> None:
        processes = min(MOST, (cpu_count() if jobs == -1 else jobs) - 1)
        self._pool = Pool(processes, ready) if processes else None
        self._begun: dict[int, tuple[matplotlib.figure.Figure, Future[Any]]] = {}  # by identity: figures have no hash
        self._drawn: dict[int, Drawing] = {}  # of figures begun
        if self._pool is not None:
            for _ in range(processes):  # start now, while the first figures are prepared
                self._pool.submit(0, ready)

    def __enter__(self) -> Drawer:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._pool is not None:
            self._pool.close()

    def begin(self, figures: Iterable[matplotlib.figure.Figure]) -> None:
        """Have figures drawn by other processes, as far as they can be sent there; their drawing may not change."""
        if self._pool is None:
            return
        for figure in figures:
            with suppress(Exception):  # it may hold anything
                if figure.canvas.manager is None:  # a copy of pyplot's own would open a window
                    future = self._pool.submit(0, draw_copy, pickle.dumps(figure))
                    self._begun[id(figure)] = figure, future

    def help(self) -> None:
        """Draw here what no other process has begun to draw, the last one first."""
        for figure, future in reversed(self._begun.values()):
            if future.cancel():
                with suppress(Exception):  # raised again where the drawing is asked for
                    self._drawn[id(figure)] = draw(figure)

    def finish(self, figure: matplotlib.figure.Figure) -> Drawing:
        """Return the drawing of a figure; raises what matplotlib raises."""
        if id(figure) in self._drawn:
            return self._drawn[id(figure)]
        if id(figure) in self._begun:
            with suppress(Exception):  # it is drawn here instead
                answer = self._begun[id(figure)][1].result()
                return Drawing(answer["svg"].encode(), base64.b64decode(answer["pdf"]))
        return draw(figure)


def ready() -> None:
    """Load this module."""


def draw_copy(pickled: bytes) -> dict[str, str]:
    """Draw a pickled figure; return its drawing as JSON values."""
    svg, pdf = draw(pickle.loads(pickled))
    return {"svg": svg.decode(), "pdf": base64.b64encode(pdf).decode()}
