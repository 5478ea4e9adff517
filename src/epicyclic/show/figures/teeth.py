"""Teeth to scale: involute flanks of a gear, and the turn of each gear at which the teeth really mesh.

All lengths [m], angles [rad]; a tooth is described by the half angle it takes at each radius, seen from the axis.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Mating", "ToothForm", "outline", "rotations", "tooth_form"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ToothForm:
    """Radii of a gear and half the angle of a tooth at the base circle (of a ring: what it tends to there)."""

    teeth: int
    internal: bool
    base_radius: float
    reference_radius: float
    tip_radius: float
    root_radius: float
    base_half_angle: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Mating:
    """One mesh as the drawing needs it: gears by name, polar angle of the pitch point, working angle, loaded flank."""

    a: str
    b: str
    direction: float
    pressure_angle: float
    flank: int
    sigma: float = 0.0


def tooth_form(
    *,
    teeth: int,
    internal: bool,
    base_radius: float,
    reference_radius: float,
    tip_radius: float,
    root_radius: float,
    profile_shift: float,
    pressure_angle: float,
) -> ToothForm:
    """Tooth form from the data of a gear; tips and roots that are not given are drawn for standard proportions.

    Parameters
    ----------
    radii [m], nan where not given; pressure_angle : normal [rad].
    """
    normal = pressure_angle if np.isfinite(pressure_angle) else math.radians(20)
    reference = reference_radius if np.isfinite(reference_radius) else base_radius / math.cos(normal)
    module, inward = 2 * reference / teeth, -1 if internal else 1
    transverse = math.acos(min(base_radius / reference, 1.0)) if base_radius < reference else normal
    half = (math.pi / 2 + 2 * (profile_shift if np.isfinite(profile_shift) else 0.0) * math.tan(normal)) / teeth
    return ToothForm(
        teeth=teeth,
        internal=internal,
        base_radius=base_radius,
        reference_radius=reference,
        tip_radius=tip_radius if np.isfinite(tip_radius) else reference + inward * module,
        root_radius=root_radius if np.isfinite(root_radius) else reference - inward * 1.25 * module,
        base_half_angle=half + inward * _involute(transverse),
    )


def half_angle(form: ToothForm, radius: Array | float) -> Array:
    """Half the angle of a tooth at a radius: psi_b - inv alpha(r), of a ring psi_b + inv alpha(r).

    Below the base circle there is no involute: the flank is drawn radial.
    """
    cosine = np.minimum(form.base_radius / np.asarray(radius, dtype=np.float64), 1.0)
    alpha = np.arccos(cosine)
    turn = np.tan(alpha) - alpha
    half = form.base_half_angle + turn if form.internal else form.base_half_angle - turn
    return np.clip(half, 0.03 * math.pi / form.teeth, 0.97 * math.pi / form.teeth)


def outline(form: ToothForm, turn: float, *, points: int = 4) -> tuple[Array, Array]:
    """Closed outline of a whole gear about its axis, one tooth centred at polar angle `turn`.

    Parameters
    ----------
    points : on each flank.

    Returns
    -------
    x, y : (k,) [m].
    """
    low = form.root_radius if form.internal else max(form.root_radius, min(form.base_radius, form.tip_radius))
    radii = np.linspace(low, form.tip_radius, points)
    if not form.internal and form.root_radius < low:
        radii = np.concatenate([[form.root_radius], radii])
    half = half_angle(form, radii)
    angle = np.concatenate([-half, half[::-1]])
    radius = np.concatenate([radii, radii[::-1]])
    places = turn + 2 * math.pi * np.arange(form.teeth) / form.teeth
    theta = (places[:, None] + angle).ravel()
    r = np.tile(radius, form.teeth)
    closed = np.append(np.arange(len(r)), 0)
    return (r * np.cos(theta))[closed], (r * np.sin(theta))[closed]


def rotations(forms: Mapping[str, ToothForm], matings: list[Mating]) -> dict[str, float]:
    """Polar angle of one tooth centre of every gear, such that teeth meet in every mesh that the train can close.

    The first gear of the first mesh is placed by its `sigma` (place of the contact from the pitch point, base
    pitches); every further gear by the mesh through which it is reached.  Gears in no mesh stand at 0.
    """
    placed: dict[str, float] = {}
    waiting = [mating for mating in matings if mating.a in forms and mating.b in forms]
    while waiting:
        mating = next((one for one in waiting if one.a in placed or one.b in placed), waiting[0])
        waiting.remove(mating)
        a, b = forms[mating.a], forms[mating.b]
        if mating.a not in placed and mating.b not in placed:
            placed[mating.a] = _turn_of_a(a, mating, mating.sigma)
        if mating.b not in placed:
            placed[mating.b] = _turn_of_b(b, mating, _sigma_of_a(a, mating, placed[mating.a]))
        elif mating.a not in placed:
            placed[mating.a] = _turn_of_a(a, mating, _sigma_of_b(b, mating, placed[mating.b]))
    return {name: placed.get(name, 0.0) for name in forms}


def _involute(angle: float) -> float:
    return math.tan(angle) - angle


def _pitch_half_angle(form: ToothForm, mating: Mating) -> float:
    inward = -1 if form.internal else 1
    return form.base_half_angle - inward * _involute(mating.pressure_angle)


def _turn_of_a(form: ToothForm, mating: Mating, sigma: float) -> float:
    turned = 2 * math.pi * mating.flank * sigma / form.teeth
    return mating.direction - mating.flank * _pitch_half_angle(form, mating) + turned


def _sigma_of_a(form: ToothForm, mating: Mating, turn: float) -> float:
    return mating.flank * form.teeth / (2 * math.pi) * (turn - _turn_of_a(form, mating, 0.0))


def _turn_of_b(form: ToothForm, mating: Mating, sigma: float) -> float:
    half, turned = _pitch_half_angle(form, mating), 2 * math.pi * mating.flank * sigma / form.teeth
    if form.internal:
        return mating.direction + mating.flank * half + turned
    return mating.direction + math.pi - mating.flank * half - turned


def _sigma_of_b(form: ToothForm, mating: Mating, turn: float) -> float:
    inward = 1 if form.internal else -1
    return inward * mating.flank * form.teeth / (2 * math.pi) * (turn - _turn_of_b(form, mating, 0.0))
