"""Stability over speed with linear contact: Floquet multipliers, growth rates, kinds of instability and their modes.

The period is the common one of all meshes that vary.  Where it has too many steps, each mesh frequency is judged alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import count
from math import gcd, lcm
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...engine.workers import each, import_results
from ...errors import ModelError
from ...results.ties import largest
from ...statics.tangent import linear
from ...system.system import Array, ComplexArray, System
from ...warning_codes import CodedText, coded
from ..modes.eigen import Modal, modal_form
from ..response.excitation import mesh_tones
from ..response.resonances import of_one_tone
from ..response.response import FrameSpeed
from .combinations import Combination, combinations
from .floquet import STABLE, Floquet, floquet, multiplier_kind, steps_needed

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.run_folder import KeptPart, RunFolder

Progress = Callable[[int, int], None] | None

# A multiplier is real within this part of its magnitude: those of equal modes scatter by the root of the rounding.
_REAL = 1e-6
# Factor of a variation or of damping: beyond it nothing is a gear, and powers of 1e300 are no numbers.
_MOST_FACTOR = 1000
# Steps are doubled where the largest multiplier is this close to the circle.
_NEAR = 0.01
# Steps of one product, states times rows: beyond it a common period of several mesh frequencies is too long.
_MOST_STEPS = 20_000
# Mesh frequencies where none are given.
_POINTS = 200


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParametricSystem:
    """A System prepared for Floquet analysis at any speed.

    tones : (D,) mesh frequencies at the operating speed [Hz], that of the first mesh first.
    cycles : cycles of the first mesh in the common period of all meshes that vary.
    fastest : largest of the tones that vary per the first [1].  harmonics : of the stiffness.
    """

    system: System
    modal: Modal
    tones: tuple[Fraction, ...]
    cycles: Fraction
    fastest: float
    harmonics: int
    frame_speed: FrameSpeed


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FloquetScan:
    """Stability at P speeds.

    Multipliers (P, 2n), largest |mu| [1] and growth rate [1/s] (P,), kinds, steps, status (P,).  alone : (P,) whether
    each mesh frequency was judged alone, for the common period is too long; the values are those that grow fastest.
    """

    multipliers: ComplexArray
    largest: Array
    growth: Array
    kind: NDArray[np.object_]
    steps: NDArray[np.int64]
    status: NDArray[np.object_]
    alone: NDArray[np.bool_]


def parametric_system(
    system: System, *, frame_speed: FrameSpeed = "kinematic", variation: float = 1.0, damping: float = 1.0
) -> ParametricSystem:
    """A System prepared for Floquet analysis; tangents at the mean load stand for the laws of links.

    Parameters
    ----------
    variation : factor of the variation of every mesh stiffness.  damping : factor of all damping.

    Raises
    ------
    ModelError : no mesh frequency, a mass that is missing, or an option out of range.
    """
    if frame_speed not in ("kinematic", "operating"):
        raise ModelError("unknown choice", path="frame_speed", given=frame_speed, allowed="kinematic, operating")
    for name, factor in (("variation", variation), ("damping", damping)):
        if not 0 <= factor <= _MOST_FACTOR:
            raise ModelError("out of range", path=name, given=factor, allowed=f"a factor of 0 to {_MOST_FACTOR}")
    tones = mesh_tones(system)
    system.require_inertia()
    system = linear(system)
    if variation != 1.0 or damping != 1.0:
        meshes = replace(
            system.meshes, variation=variation * system.meshes.variation, damping=damping * system.meshes.damping
        )
        system = replace(
            system,
            C=damping * system.C,
            Cskew=damping * system.Cskew,  # dampers to the housing, seen from a frame that turns
            zeta=None if system.zeta is None else damping * system.zeta,
            meshes=meshes,
        )
    meshes = system.meshes
    varying = [bool(row.any()) for row in meshes.variation]
    used = {system.tones[i] for i, varies in zip(meshes.tone, varying, strict=True) if varies} or {tones[0]}
    common = Fraction(gcd(*(t.numerator for t in used)), lcm(*(t.denominator for t in used)))
    orders = np.flatnonzero(np.any(meshes.variation != 0, axis=0))
    return ParametricSystem(
        system=system,
        modal=modal_form(system),
        tones=tones,
        cycles=tones[0] / common,
        fastest=float(max(used) / tones[0]),
        harmonics=int(orders[-1]) + 1 if orders.size else 0,
        frame_speed=frame_speed,
    )


def floquet_scan(
    ready: ParametricSystem, mesh_frequency: Array, *, progress: Progress = None, kept: KeptPart | None = None
) -> FloquetScan:
    """Multipliers at mesh frequencies of the first mesh (P,) [Hz]; a point that fails holds nan and says why.

    kept : keeps the points that are done.
    """
    P, n = mesh_frequency.size, ready.modal.squared.size
    done = count(1)

    def arrived(place: int, point: _Point) -> None:
        """Count the points."""
        if progress is not None:
            progress(next(done), P)

    work = partial(_point_or_reason, ready)
    points = each(work, mesh_frequency.tolist(), arrived=arrived, kept=kept, meanwhile=import_results)
    return FloquetScan(
        multipliers=np.array([point.multipliers for point in points], complex).reshape(P, 2 * n),
        largest=np.array([point.largest for point in points], float),
        growth=np.array([point.growth for point in points], float),
        kind=np.array([point.kind for point in points], object),
        steps=np.array([point.steps for point in points], np.int64),
        status=np.array([point.status for point in points], object),
        alone=np.array([point.alone for point in points], bool),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Point:
    """Stability at one speed; fields as of `FloquetScan`, those of a point that failed."""

    multipliers: ComplexArray
    largest: float = np.nan
    growth: float = np.nan
    kind: str = ""
    steps: int = 0
    status: str = "ok"
    alone: bool = False


def _point_or_reason(ready: ParametricSystem, frequency: float) -> _Point:
    """Stability at a mesh frequency [Hz], or why there is none."""
    try:
        return _point(ready, frequency)
    except (ModelError, np.linalg.LinAlgError, FloatingPointError) as error:
        return _Point(multipliers=np.full(2 * ready.modal.squared.size, np.nan, complex), status=str(error))


def _point(ready: ParametricSystem, frequency: float) -> _Point:
    """Stability at a mesh frequency [Hz].

    Raises
    ------
    ModelError : a frequency that is not above zero, or a common period that is too long.
    """
    if not (np.isfinite(frequency) and frequency > 0):
        raise ModelError("speed is not a number above zero")
    period = float(ready.cycles) / frequency
    steps = steps_needed(ready.modal, period=period, cycle=1 / (frequency * ready.fastest), harmonics=ready.harmonics)
    if steps > _MOST_STEPS:
        singles = _each_alone(ready)
        if len(singles) > 1:
            points = [_point(single, frequency * float(single.tones[0] / ready.tones[0])) for single in singles]
            return replace(points[largest([point.growth for point in points])], alone=True)
        raise ModelError("a mesh cycle has too many steps of the highest mode: the speed is too low")
    solved = _floquet_at(ready, frequency, steps)
    if abs(_largest(solved) - 1) < _NEAR and 2 * steps <= _MOST_STEPS:
        steps *= 2
        solved = _floquet_at(ready, frequency, steps)
    size = _largest(solved)
    return _Point(
        multipliers=solved.multipliers,
        largest=size,
        growth=float(np.log(size) / period) if size > 0 else np.nan,
        kind=instability_kind(solved.multipliers[~solved.free]),
        steps=steps,
    )


def _each_alone(ready: ParametricSystem) -> list[ParametricSystem]:
    """The System with each mesh frequency that varies alone, the other meshes at their mean stiffness."""
    system, tone = ready.system, np.asarray(ready.system.meshes.tone)
    varying = np.unique(tone[system.meshes.variation.any(axis=1)])
    alone = {system.tones[i]: of_one_tone(system, system.tones[i], tone == i) for i in varying}
    return [replace(ready, system=single, tones=(f,), cycles=Fraction(1), fastest=1.0) for f, single in alone.items()]


def _floquet_at(ready: ParametricSystem, frequency: float, steps: int) -> Floquet:
    """Multipliers at a mesh frequency [Hz] of the first mesh, the common period in so many steps."""
    speed = frequency / float(ready.tones[0])
    return floquet(
        ready.modal,
        _stiffness_change(ready, steps),
        period=float(ready.cycles) / frequency,
        frame=speed if ready.frame_speed == "kinematic" else 1.0,
    )


def _stiffness_change(ready: ParametricSystem, steps: int) -> Array:
    """Stiffness of every mesh less its mean at equal steps of the common period, (m, steps) [N/m]."""
    meshes, steps_done = ready.system.meshes, np.arange(steps)
    # one turn in equal steps: a phase of many cycles is one of them, without the digits that whole turns would lose
    turn = 2 * np.pi / steps * steps_done
    turn = np.stack([np.cos(turn), -np.sin(turn)])
    change = np.zeros((len(meshes.stiffness), steps))
    for place, tone in enumerate(ready.system.tones):
        followers = np.flatnonzero((np.asarray(meshes.tone) == place) & meshes.variation.any(axis=1))
        if not followers.size:
            continue
        # whole, for the period is one of all meshes that vary
        cycles = int(tone / ready.tones[0] * ready.cycles)
        waves = turn[:, np.outer(cycles * np.arange(1, ready.harmonics + 1), steps_done) % steps]
        varying = meshes.variation[followers, : ready.harmonics]
        change[followers] = np.hstack([varying.real, varying.imag]) @ waves.reshape(-1, steps)
    return meshes.stiffness[:, None] * change


def _largest(solved: Floquet) -> float:
    """Largest magnitude of a multiplier that is no free motion's, 0 where there is none."""
    return float(np.abs(solved.multipliers[~solved.free]).max(initial=0.0))


