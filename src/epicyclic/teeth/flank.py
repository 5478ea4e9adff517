"""Micro-geometry of a flank: profile and lead modifications as material missing along the tooth normal.

Lengths along the profile are radial heights of the tooth, from the tip circle inward (of a ring outward) or from the
lowest point of contact with the mate.  `relief_height` converts a length of roll.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Relief:
    """Tip, root or end relief: amount at the edge [m], length over which it fades [m], linear or parabolic."""

    amount: float
    length: float
    shape: Literal["linear", "parabolic"] = "linear"


@dataclass(frozen=True, slots=True, kw_only=True)
class Wave:
    """Profile waviness A cos(2 pi n sigma + phase): A [m], n waves a base pitch, phase at the pitch point [rad]."""

    amplitude: float
    order: int = 1
    phase: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Flank:
    """Micro-geometry of one flank of a gear; positive = material missing, lengths [m].

    tip_relief : height from the tip circle.  root_relief : height from the lowest point of contact with the mate.
    end_relief : length along the axis from either end of the face.  crown : lead crowning, missing at both ends of the
    face, parabolic, none at mid-face.  slope : lead slope over the face width, half of it missing at the right end and
    half of it in excess at the left.  profile : measured deviation at heights below the tip circle,
    ((height, missing), ...), linear between, constant beyond.  waves : waviness along the path of contact.
    pitch : cumulative deviation of each tooth, or empty.
    """

    tip_relief: Relief | None = None
    root_relief: Relief | None = None
    end_relief: Relief | None = None
    crown: float = 0.0
    slope: float = 0.0
    profile: tuple[tuple[float, float], ...] = ()
    waves: tuple[Wave, ...] = ()
    pitch: tuple[float, ...] = ()


PLAIN = Flank()


def profile_modification(flank: Flank, *, below_tip: ArrayLike, above_root: ArrayLike, sigma: ArrayLike) -> Array:
    """Profile modification: material missing over the profile [m], of the common shape (...) of its arguments.

    below_tip : (...) height below the tip circle [m].  above_root : (...) height above the lowest point of contact
    with the mate [m].  sigma : (...) place on the path of contact [base pitches].
    """
    depth, height = np.asarray(below_tip, dtype=float), np.asarray(above_root, dtype=float)
    missing = _relieved(flank.tip_relief, depth) + _relieved(flank.root_relief, height)
    if flank.profile:
        at, value = np.array(flank.profile).T
        missing = missing + np.interp(depth, at, value)
    for wave in flank.waves:
        turn = 2 * np.pi * wave.order * np.asarray(sigma) + wave.phase
        missing = missing + wave.amplitude * np.cos(turn)
    return np.asarray(missing)


def lead_modification(flank: Flank, zeta: ArrayLike, face: tuple[float, float]) -> Array:
    """Lead modification: material missing over the face [m], of the shape (...) of zeta.

    zeta : (...) place along the axis [m].  face : left and right end of the face of the gear itself [m].
    """
    left, right = face
    along = np.asarray(zeta, dtype=float)
    part = (2 * along - left - right) / (right - left)
    ends = _relieved(flank.end_relief, np.minimum(along - left, right - along))
    return np.asarray(flank.crown * part**2 + 0.5 * flank.slope * part + ends)


def _relieved(relief: Relief | None, distance: Array) -> Array:
    """Depth (...) of a relief at a distance (...) from its edge [m]; beyond the edge that of the edge."""
    if relief is None or relief.amount == 0.0:
        return np.zeros_like(distance)
    part = np.clip(1 - distance / relief.length, 0.0, 1.0)
    return np.asarray(relief.amount * (part**2 if relief.shape == "parabolic" else part))


def relief_height(roll: float, edge: float, base: float, *, root: bool = False) -> float:
    """Radial height of a relief from its length of roll along the line of action [m].

    roll : length of roll, from the edge towards the middle of the profile [m].  edge : radius at which the relief is
    deepest [m].  base : base radius [m].  root : True for a root relief (of a ring: a tip relief).
    """
    at = math.sqrt(max(0.0, edge**2 - base**2)) + (roll if root else -roll)
    return abs(math.hypot(base, max(0.0, at)) - edge)


def check_flank(flank: Flank, *, height: float, width: float, teeth: int, path: str = "") -> None:
    """Refuse micro-geometry that does not fit a flank.

    height : of the active flank [m].  width : of the face [m].  path : of the flank in the model file.

    Raises
    ------
    ModelError : a relief without length or longer than the flank (end relief: than half the face), a negative or
        infinite amount or one above the height, heights of a profile that do not rise, pitch deviations of another
        number than teeth.
    """
    for name, most in (("tip_relief", height), ("root_relief", height), ("end_relief", width / 2)):
        _check_relief(getattr(flank, name), most, f"{path}.{name}" if path else name)
    for name in ("crown", "slope"):
        if not math.isfinite(getattr(flank, name)):
            raise ModelError("is no finite length", path=f"{path}.{name}", given=getattr(flank, name))
    for name, size in amounts(flank):
        if abs(size) > height:
            raise ModelError(
                "more than the height of the flank: no micro-geometry",
                path=f"{path}.{name}" if path else name,
                given=f"{size * 1e3:.6g} mm",
                allowed=f"at most {height * 1e3:.5g} mm",
            )
    heights = [at for at, _ in flank.profile]
    if any(b <= a for a, b in itertools.pairwise(heights)) or not np.isfinite(flank.profile).all():
        raise ModelError("heights below the tip must rise", path=f"{path}.profile", given=heights)
    if flank.pitch and len(flank.pitch) != teeth:
        raise ModelError("one deviation a tooth", path=f"{path}.pitch", given=len(flank.pitch), allowed=str(teeth))


def amounts(flank: Flank) -> Iterator[tuple[str, float]]:
    """Yield name and size [m] of everything that takes material off, or leaves it."""
    yield from (("crown", flank.crown), ("slope", flank.slope))
    for name in ("tip_relief", "root_relief", "end_relief"):
        if (relief := getattr(flank, name)) is not None:
            yield f"{name}.amount", relief.amount
    yield from (("profile.missing", missing) for _, missing in flank.profile)
    yield from (("wave.amplitude", wave.amplitude) for wave in flank.waves)


def _check_relief(relief: Relief | None, most: float, path: str) -> None:
    if relief is None:
        return
    if not 0 <= relief.amount < math.inf:
        raise ModelError("takes material off", path=f"{path}.amount", given=relief.amount, allowed="0 or more [m]")
    if relief.amount and not 0 < relief.length <= most * (1 + 1e-9):
        raise ModelError(
            "does not fit the flank",
            path=f"{path}.length",
            given=f"{relief.length * 1e3:.5g} mm",
            allowed=f"more than 0, at most {most * 1e3:.5g} mm",
        )
