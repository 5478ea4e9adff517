"""Mode tracking: loci of the natural frequencies along a parameter of the model file, crossings and veerings.

Where two loci approach, a crossing and a veering differ in the coupling of the two modes [perkins1986, lin2001,
dubois2011]; `questions.modes` follows the modes and finds these events.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...document.written_numbers import written
from ...errors import ModelError
from ...results.dataset import dataset
from ...statics.tangent import flank_warnings, linear
from ...system.assembly import assemble, train_provenance
from ...system.system import System
from ...train.resolution import load
from ...train.train import Train
from ..modes.campbell import LocusEvent, ModeSet, locus_events, repeated_loci, track_modes
from ..modes.eigen import classify_modes, eigen
from ..sensitivity.derivatives import Parameter, parameter_at

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
# Ratio of the limits above which the first values lie in equal ratios.
_WIDE_RANGE = 10


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
    """Loci of the natural frequencies along one number of the model file, with their crossings and veerings.

    Parameters
    ----------
    over : path of the number, ``PATH[2]`` for one entry of a list.
    start, stop : values as the file writes them ("1e8 N/m"), or numbers in the unit written there; None: half and
        twice the value.
    points : initial values; more are inserted where shapes change quickly, cross or veer.
    modes : number of loci in the result, from the lowest at the start; None: all.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : frequency [Hz] (mode, parameter), mode_kind and multiplicity (mode) at the start, and event_kind,
        event_value, event_frequency [Hz], event_gap [Hz], coupling_factor, veering_index [1] (event): crossings of
        uncoupled shapes, and veerings [dubois2011].

    Raises
    ------
    ModelError : a path that is not there or no number, an empty range, a value the model cannot have.
    """
    parameter = parameter_at(train, over)
    low, high = _limits(parameter, start, stop)
    first = _system(train, parameter, low)
    assembled = [0]

    @cache
    def system(value: float) -> System:
        assembled[0] += 1
        if progress is not None:
            progress(min(0.95, assembled[0] / (4 * points)))
        return _system(train, parameter, value)

    def modes_at(value: float) -> ModeSet:
        here = system(value)
        if here.dofs.names != first.dofs.names:
            raise ModelError("another number of motions at this value", path=over, given=value)
        solved = eigen(here)
        return ModeSet(value=value, omega_squared=solved.omega_squared, vectors=solved.vectors, M=here.M)

    def matrix_derivatives(value: float) -> tuple[Array, Array]:
        """Derivatives (n, n) of mean stiffness and mass along the parameter, by central differences."""
        step = 1e-4 * (high - low)
        above, below = system(value + step), system(value - step)
        stiffness, mass = above.mean_stiffness - below.mean_stiffness, above.M - below.M
        return stiffness / (2 * step), mass / (2 * step)

    loci = track_modes(modes_at, _initial_values(low, high, points))
    crossings_and_veerings = locus_events(loci, matrix_derivatives)
    start_modes = modes_at(low)
    kinds = classify_modes(first, start_modes.omega_squared, start_modes.vectors).kind
    return _labelled(train, parameter, loci, crossings_and_veerings, kinds, modes or len(kinds))


def _initial_values(low: float, high: float, points: int) -> list[float]:
    """Values from `low` to `high`, evenly spaced, over a wide range in equal ratios."""
    wide = low * high > 0 and max(low / high, high / low) > _WIDE_RANGE
    spaced = np.geomspace(low, high, points) if wide else np.linspace(low, high, points)
    return [low, *spaced[1:-1].tolist(), high]


def _system(train: Train, parameter: Parameter, value: float) -> System:
    """Linearised System with the parameter at a value."""
    return linear(assemble(load(train.document, overrides=parameter.at(value))), asks_laws=True)


def _limits(parameter: Parameter, start: str | float | None, stop: str | float | None) -> tuple[float, float]:
    """Limits of the range, in the unit of the file; half and twice the value where not given."""
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
    """Limit in the unit of the parameter, from a number or a text in that unit.

    Raises
    ------
    ModelError : no single number, or another unit.
    """
    number = written(float(text) if isinstance(text, (int, float)) else text)
    if number is None and isinstance(text, str):
        with suppress(ValueError):
            number = written(float(text))
    if isinstance(text, str) and number is not None and not number.unit and parameter.unit and number.values != (0.0,):
        raise ModelError(f'a number without a unit: "{text} {parameter.unit}"?', path=option, given=text)
    if number is None or number.many or number.unit not in ("", parameter.unit):
        unit = f" in {parameter.unit}, as the file says it" if parameter.unit else " without a unit"
        raise ModelError("not a value of this parameter", path=option, given=text, allowed=f"a number{unit}")
    return number.values[0]


def _labelled(
    train: Train,
    parameter: Parameter,
    loci: list[ModeSet],
    events: list[LocusEvent],
    kinds: tuple[str, ...],
    modes: int,
) -> xr.Dataset:
    """Dataset of the lowest loci and of the events among them; kinds : (n,) of the modes at the start."""
    squared = np.array([state.omega_squared for state in loci])
    hertz = np.sqrt(squared).T / (2 * np.pi)
    multiplicity = {i: len(group) for group in repeated_loci(squared) for i in group}
    values = np.array([state.value for state in loci])
    events = [event for event in events if min(event.first) < modes and min(event.second) < modes]
    event_hertz = np.array([np.sqrt(event.omega_squared) / (2 * np.pi) for event in events])
    # hertz from a difference of omega^2: it is 8 pi^2 f times that of f
    event_gap = np.array([event.gap for event in events]) / (8 * np.pi**2 * np.where(event_hertz > 0, event_hertz, 1))
    columns: dict[str, tuple[str, Any]] = {
        "event_kind": ("event", np.array([event.kind for event in events], object)),
        "event_value": ("event", np.array([event.value for event in events])),
        "event_frequency": ("event", event_hertz),
        "event_first": ("event", np.array([_mode_numbers(event.first) for event in events], object)),
        "event_second": ("event", np.array([_mode_numbers(event.second) for event in events], object)),
        "event_gap": ("event", event_gap),
        "coupling_factor": ("event", np.array([abs(e.coupling * e.value) / (2 * e.omega_squared) for e in events])),
        "veering_index": ("event", np.array([event.index for event in events])),
    }
    return dataset(
        {
            "frequency": (("mode", "parameter"), hertz[:modes]),
            "mode_kind": ("mode", np.array(kinds[:modes], object)),
            "multiplicity": ("mode", np.array([multiplicity[i] for i in range(len(kinds))][:modes])),
            **columns,
        },
        {"mode": np.arange(1, len(kinds) + 1)[:modes], "parameter": values, "event": np.arange(1, len(events) + 1)},
        verb="track",
        options={"over": parameter.path, "value": parameter.value, "unit": parameter.unit},
        provenance=train_provenance(train),
        # of the tangents at the value of the file; along the parameter they are taken anew
        warnings=[*train.warnings, *flank_warnings(assemble(train))],
        units={"parameter": parameter.unit or "SI", "event_value": parameter.unit or "SI"},
    )


def _mode_numbers(loci: tuple[int, ...]) -> str:
    """Numbers of the modes at the start, from 1: ``4, 5``."""
    return ", ".join(str(i + 1) for i in loci)