def instability_kind(multipliers: ComplexArray) -> str:
    """One of `floquet.KINDS`, of multipliers (k,) without those of free motions."""
    if not multipliers.size:
        return STABLE
    return multiplier_kind(complex(multipliers[np.argmax(np.abs(multipliers))]), real=_REAL)


def predicted_combinations(ready: ParametricSystem, mesh_frequency: Array) -> list[Combination]:
    """Ranges of instability by averaging within the range of some mesh frequencies (P,) [Hz]."""
    usable = mesh_frequency[np.isfinite(mesh_frequency) & (mesh_frequency > 0)]
    if not usable.size:
        return []
    return combinations(
        ready.system,
        ready.modal,
        tuple(float(tone) for tone in ready.tones),
        low=float(usable.min()),
        high=float(usable.max()),
        turning=ready.frame_speed == "kinematic",
    )


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
    scan = floquet_scan(ready, frequency, progress=progress, kept=done)
    options = {"frame_speed": frame_speed, "variation": variation, "damping": damping}
    return _labelled(ready, frequency, scan, predicted_combinations(ready, frequency), options)


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
    scan: FloquetScan, ranges: Sequence[Combination], mesh_frequency: Array, several: bool
) -> list[str]:
    """At each unstable mesh frequency (P,) [Hz] the combination whose predicted range holds it, the fastest; else "".

    The ends of a range are known to first order: the next range counts up to half its width away.
    """
    return [
        "" if kind in ("", "stable") else _combination_at(ranges, float(frequency), several)
        for frequency, kind in zip(mesh_frequency, scan.kind, strict=True)
    ]


