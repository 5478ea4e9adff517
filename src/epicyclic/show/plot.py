"""Figures by name: one list for Python, the option ``--figure`` and the ids in a report; and one figure in a file.

The name of a figure is the anchor of its `Drawing` in the view of its kind; its id in a page is ``figure-NAME``.  A
file is SVG, PNG or PDF by kaleido and a Chromium of this machine, or an HTML page of its own.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ModelError
from ..results.files import whole_file
from ..user_input import checked

if TYPE_CHECKING:
    import plotly.graph_objects as go
    import xarray as xr

    from .elements import Company, Part


def _kinds() -> dict[str, Mapping[str, tuple[str, ...]]]:
    """Room whose module `views` shows them -> kind of result -> names of its figures; any other kind is a study."""
    questions = import_module("..questions", __package__).ROOMS
    rooms = {room: import_module(f"..{room}", __package__) for room in ("audits", "statics", *questions)}
    shown = {name: getattr(room, "FIGURES", {}) for name, room in rooms.items()}
    return {**shown, "": {"study": ("study",)}}


KINDS = _kinds()
FIGURES = {kind: names for kinds in KINDS.values() for kind, names in kinds.items()}
_COMPANIONS = {
    ("check", "stiffness"): ("stiffness",),
    ("modes", "shapes"): ("check",),
    ("modes", "campbell"): ("campbell",),
}


@checked
def figure_names(kind: str | None = None) -> tuple[str, ...]:
    """Names of the figures of a kind of result, as `plot` takes them; without a kind of all kinds, each once.

    A figure is there where its variables are: `waterfall` not in a sweep without orders, say.
    """
    if kind is None:
        return tuple(dict.fromkeys(name for names in FIGURES.values() for name in names))
    return FIGURES.get(kind, FIGURES["study"])


def companions(kind: str, name: str) -> tuple[str, ...]:
    """Kinds of the further results that a figure of a kind needs."""
    return _COMPANIONS.get((kind, name), ())


@checked
def plot(name: str, *datasets: xr.Dataset) -> go.Figure:
    """Draw one figure of the report by its name.

    Parameters
    ----------
    name : of `epicyclic.figure_names`.
    datasets : results.  The first kind that has such a figure is drawn, the others stand behind it where the report
        shows them so: modes behind a sweep, the train behind its mode shapes.

    Raises
    ------
    ModelError : no such figure of these results, or several results of one kind have it.
    """
    from .views import kind_of

    kinds = [kind_of(one) for one in datasets]
    known = tuple(dict.fromkeys(each for kind in kinds for each in figure_names(kind)))
    if name not in known:
        allowed = ", ".join(known) or "results of a verb that has figures"
        raise ModelError("no such figure of these results", path="name", given=name, allowed=allowed)
    owners = list(dict.fromkeys(kind for kind in kinds if name in figure_names(kind)))
    if max(map(kinds.count, owners)) > 1:
        raise ModelError("several results have this figure", path="name", given=name, allowed="one result of a kind")
    company: dict[str, Any] = dict(zip(kinds, datasets, strict=True))
    for kind in owners:
        for drawing in _drawings(kind, company):
            if drawing.anchor == name:
                return drawing.figure
    wanting = [one for one in companions(owners[0], name) if one not in kinds]
    if wanting:
        words = " and ".join(wanting)
        raise ModelError(f"needs the result of {words} too", path="name", given=name, allowed="plot(NAME, result, ...)")
    there = dict.fromkeys(drawing.anchor for kind in owners for drawing in _drawings(kind, company))
    allowed = ", ".join(there) or "none of this result"
    raise ModelError("this result has nothing to draw there", path="name", given=name, allowed=allowed)


def _drawings(kind: str, company: Company) -> Iterator[Any]:
    """Drawings of the sections of one result, those in folded parts too."""
    from .views import view_of

    view = view_of(kind)
    for section in view.sections(company[kind], company):
        yield from _within(section.parts)
    yield from _within(view.front(company[kind], company))


def _within(parts: Iterable[Part]) -> Iterator[Any]:
    from .elements import Details, Drawing

    for part in parts:
        if isinstance(part, Drawing):
            yield part
        elif isinstance(part, Details):
            yield from _within(part.parts)


FIGURE_FILES = (".svg", ".png", ".pdf", ".html")
# Points of a page: the width of the text of an A4 page, 6.3 inch, takes 900 of them with letters of 8 pt; height in
# the ratio of its long side to its short one where the figure has none of its own.
_WIDTH, _HEIGHT = 900, 560
# dots per point: 300 dpi at the width of the text of an A4 page
_SCALE = 2.0
# seconds that one figure may take: the largest take two, and a loaded machine is ten times slower
_TIMEOUT = 60.0
_CURE = "pip install 'epicyclic[figures]' and a Chromium or Chrome on this machine, or FILE.html"


def require_figures(path: Path) -> None:
    """Make sure, before the work, that a figure of this kind can be drawn here; nothing is downloaded.

    Raises
    ------
    ModelError : another suffix; the extra ``figures`` is not installed, or there is no Chromium.
    """
    kind = path.suffix.lower()
    if kind not in FIGURE_FILES:
        allowed = " or ".join(FIGURE_FILES)
        raise ModelError("no such kind of figure file", path="--output", given=str(path), allowed=allowed)
    if kind == ".html":
        return
    try:
        import kaleido  # noqa: F401
        from choreographer.browsers.chromium import Chromium
    except ImportError as error:
        problem = f"needs the package kaleido, which is not installed ({error.name or error})"
        raise ModelError(problem, path="--output", given=str(path), allowed=_CURE) from None
    browser = os.environ.get("BROWSER_PATH")  # else on PATH, or one that kaleido has got before
    if not (Path(browser).is_file() if browser else Chromium.find_browser(skip_local=False)):
        raise ModelError("needs a Chromium or Chrome, and none is found", path="--output", given=path, allowed=_CURE)


def write_figure(figure: go.Figure, path: str | Path) -> Path:
    """Write a figure by the suffix of the file, ``.svg``, ``.png``, ``.pdf`` or ``.html``; whole or not at all.

    The first three are drawn 900 points wide on white, as high as the figure's layout says, letters of an SVG or PDF as
    text; raster with two dots a point.  An HTML page holds plotly and needs nothing from outside.

    Raises
    ------
    ModelError : as of `require_figures`; the browser does not start; the file cannot be written.
    """
    target = Path(path)
    require_figures(target)
    kind = target.suffix.lower().removeprefix(".")
    if kind == "html":
        config = {"responsive": True, "displaylogo": False}
        content = figure.to_html(include_plotlyjs=True, config=config, div_id="figure").encode()
    else:
        content = _drawn(figure, kind, str(path))
    with whole_file(target) as file:
        file.write(content)
    return target


def _drawn(figure: go.Figure, kind: str, path: str) -> bytes:
    """Bytes of a figure as kaleido draws it, with plotly's own script and nothing from a network.

    A second browser is tried where the first one fails: on a busy machine its answers come in pieces, which are lost.
    """
    import asyncio

    options = {
        "format": kind,
        "width": _WIDTH,
        "height": int(figure.layout.height or _HEIGHT),
        "scale": _SCALE if kind == "png" else 1,
    }
    spec = _still(figure)
    with suppress(Exception, asyncio.CancelledError):
        return _by_kaleido(spec, options)
    try:
        return _by_kaleido(spec, options)
    except (Exception, asyncio.CancelledError) as error:
        words = f"{type(error).__name__}: {error}".splitlines()[0]
        raise ModelError(f"cannot be drawn by the browser: {words}", path=path, allowed=_CURE) from error


def _by_kaleido(spec: Any, options: dict[str, Any]) -> bytes:
    """Bytes of a figure; what kaleido logs about its browser goes nowhere."""
    import kaleido

    loggers = [logging.getLogger(name) for name in ("kaleido", "choreographer")]
    levels = [one.level for one in loggers]
    for one in loggers:
        one.setLevel(logging.CRITICAL)
    try:
        # without mathjax=False its script is fetched from a network
        found: bytes = kaleido.calc_fig_sync(spec, opts=options, kopts={"mathjax": False, "timeout": _TIMEOUT})
        return found
    finally:
        for one, level in zip(loggers, levels, strict=True):
            one.setLevel(level)


def _still(figure: go.Figure) -> Any:
    """A figure on white without what can be clicked on; parts in order: the same picture for the same figure.

    What a slider stands at is said in the title.
    """
    spec = figure.to_dict()
    layout = {**spec.get("layout", {}), "paper_bgcolor": "white"}
    layout.pop("updatemenus", None)
    for slider in layout.pop("sliders", ()):
        step = slider["steps"][slider.get("active", 0)]
        prefix = slider.get("currentvalue", {}).get("prefix", "")
        title = layout.get("title") or {}
        layout["title"] = {**title, "text": f"{title.get('text', '')}: {prefix}{step.get('label', '')}"}
    for place, trace in enumerate(spec.get("data", ())):
        trace["uid"] = f"-{place}"
    return {"data": spec.get("data", []), "layout": layout}
