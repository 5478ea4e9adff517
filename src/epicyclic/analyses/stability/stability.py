"""Stability of the motion over speed: Floquet multipliers, growth rates, kinds of instability and their modes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ...errors import ModelError
from ...questions.response.response import FrameSpeed
from ...system.system import Array, System
from ...warning_codes import CodedText, coded
from .combinations import Combination
from .scan import FloquetScan, ParametricSystem, Progress, floquet_scan, parametric_system, predicted_combinations

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.run_folder import RunFolder

__all__ = ["combination_name", "combination_names", "resonance_columns", "scan_warnings", "stability"]

_POINTS = 200


def stability(
    system: System,
    *,
    mesh_frequency: ArrayLike | None = None,
    relative_speed: ArrayLike | None = None,
    frame_speed: FrameSpeed = "kinematic",
    variation: float = 1.0,
    damping: float = 1.0,
    progress: Progress = None,
    kept: RunFolder | None = None,
) -> xr.Dataset:
    """Floquet multipliers of the linear-contact motion over speed, and the boundaries that averaging predicts.

    With several mesh frequencies the period is the common one of all meshes that vary; where that takes more than
    20 000 steps the point holds nan, and only the prediction is left.

    Parameters
    ----------
    mesh_frequency : (P,) of the first mesh [Hz], or relative_speed : (P,) speeds per operating speed; neither: 200
        mesh frequencies from a fifth of the lowest to 1.2 times the highest natural frequency.
    frame_speed : as of `sweep`.  variation, damping : factors of the variation of the meshes and of all damping.
    progress : called with (points done, points).  kept : keeps the points that are done.

    Raises
    ------
    ModelError : no mesh frequency, a mass that is missing, or an option out of range.
    A single speed that fails holds nan, and ``status`` says why.  No damping at all is allowed: the train is then
    stable where nothing grows.
    """
    ready = parametric_system(system, frame_speed=frame_speed, variation=variation, damping=damping)
    frequency = _frequencies(ready, mesh_frequency, relative_speed)
    done = None if kept is None else kept.part("speeds")
    found = floquet_scan(ready, frequency, progress=progress, kept=done)
    options = {"frame_speed": frame_speed, "variation": variation, "damping": damping}
    return _labelled(ready, frequency, found, predicted_combinations(ready, frequency), options)


def _frequencies(ready: ParametricSystem, mesh_frequency: ArrayLike | None, relative_speed: ArrayLike | None) -> Array:
    """Mesh frequencies of the first mesh (P,) [Hz]; 200 over the natural frequencies where no speeds are given.

    Raises
    ------
    ModelError : both kinds of speed are given.
    """
    if mesh_frequency is not None and relative_speed is not None:
        raise ModelError("give mesh_frequency or relative_speed, not both")
    if relative_speed is not None:
        return np.atleast_1d(np.asarray(relative_speed, dtype=float)) * float(ready.tones[0])
    if mesh_frequency is not None:
        return np.atleast_1d(np.asarray(mesh_frequency, dtype=float))
    natural = np.sqrt(ready.modal.squared[~ready.modal.rigid]) / (2 * np.pi)
    if not natural.size:
        return np.array([float(ready.tones[0])])
    return np.linspace(0.2 * natural[0], 1.2 * natural[-1], _POINTS)


def combination_names(
    found: FloquetScan, ranges: Sequence[Combination], mesh_frequency: Array, several: bool
) -> list[str]:
    """At each unstable mesh frequency (P,) [Hz] the combination whose predicted range holds it, the fastest; else "".

    The ends of a range are known to first order: the next range counts up to half its width away.
    """
    return [
        "" if kind in ("", "stable") else _combination_at(ranges, float(frequency), several)
        for frequency, kind in zip(mesh_frequency, found.kind, strict=True)
    ]


def _combination_at(ranges: Sequence[Combination], frequency: float, several: bool) -> str:
    """Name of the combination at an unstable mesh frequency [Hz]; ``beyond first order`` without one."""
    for margin in (0.0, 0.5):
        around = [
            one for one in ranges if abs(2 * frequency - one.low - one.high) <= (1 + 2 * margin) * (one.high - one.low)
        ]
        if around:
            return combination_name(max(around, key=lambda one: one.growth), several)
    return "beyond first order"


def combination_name(one: Combination, several: bool) -> str:
    """``f2 + f5 = 3 f``: natural frequencies, and the mesh frequency, of a stage where there are several."""
    modes = f"2 f{one.first}" if one.first == one.second else f"f{one.first} + f{one.second}"
    mesh = "f" if one.order == 1 else f"{one.order} f"
    return f"{modes} = {mesh}" + (f" of {one.stage}" if several else "")


def resonance_columns(ranges: Sequence[Combination]) -> dict[str, tuple[str, Any]]:
    """The predicted ranges as variables (resonance,)."""
    return {
        **{
            f"resonance_{name}": ("resonance", np.array([getattr(one, name) for one in ranges], dtype=float))
            for name in ("low", "centre", "high", "growth", "threshold")
        },
        **{
            f"resonance_{name}": ("resonance", np.array([getattr(one, name) for one in ranges], dtype=np.int64))
            for name in ("first", "second", "order")
        },
    }


def _natural(ready: ParametricSystem) -> Array:
    """Natural frequencies that the combinations count from 1, (n,) [Hz]."""
    frequency: Array = np.sqrt(ready.modal.squared) / (2 * np.pi)
    return frequency


def _labelled(
    ready: ParametricSystem, frequency: Array, found: FloquetScan, ranges: list[Combination], options: dict[str, Any]
) -> xr.Dataset:
    """The labelled result; frequency (P,) of the first mesh [Hz]."""
    from ...results.dataset import dataset

    several = len(ready.tones) > 1
    return dataset(
        {
            "floquet_multiplier": (("speed", "multiplier"), found.multipliers),
            "largest_multiplier": ("speed", found.largest),
            "growth_rate": ("speed", found.growth),
            "stable": ("speed", found.kind == "stable"),
            "instability": ("speed", found.kind),
            "taking_part": ("speed", np.array(combination_names(found, ranges, frequency, several), dtype=object)),
            "period_steps": ("speed", found.steps),
            "status": ("speed", found.status),
            "frequency": ("mode", _natural(ready)),
            **resonance_columns(ranges),
        },
        {
            "speed": frequency / float(ready.tones[0]),
            "mesh_frequency": ("speed", frequency),
            "multiplier": np.arange(1, found.multipliers.shape[1] + 1),
            "mode": np.arange(1, ready.modal.squared.size + 1),
            "resonance": [combination_name(one, several) for one in ranges],
        },
        verb="stability",
        options={**options, "period": f"{ready.cycles} cycles of the first mesh"},
        provenance=ready.system.provenance,
        warnings=[*ready.system.warnings, *scan_warnings(found)],
        units={"speed": "1"},  # relative to the operating speed, not the rpm of `check`
    )


def scan_warnings(found: FloquetScan) -> list[CodedText]:
    """Warnings: speeds without multipliers, and unstable speeds."""
    failed = [str(status) for status in found.status if status != "ok"]
    unstable = int(np.sum([kind not in ("", "stable") for kind in found.kind]))
    notes = (
        [coded("stability-unknown", f"{len(failed)} of {found.status.size} speeds have no multipliers: {failed[0]}")]
        if failed
        else []
    )
    if found.alone.any():
        text = (
            f"{np.count_nonzero(found.alone)} of {found.alone.size} speeds: the common period of all meshes is too "
            "long; each mesh frequency is judged alone, with the mean stiffness of the other meshes, combinations of "
            "several are not"
        )
        notes.append(coded("stability-unknown", text))
    return notes + (
        [coded("motion-unstable", f"unstable at {unstable} of {found.status.size} speeds")] if unstable else []
    )
