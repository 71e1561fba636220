"""Draw figures as SVG and PDF, in other processes while this one prepares more; the same bytes wherever it is."""

from __future__ import annotations

import base64
import io
import pickle
import warnings
from collections.abc import Iterable
from concurrent.futures import Future
from contextlib import suppress
from types import TracebackType
from typing import Any, NamedTuple

import matplotlib.figure
from joblib import cpu_count
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG

from bench.plots import style
from bench.sandbox.pool import Pool

MOST = 3  # processes beside this one, which takes about as long to prepare figures as one of them to draw them


class Drawing(NamedTuple):
    """A figure as SVG and, on request, as PDF."""

    svg: bytes
    pdf: bytes | None


def draw(figure: matplotlib.figure.Figure, *, pdf: bool = True) -> Drawing:
    """Draw a figure in the style of reports; raises what matplotlib raises."""
    drawn, printed = io.BytesIO(), io.BytesIO()
    with style.context(), warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the font may lack letters of a label
        canvas = FigureCanvasSVG(figure)
        if (engine := figure.get_layout_engine()) is not None:  # compute the layout once for both formats
            engine.execute(figure)
            figure.set_layout_engine("none")
        canvas.print_svg(drawn, metadata={"Date": None})  # type: ignore[no-untyped-call]
        if pdf:
            FigureCanvasPdf(figure).print_pdf(printed, metadata={"CreationDate": None})  # type: ignore[no-untyped-call]
    return Drawing(drawn.getvalue(), printed.getvalue() if pdf else None)


class Drawer:
    """Draws figures one by one, in this process or in others.

    Args:
        jobs: the processes to use, this one included; -1 for one a core.
    """

    def __init__(self, jobs: int) -> None:
        processes = min(MOST, (cpu_count() if jobs == -1 else jobs) - 1)
        self._pool = Pool(processes, ready) if processes else None
        self._begun: dict[int, tuple[matplotlib.figure.Figure, bool, Future[Any]]] = {}  # by identity: without a hash
        self._drawn: dict[int, Drawing] = {}  # of figures begun
        if self._pool is not None:
            for _ in range(processes):  # start now, while the first figures are prepared
                self._pool.submit(0, ready)

    def __enter__(self) -> Drawer:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._pool is not None:
            self._pool.close()

    def begin(self, figures: Iterable[matplotlib.figure.Figure], *, pdf: bool = True) -> None:
        """Have figures drawn by other processes, as far as they can be sent there; their drawing may not change."""
        if self._pool is None:
            return
        for figure in figures:
            with suppress(Exception):  # it may hold anything
                if figure.canvas.manager is None:  # a copy of pyplot's own would open a window
                    future = self._pool.submit(0, draw_copy, pickle.dumps(figure), pdf)
                    self._begun[id(figure)] = figure, pdf, future

    def help(self) -> None:
        """Draw here what no other process has begun to draw, the last one first."""
        for figure, pdf, future in reversed(self._begun.values()):
            if future.cancel():
                with suppress(Exception):  # raised again where the drawing is asked for
                    self._drawn[id(figure)] = draw(figure, pdf=pdf)

    def finish(self, figure: matplotlib.figure.Figure, *, pdf: bool = True) -> Drawing:
        """Return the drawing of a figure; raises what matplotlib raises."""
        if id(figure) in self._drawn:
            return self._drawn[id(figure)]
        if id(figure) in self._begun:
            with suppress(Exception):  # it is drawn here instead
                answer = self._begun[id(figure)][2].result()
                return Drawing(answer["svg"].encode(), base64.b64decode(answer["pdf"]) if pdf else None)
        return draw(figure, pdf=pdf)


def ready() -> None:
    """Load this module."""


def draw_copy(pickled: bytes, pdf: bool) -> dict[str, str]:
    """Draw a pickled figure; return its drawing as JSON values."""
    drawing = draw(pickle.loads(pickled), pdf=pdf)
    return {"svg": drawing.svg.decode(), "pdf": base64.b64encode(drawing.pdf or b"").decode()}
