"""Draw figures as SVG and PDF, in other processes while this one prepares more; the same bytes wherever it is."""

from __future__ import annotations

import base64
import io
import pickle
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from threading import Event, Lock
from types import TracebackType
from typing import Any, NamedTuple

import matplotlib.figure
from joblib import effective_n_jobs
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG

from bench.helpers.parallel import side_by_side
from bench.plots import style
from bench.sandbox.callers import Call, Callers

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
        n_jobs: the processes to use, this one included; -1 for one a core.
    """

    def __init__(self, n_jobs: int) -> None:
        self._others = min(MOST, effective_n_jobs(n_jobs) - 1)
        self._callers = Callers(self._others, ready) if self._others else None
        self._sent: dict[int, _Sent] = {}  # by the identity of their figures, which have no hash
        self._under_way: list[Generator[object]] = []
        if self._callers is not None:  # start now, while the first figures are prepared
            self._begin(self._callers.answer, [Call(0, ready) for _ in range(self._others)])

    def __enter__(self) -> Drawer:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._callers is not None:
            self._callers.kill()
        for drawings in self._under_way:
            deque(drawings, maxlen=0)  # calls without a process end at once

    def begin(self, figures: Iterable[matplotlib.figure.Figure]) -> None:
        """Have figures drawn by other processes, as far as they can be sent there; their drawing may not change."""
        if self._callers is None:
            return
        sent = []
        for figure in figures:
            with suppress(Exception):  # it may hold anything
                if figure.canvas.manager is None:  # a copy of pyplot's own would open a window
                    sent.append(_Sent(figure, pickle.dumps(figure)))
        self._sent |= {id(each.figure): each for each in sent}
        self._begin(self._draw, sent)

    def help(self) -> None:
        """Draw here what no other process has begun to draw, the last one first."""
        for sent in reversed(self._sent.values()):
            if sent.claimed():
                with suppress(Exception):  # raised again where the drawing is asked for
                    sent.drawing = draw(sent.figure)
                sent.drawn.set()

    def finish(self, figure: matplotlib.figure.Figure) -> Drawing:
        """Return the drawing of a figure; raises what matplotlib raises."""
        if sent := self._sent.get(id(figure)):
            sent.drawn.wait()
            if sent.drawing is not None:
                return sent.drawing
        return draw(figure)

    def _begin(self, function: Callable[[Any], object], items: Sequence[Any]) -> None:
        """Have calls begin, in threads beside this one also where there is but one other process."""
        if items:
            self._under_way.append(side_by_side(function, items, self._others + 1))

    def _draw(self, sent: _Sent) -> None:
        """Have a figure drawn in another process; where that fails, it is drawn here when it is asked for."""
        assert self._callers is not None
        call = Call(0, draw_copy, (sent.pickled,), wanted=sent.claimed)
        answer = self._callers.answer(call)[1]
        if answer is not None:
            with suppress(Exception):  # no drawing
                sent.drawing = Drawing(answer["svg"].encode(), base64.b64decode(answer["pdf"]))
            sent.drawn.set()


@dataclass
class _Sent:
    """A figure that other processes may draw."""

    figure: matplotlib.figure.Figure
    pickled: bytes
    drawing: Drawing | None = None
    drawn: Event = field(default_factory=Event)
    _claim: Lock = field(default_factory=Lock)

    def claimed(self) -> bool:
        """Return whether the caller is the first who asks, and so the one who draws it."""
        return self._claim.acquire(blocking=False)


def ready() -> None:
    """Load this module."""


def draw_copy(pickled: bytes) -> dict[str, str]:
    """Draw a pickled figure; return its drawing as JSON values."""
    drawing = draw(pickle.loads(pickled))
    return {"svg": drawing.svg.decode(), "pdf": base64.b64encode(drawing.pdf or b"").decode()}
