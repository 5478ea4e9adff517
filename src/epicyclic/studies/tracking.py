"""Natural frequencies along a number of the model file, each mode followed; where two cross and where they veer."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..analyses.modes.classification import classify_modes
from ..analyses.modes.eigen import eigen
from ..analyses.modes.tracking import LocusEvent, ModeSet, locus_events, repeated_loci, track_modes
from ..analyses.static.tangent import linearised
from ..assemble import assemble
from ..errors import ModelError
from ..model.written import written
from ..resolve import load
from ..results.dataset import dataset
from ..system.system import System
from ..train.train import Train
from .check import train_provenance
from .parameters import Parameter, parameter_at

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["track"]

Array = NDArray[np.float64]
_WIDE = 10


def track(
    train: Train,
    *,
    over: str,
    start: str | float | None = None,
    stop: str | float | None = None,
    points: int = 41,
    modes: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Follow every mode while one number of the model file goes from one value to another.

    Parameters
    ----------
    over : path of the number, ``PATH[2]`` for one entry of a list.
    start, stop : values as the file says them ("1e8 N/m"), or numbers in the unit written there; half and twice the
        value where None.
    points : values to begin with; more are taken where shapes change quickly, cross or veer.
    modes : how many loci are told, from the lowest at the start; all where None.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : ``frequency`` (mode, parameter), mode_kind (mode) at the start, and events: crossings, of shapes that have
        nothing to do with each other, and veerings, with the coupling of the two shapes.

    Raises
    ------
    ModelError : a path that is not there or no number, an empty range, a value the model cannot have.
    """
    parameter = parameter_at(train, over)
    low, high = _limits(parameter, start, stop)
    if points < 3:
        raise ModelError("too few points to follow a mode", path="points", given=points, allowed="3 or more")
    first = _system(train, parameter, low)
    count = [0]

    @cache
    def system(value: float) -> System:
        count[0] += 1
        if progress is not None:
            progress(min(0.95, count[0] / (4 * points)))
        return _system(train, parameter, value)

    def at(value: float) -> ModeSet:
        here = system(value)
        if here.dofs.names != first.dofs.names:
            raise ModelError("another number of motions at this value", path=over, given=value)
        found = eigen(here)
        return ModeSet(value=value, omega_squared=found.omega_squared, vectors=found.vectors, M=here.M)

    def slope(value: float) -> tuple[Array, Array]:
        step = 1e-4 * (high - low)
        above, below = system(value + step), system(value - step)
        both = above.mean_stiffness - below.mean_stiffness, above.M - below.M
        return both[0] / (2 * step), both[1] / (2 * step)

    path = track_modes(at, _values(low, high, points))
    met = locus_events(path, slope)
    start_modes = at(low)
    kinds = classify_modes(first, start_modes.omega_squared, start_modes.vectors).kind
    return _labelled(train, parameter, path, met, kinds, modes or len(kinds))


def _values(low: float, high: float, points: int) -> list[float]:
    """Values to begin with, over a wide range in equal ratios."""
    wide = low * high > 0 and max(low / high, high / low) > _WIDE
    spaced = np.geomspace(low, high, points) if wide else np.linspace(low, high, points)
    return [low, *spaced[1:-1].tolist(), high]


def _system(train: Train, parameter: Parameter, value: float) -> System:
    return linearised(assemble(load(train.document, overrides=parameter.at(value))))


def _limits(parameter: Parameter, start: str | float | None, stop: str | float | None) -> tuple[float, float]:
    """The range in the unit of the file."""
    if parameter.value == 0 and (start is None or stop is None):
        raise ModelError("the value is 0: say from where to where", path="start, stop", allowed="two values")
    low = parameter.value / 2 if start is None else _read(start, parameter, "start")
    high = parameter.value * 2 if stop is None else _read(stop, parameter, "stop")
    if not np.isfinite(high - low) or high == low:
        raise ModelError(
            "the range is empty", path="start, stop", given=f"{low:g} to {high:g}", allowed="two values that differ"
        )
    return low, high


def _read(text: str | float, parameter: Parameter, option: str) -> float:
    said = written(float(text) if isinstance(text, (int, float)) else text)
    if said is None and isinstance(text, str):
        said = written(_number(text))
    if said is None or said.many or said.unit not in ("", parameter.unit):
        unit = f" in {parameter.unit}, as the file says it" if parameter.unit else " without a unit"
        raise ModelError("not a value of this parameter", path=option, given=text, allowed=f"a number{unit}")
    return said.values[0]


def _number(text: str) -> object:
    try:
        return float(text)
    except ValueError:
        return None


def _labelled(
    train: Train, parameter: Parameter, path: list[ModeSet], met: list[LocusEvent], kinds: tuple[str, ...], modes: int
) -> xr.Dataset:
    hertz = np.sqrt(np.array([state.omega_squared for state in path])).T / (2 * np.pi)
    values = np.array([state.value for state in path])
    met = [event for event in met if min(event.first) < modes and min(event.second) < modes]
    middle = np.array([np.sqrt(event.omega_squared) / (2 * np.pi) for event in met])
    columns: dict[str, tuple[str, Any]] = {
        "event_kind": ("event", np.array([event.kind for event in met], object)),
        "event_value": ("event", np.array([event.value for event in met])),
        "event_frequency": ("event", middle),
        "event_first": ("event", np.array([_named(event.first) for event in met], object)),
        "event_second": ("event", np.array([_named(event.second) for event in met], object)),
        "event_gap": (
            "event",
            np.array([event.gap for event in met]) / (8 * np.pi**2 * np.where(middle > 0, middle, 1)),
        ),
        "coupling_factor": ("event", np.array([abs(e.coupling * e.value) / (2 * e.omega_squared) for e in met])),
        "veering_index": ("event", np.array([event.index for event in met])),
    }
    squared = np.array([state.omega_squared for state in path])
    multiplicity = {i: len(group) for group in repeated_loci(squared) for i in group}
    result = dataset(
        {
            "frequency": (("mode", "parameter"), hertz[:modes]),
            "mode_kind": ("mode", np.array(kinds[:modes], object)),
            "multiplicity": ("mode", np.array([multiplicity[i] for i in range(len(kinds))][:modes])),
            **columns,
        },
        {"mode": np.arange(1, len(kinds) + 1)[:modes], "parameter": values, "event": np.arange(1, len(met) + 1)},
        verb="track",
        options={"over": parameter.path, "value": parameter.value, "unit": parameter.unit},
        provenance=train_provenance(train),
        warnings=train.warnings,
        units={"parameter": parameter.unit or "SI", "event_value": parameter.unit or "SI"},
    )
    return result


def _named(loci: tuple[int, ...]) -> str:
    """Numbers of the modes at the start, ``4, 5``."""
    return ", ".join(str(i + 1) for i in loci)