def _combination_at(ranges: Sequence[Combination], frequency: float, several: bool) -> str:
    """Name of the combination at an unstable mesh frequency [Hz]; ``beyond first order`` without one."""
    for margin in (0.0, 0.5):
        around = [
            each
            for each in ranges
            if abs(2 * frequency - each.low - each.high) <= (1 + 2 * margin) * (each.high - each.low)
        ]
        if around:
            return combination_name(max(around, key=lambda each: each.growth), several)
    return "beyond first order"


def combination_name(pair: Combination, several: bool) -> str:
    """``f2 + f5 = 3 f``: natural frequencies, and the mesh frequency, of a stage where there are several."""
    modes = f"2 f{pair.first}" if pair.first == pair.second else f"f{pair.first} + f{pair.second}"
    mesh = "f" if pair.order == 1 else f"{pair.order} f"
    return f"{modes} = {mesh}" + (f" of {pair.stage}" if several else "")


def resonance_columns(ranges: Sequence[Combination]) -> dict[str, tuple[str, Any]]:
    """The predicted ranges as variables (resonance,)."""
    columns: dict[str, tuple[str, Any]] = {}
    for name in ("low", "centre", "high", "growth", "threshold", "first", "second", "order"):
        kind = np.int64 if name in ("first", "second", "order") else np.float64
        columns[f"resonance_{name}"] = "resonance", np.array([getattr(each, name) for each in ranges], dtype=kind)
    return columns


