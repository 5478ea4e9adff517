"""Figures by name: one list for Python, the option ``--figure`` and the ids in a report.

The name of a figure is the anchor of its `Drawing` in the view of its kind; its id in a page is ``figure-NAME``.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from ..errors import ModelError
from ..user_input import checked

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    import plotly.graph_objects as go
    import xarray as xr

    from .elements import Company, Part

_ALONE: tuple[str, ...] = ()
FIGURES: Mapping[str, Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "allocate": {"grade-prices": _ALONE},
        "campbell": {"campbell": _ALONE},
        "check": {
            "front": _ALONE,
            "section": _ALONE,
            "members": _ALONE,
            "orders": _ALONE,
            "phases": _ALONE,
            "stiffness": ("stiffness",),
        },
        "compare": {"compared": _ALONE},
        "contact": {"flanks": _ALONE, "contact": _ALONE, "roots": _ALONE},
        "contact_sweep": {"contact-sweep": _ALONE},
        "efficiency": {"losses": _ALONE, "sliding": _ALONE},
        "modes": {
            "frequencies": _ALONE,
            "shapes": ("check",),
            "energy": _ALONE,
            "campbell": ("campbell",),
            "operating-range": _ALONE,
        },
        "modulation": {"modulation": _ALONE},
        "relief": {"relief": _ALONE, "relief-effect": _ALONE},
        "sensitivity": {"sensitivity": _ALONE},
        "sharing": {"sharing": _ALONE, "history": _ALONE, "forces": _ALONE},
        "stability": {"stability": _ALONE},
        "static": {"static-forces": _ALONE},
        "steady": {"steady-forces": _ALONE, "steady-range": _ALONE},
        "stiffness": {"stiffness": _ALONE},
        "sweep": {"sweep": _ALONE, "waterfall": _ALONE, "bearings": _ALONE},
        "tolerance": {
            "k-gamma": _ALONE,
            "tolerance-shares": _ALONE,
            "k-gamma-by-tolerance": _ALONE,
            "k-gamma-by-design": _ALONE,
            "worst-branches": _ALONE,
        },
        "track": {"track": _ALONE},
        "train_contact": {"faces": _ALONE, "factors": _ALONE},
        "transient": {"transient": _ALONE, "spectrogram": _ALONE},
        "audit": {},
        "matrices": {},
        "study": {"study": _ALONE},
    }
)
"""Kind of result -> name of each figure -> kinds of the further results that it needs."""


@checked
def figure_names(kind: str | None = None) -> tuple[str, ...]:
    """Names of the figures of a kind of result, as `plot` takes them; without a kind of all kinds, each once.

    A figure is there where its variables are: `waterfall` not in a sweep without orders, say.
    """
    if kind is None:
        return tuple(dict.fromkeys(name for names in FIGURES.values() for name in names))
    return tuple(FIGURES.get(kind, FIGURES["study"]))


def companions(kind: str, name: str) -> tuple[str, ...]:
    """Kinds of the further results that a figure of a kind needs."""
    return FIGURES.get(kind, FIGURES["study"]).get(name, _ALONE)


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
