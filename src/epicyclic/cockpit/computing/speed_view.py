"""Largest mesh forces over speed as the page draws them: curves, peaks with their modes, the range."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from ...questions.modes.campbell import OPERATION
from ...questions.response.measures import force_extremes, mean
from ...questions.response.resonances import of_one_tone
from ...questions.response.response import Response, respond_part, response, response_parts, unstable_speeds
from ...questions.response.sweep_table import speeds_of
from ...questions.response.waveform import force_signal, whole_mesh_signal
from ...system.system import Array, System, faces
from .mode_view import ModeView
from .names import SpeedAxis, ordinal, rounded

__all__ = ["Effort", "Efforts", "ForceCurves", "SpeedModel", "efforts", "force_curves", "speed_head", "speed_model"]

# Residual per tolerance that is accepted, as of the verb `sweep`.
_ACCEPTED = 100.0
# Speeds while a lever moves, at rest and with shaft orders, by the number of mesh frequencies that combine: with two
# a speed takes 2 ms and with shaft orders 20 ms.
_POINTS = {1: (120, 200, 60), 2: (48, 120, 60), 3: (120, 200, 0)}
# Mesh frequencies that are solved together: with three a speed takes half a second, and they are solved one at a time.
_TOGETHER = 2
# Curves that are drawn strong: more are not told apart.  Curves that differ by less than this part of the largest
# force are one to the eye.
_STRONG, _ALIKE = 4, 2e-3
# A peak stands out by this part of the range of the largest force; more labels than these cover the curve.
_PROMINENCE, _PEAKS = 0.03, 8
# Distance of a peak from the speed of its mode, per speed, as far as varying stiffness and gyroscopic terms move it;
# and what an order counts against a lower one, so that of two modes at one place the more strongly excited is named.
_NEAR, _PER_ORDER = 0.03, 0.002


@dataclass(frozen=True, slots=True, kw_only=True)
class Effort:
    """How a curve is computed.  points : speeds.  shaft_orders : whether they count.  tolerance : residual [1]."""

    points: int
    shaft_orders: bool
    tolerance: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Efforts:
    """How the curves of a train are computed: while a lever moves, at rest, and with shaft orders (None: not)."""

    live: Effort
    full: Effort
    shafts: Effort | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ForceCurves:
    """Largest force of w whole meshes at P speeds.

    speed : (P,) per operating speed [1], rising.  force : (w, P) [N], nan where there is no solution.
    shaft_orders : whether they count.  alone : whether the mesh orders of one stage at a time were solved.
    """

    speed: Array
    force: Array
    shaft_orders: bool
    alone: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SpeedModel:
    """A train ready for its curves.

    whole : all mesh frequencies together, which gives the speeds.  solved : what is solved, `whole` itself or, with
    three mesh frequencies and more that combine, one Response of each alone.
    """

    whole: Response
    solved: tuple[Response, ...]

    @property
    def alone(self) -> bool:
        """Whether the mesh orders of one stage at a time are solved."""
        return self.solved[0] is not self.whole


def speed_model(system: System, *, compiled: bool) -> SpeedModel:
    """A System ready for its curves; compiled : by numba.

    Raises
    ------
    ModelError : no damping, no mesh frequency, or torques that do not balance.
    """
    whole = response(system, compiled=compiled)
    tones = whole.lines.tones
    if len(tones) <= _TOGETHER or not whole.system.meshes.variation.any():
        return SpeedModel(whole=whole, solved=(whole,))
    own = [np.array([system.tones[i] == tone for i in system.meshes.tone]) for tone in tones]
    alone = (of_one_tone(system, tone, rows) for tone, rows in zip(tones, own, strict=True))
    return SpeedModel(whole=whole, solved=tuple(response(one, compiled=compiled) for one in alone))


def efforts(model: SpeedModel) -> Efforts:
    """How the curves of a train are computed, by its number of mesh frequencies.

    A tolerance of 1e-4 moves no force by more than 0.4 % (ready drives), what a pixel is; at rest, with 4e-5, it is
    0.04 %.
    """
    combined = len(model.whole.lines.tones) if model.whole.system.meshes.variation.any() else 1
    live, full, shafts = _POINTS[min(combined, _TOGETHER + 1)]
    return Efforts(
        live=Effort(points=live, shaft_orders=False, tolerance=1e-4),
        full=Effort(points=full, shaft_orders=False, tolerance=4e-5),
        shafts=Effort(points=shafts, shaft_orders=True, tolerance=4e-5) if shafts and model.whole.lines.shaft else None,
    )


def force_curves(model: SpeedModel, effort: Effort, *, pause: Callable[[], None] = lambda: None) -> ForceCurves:
    """Largest mesh forces about operation, the numbers of the verb `sweep` at its default speeds but for the tolerance.

    Where the mesh frequencies are solved one at a time, the largest force is the mean and what each adds to it: an
    upper bound but for the combinations of mesh frequencies.  Speeds without a steady motion hold nan.

    Parameters
    ----------
    pause : called between parts of the work; what it raises ends the work.
    """
    whole = model.whole
    speed = speeds_of(whole, mesh_frequency=None, relative_speed=None, speed_range=None, points=effort.points)
    stable = np.flatnonzero(~unstable_speeds(whole, speed))
    force = np.full((len(faces(whole.system.meshes).name), speed.size), np.nan)
    for number, ready in enumerate(model.solved):
        largest, average = _solved(ready, speed[stable], effort, pause)
        force[:, stable] = largest if number == 0 else force[:, stable] + largest - average
    return ForceCurves(speed=speed, force=force, shaft_orders=effort.shaft_orders, alone=model.alone)


def _solved(ready: Response, speed: Array, effort: Effort, pause: Callable[[], None]) -> tuple[Array, Array]:
    """Largest and mean force (w, P) [N] of the whole meshes at relative speeds (P,), nan where not solved."""
    face = faces(ready.system.meshes)
    largest, average = (np.full((len(face.name), speed.size), np.nan) for _ in range(2))
    accepted = _ACCEPTED * effort.tolerance
    ready, parts = response_parts(ready, speed, shaft_orders=effort.shaft_orders)
    for part in parts:
        for block in respond_part(ready, speed, part, tolerance=effort.tolerance, shaft_orders=effort.shaft_orders):
            with np.errstate(all="ignore"):  # a point that overflows is not finite, beside the others
                signal = whole_mesh_signal(force_signal(ready, block), face)
                most = force_extremes(signal, axis=ready.lines.axis[face.first])[1]
                middle = mean(signal)
            pause()
            good = (block.residual <= accepted) & (block.uncertainty <= accepted)
            largest[:, block.index] = np.where(good, most, np.nan)
            average[:, block.index] = np.where(good, middle, np.nan)
    return largest, average


def speed_head(
    curves: ForceCurves, axis: SpeedAxis, modes: ModeView | None, labels: Sequence[str]
) -> tuple[dict[str, Any], dict[str, NDArray[np.float64]]]:
    """``head["sweep"]`` and the arrays ``x`` (P,) and ``y`` (w, P) in its units.

    labels : (w,) of the meshes.
    """
    label, operating = axis
    most = float(np.nanmax(curves.force, initial=0.0))
    unit, scale = ("kN", 1e-3) if most >= 1e3 else ("N", 1.0)
    strong = _strong(curves.force)
    alike = {row: sum(one == row for one in strong.values()) - 1 for row in set(strong.values())}
    head = {
        "x_label": label,
        "y_label": f"largest mesh force [{unit}]",
        "operating": operating,
        "stage": "with shaft orders" if curves.shaft_orders else "mesh orders",
        "note": "mesh orders of one stage at a time" if curves.alone else "",
        "curves": [
            {
                "label": name + (f" and {alike[row]} alike" if alike.get(row) else ""),
                "mesh": row,
                "strong": row in alike,
            }
            for row, name in enumerate(labels)
        ],
        "peaks": _peaks(curves, operating, scale, modes),
        "range": [OPERATION[0] * operating, OPERATION[1] * operating],
        "to_relative": 1 / operating,
    }
    return head, {"x": curves.speed * operating, "y": curves.force * scale}


def _strong(force: Array) -> dict[int, int]:
    """Row -> the curve drawn strong that stands for it, of forces (w, P): those with the largest, each look once."""
    with np.errstate(all="ignore"):
        most = np.nanmax(np.where(np.isnan(force), -np.inf, force), axis=1, initial=-np.inf)
    # rounding does not choose among equal branches: those that are one to the eye come in their own order
    step = _ALIKE * max(float(np.max(np.abs(most[np.isfinite(most)]), initial=0.0)), 1e-300)
    result: dict[int, int] = {}
    chosen: list[int] = []
    for row in np.lexsort((np.arange(len(most)), -np.round(most / step))) if len(most) else []:
        if not np.isfinite(most[row]):
            continue
        same = next((one for one in chosen if _one_to_the_eye(force[one], force[row], step)), None)
        if same is None and len(chosen) < _STRONG:
            chosen.append(int(row))
            same = int(row)
        if same is not None:
            result[int(row)] = same
    return result


def _one_to_the_eye(one: Array, other: Array, step: float) -> bool:
    """Whether two curves (P,) [N] lie on each other."""
    apart = np.abs(one - other)
    known = np.isfinite(apart)
    return bool(known.any() and apart[known].max() <= step)


def _peaks(curves: ForceCurves, operating: float, scale: float, modes: ModeView | None) -> list[dict[str, Any]]:
    """The highest peaks of the largest force of any mesh, with the mode and order that meet there."""
    known = np.isfinite(curves.force).any(axis=0)
    speed = curves.speed[known]
    if speed.size < 3:
        return []
    most = np.nanmax(curves.force[:, known], axis=0)
    least = _PROMINENCE * max(float(np.ptp(most)), 1e-9 * float(np.abs(most).max()))
    places, found = find_peaks(most, prominence=max(least, 1e-300))
    highest = places[np.argsort(-found["prominences"], kind="stable")[:_PEAKS]]
    return [
        {"x": float(speed[i] * operating), "y": float(most[i] * scale), **_met(float(speed[i]), modes)}
        for i in sorted(highest.tolist())
    ]


def _met(speed: float, modes: ModeView | None) -> dict[str, Any]:
    """Label and number of the mode that a mesh order meets nearest to a speed per operating speed [1]."""
    if modes is None or not modes.crossings.relative_speed.size:
        return {"label": "", "mode": None, "text": ""}
    found = modes.crossings
    away = np.abs(found.relative_speed / speed - 1)
    cost = np.where(away <= _NEAR, away + _PER_ORDER * found.order, np.inf)
    best = int(cost.argmin())
    if not np.isfinite(cost[best]):
        return {"label": "", "mode": None, "text": ""}
    number = int(found.mode[best]) + 1
    place = modes.of_number.get(number)
    hertz = f"{rounded(float(modes.frequency[place]), 4)} Hz" if place is not None else ""
    order = f"{ordinal(int(found.order[best]))} order"
    text = f"{order} meets mode {number}" + (f": {modes.label[place]}" if place is not None else "")
    return {"label": ", ".join(filter(None, [hertz, order])), "mode": number, "text": text}