def _labelled(
    ready: ParametricSystem, frequency: Array, scan: FloquetScan, ranges: list[Combination], options: dict[str, Any]
) -> xr.Dataset:
    """The labelled result; frequency (P,) of the first mesh [Hz]."""
    from ...results.dataset import dataset

    several = len(ready.tones) > 1
    return dataset(
        {
            "floquet_multiplier": (("speed", "multiplier"), scan.multipliers),
            "largest_multiplier": ("speed", scan.largest),
            "growth_rate": ("speed", scan.growth),
            "stable": ("speed", scan.kind == "stable"),
            "instability": ("speed", scan.kind),
            "taking_part": ("speed", np.array(combination_names(scan, ranges, frequency, several), dtype=object)),
            "period_steps": ("speed", scan.steps),
            "status": ("speed", scan.status),
            "frequency": ("mode", np.sqrt(ready.modal.squared) / (2 * np.pi)),  # the combinations count them from 1
            **resonance_columns(ranges),
        },
        {
            "speed": frequency / float(ready.tones[0]),
            "mesh_frequency": ("speed", frequency),
            "multiplier": np.arange(1, scan.multipliers.shape[1] + 1),
            "mode": np.arange(1, ready.modal.squared.size + 1),
            "resonance": [combination_name(each, several) for each in ranges],
        },
        verb="stability",
        options={**options, "period": f"{ready.cycles} cycles of the first mesh"},
        provenance=ready.system.provenance,
        warnings=[*ready.system.warnings, *scan_warnings(scan)],
        units={"speed": "1"},  # relative to the operating speed, not the rpm of `check`
    )


def scan_warnings(scan: FloquetScan) -> list[CodedText]:
    """Warnings: speeds without multipliers, and unstable speeds."""
    notes, speeds = list[CodedText](), scan.status.size
    failed = [str(status) for status in scan.status if status != "ok"]
    if failed:
        notes.append(coded("stability-unknown", f"{len(failed)} of {speeds} speeds have no multipliers: {failed[0]}"))
    if scan.alone.any():
        text = (
            f"{np.count_nonzero(scan.alone)} of {speeds} speeds: the common period of all meshes is too "
            "long; each mesh frequency is judged alone, with the mean stiffness of the other meshes, combinations of "
            "several are not"
        )
        notes.append(coded("stability-unknown", text))
    unstable = int(np.sum([kind not in ("", "stable") for kind in scan.kind]))
    if unstable:
        notes.append(coded("motion-unstable", f"unstable at {unstable} of {speeds} speeds"))
    return notes
