"""Stability of the motion over speed: Floquet multipliers, growth rates, kinds of instability and their modes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ...errors import ModelError
from ...system.system import Array, System
from ..steady.response import FrameSpeed
from .combinations import Combination
from .scan import Progress, Speeds, Stability, predicted, prepared, scan

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["growing", "named", "stability", "told", "warned"]

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
) -> xr.Dataset:
    """Floquet multipliers of the linear-contact motion over speed, and the boundaries that averaging predicts.

    With several mesh frequencies the period is the common one of all meshes that vary; where that takes more than
    20 000 steps the point holds nan, and only the prediction is left.

    Parameters
    ----------
    mesh_frequency : (P,) of the first mesh [Hz], or relative_speed : (P,) speeds per operating speed; neither: 200
        mesh frequencies from a fifth of the lowest to 1.2 times the highest natural frequency.
    frame_speed : as of `sweep`.  variation, damping : factors of the variation of the meshes and of all damping.
    progress : called with (points done, points).

    Raises
    ------
    ModelError : no mesh frequency, a mass that is missing, or an option out of range.
    A single speed that fails holds nan, and ``status`` says why.  No damping at all is allowed: the train is then
    stable where nothing grows.
    """
    ready = prepared(system, frame_speed=frame_speed, variation=variation, damping=damping)
    frequency = _frequencies(ready, mesh_frequency, relative_speed)
    found = scan(ready, frequency, progress=progress)
    options = {"frame_speed": frame_speed, "variation": variation, "damping": damping}
    return _labelled(ready, frequency, found, predicted(ready, frequency), options)


def _frequencies(ready: Stability, mesh_frequency: ArrayLike | None, relative_speed: ArrayLike | None) -> Array:
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


def growing(found: Speeds, ranges: Sequence[Combination], mesh_frequency: Array, several: bool) -> list[str]:
    """At each unstable speed the combination whose predicted range holds it, the fastest of several; else "".

    The ends of a range are known to first order: the next range counts up to half its width away.
    """
    return [
        "" if kind in ("", "stable") else _belongs(ranges, float(frequency), several)
        for frequency, kind in zip(mesh_frequency, found.kind, strict=True)
    ]


def _belongs(ranges: Sequence[Combination], frequency: float, several: bool) -> str:
    for margin in (0.0, 0.5):
        around = [
            one for one in ranges if abs(2 * frequency - one.low - one.high) <= (1 + 2 * margin) * (one.high - one.low)
        ]
        if around:
            return named(max(around, key=lambda one: one.growth), several)
    return "beyond first order"


def named(one: Combination, several: bool) -> str:
    """``f2 + f5 = 3 f``: natural frequencies, and the mesh frequency, of a stage where there are several."""
    modes = f"2 f{one.first}" if one.first == one.second else f"f{one.first} + f{one.second}"
    mesh = "f" if one.order == 1 else f"{one.order} f"
    return f"{modes} = {mesh}" + (f" of {one.stage}" if several else "")


def told(ranges: Sequence[Combination]) -> dict[str, tuple[str, Any]]:
    """The predicted ranges as variables along ``resonance``."""
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


def _natural(ready: Stability) -> Array:
    """Natural frequencies that the combinations count from 1 [Hz], (n,)."""
    frequency: Array = np.sqrt(ready.modal.squared) / (2 * np.pi)
    return frequency


def _labelled(
    ready: Stability, frequency: Array, found: Speeds, ranges: list[Combination], options: dict[str, Any]
) -> xr.Dataset:
    from ...results.dataset import dataset

    several = len(ready.tones) > 1
    return dataset(
        {
            "floquet_multiplier": (("speed", "multiplier"), found.multipliers),
            "largest_multiplier": ("speed", found.largest),
            "growth_rate": ("speed", found.growth),
            "stable": ("speed", found.kind == "stable"),
            "instability": ("speed", found.kind),
            "taking_part": ("speed", np.array(growing(found, ranges, frequency, several), dtype=object)),
            "period_steps": ("speed", found.steps),
            "status": ("speed", found.status),
            "frequency": ("mode", _natural(ready)),
            **told(ranges),
        },
        {
            "speed": frequency / float(ready.tones[0]),
            "mesh_frequency": ("speed", frequency),
            "multiplier": np.arange(1, found.multipliers.shape[1] + 1),
            "mode": np.arange(1, ready.modal.squared.size + 1),
            "resonance": [named(one, several) for one in ranges],
        },
        verb="stability",
        options={**options, "period": f"{ready.cycles} cycles of the first mesh"},
        provenance=ready.system.provenance,
        warnings=[*ready.system.warnings, *warned(found)],
        units={"speed": "1"},  # relative to the operating speed, not the rpm of `check`
    )


def warned(found: Speeds) -> list[str]:
    """What a reader has to know before the numbers."""
    failed = [str(status) for status in found.status if status != "ok"]
    unstable = int(np.sum([kind not in ("", "stable") for kind in found.kind]))
    notes = [f"{len(failed)} of {found.status.size} speeds have no multipliers: {failed[0]}"] if failed else []
    return notes + ([f"unstable at {unstable} of {found.status.size} speeds"] if unstable else [])
