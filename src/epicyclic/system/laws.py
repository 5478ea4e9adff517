"""Laws on groups of rows: play, rolling elements, splines with friction, each from one convex potential.

A group is the rows of one link (x and y of a bearing or spline, or one row) with the stretch delta (r,), rho = |delta|.
All laws but one are radial, force = f(rho) delta / rho with

    f(rho) = min(k rho, F_m) + C <rho - S_2>^n        S_1 = F_m / k,  S_2 = S_1 + clearance

Without friction (F_m = 0) that is play and then a power law; with friction it is a spline [dong2019, eq. 27]: elastic up
to the slip start S_1, sliding at F_m until the clearance is used up, elastic again.  S_1 is derived: any other value
makes the force jump.  C follows from k, the tangent stiffness at the stated load F: k = n C^(1/n) F^((n - 1)/n).

The law with a memory (Coulomb) has a slider s in series with the spring: force = k (delta - s), and at each step

    s = argmin  k |delta - s|^2 / 2 + F_m |s - s_before|    over  |s| <= clearance

Along a first straight pull it equals the radial law; on the way back it sticks, where the radial one slides back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "STATES",
    "Law",
    "LawGroup",
    "Laws",
    "force",
    "kinks",
    "potential",
    "radial_parts",
    "row_owner",
    "size",
    "slide",
    "stacked",
    "state",
    "tangent",
]

Array = NDArray[np.float64]

STATES = ("play", "stick", "slip", "stop")
# halvings of the multiplier at the stop: below rounding
_HALVINGS = 54


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """One law, in SI.

    stiffness : k, tangent at `load` where the exponent is not 1 [N/m].  clearance : radial [m].  exponent : n [1].
    load : [N].  friction : F_m [N], 0 without.  memory : Coulomb friction with a history; else holonomic.
    """

    stiffness: float
    clearance: float = 0.0
    exponent: float = 1.0
    load: float = 0.0
    friction: float = 0.0
    memory: bool = False

    @property
    def slip_start(self) -> float:
        """S_1 = F_m / k [m]."""
        return self.friction / self.stiffness

    @property
    def coefficient(self) -> float:
        """C of the force C <rho - S_2>^n [N/m^n]."""
        n = self.exponent
        return self.stiffness if n == 1.0 else float((self.stiffness / (n * self.load ** ((n - 1) / n))) ** n)

    @property
    def kind(self) -> str:
        """What it is called in results."""
        if self.friction:
            return "coulomb spline" if self.memory else "holonomic spline"
        if self.exponent != 1.0:
            return "rolling elements with play" if self.clearance else "rolling elements"
        return "play" if self.clearance else "linear"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LawGroup:
    """The rows of one link that follow a law.

    name : of the link, ``main/sun/support``.  kind : of the link: support, bearing, coupling, ...
    rows : (r,) ``main/sun/support/x``.  B : (n, r).  law.
    damping : (r,) of its dampers, in C already [N s/m].  lag : damping per tangent stiffness, not in C [s].
    """

    name: str
    kind: str
    rows: tuple[str, ...]
    B: Array
    law: Law
    damping: Array
    lag: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Laws:
    """The laws of G groups over R rows as arrays: first row of each group, owner of each row, and the (G,) numbers."""

    first: NDArray[np.int64]
    owner: NDArray[np.int64]
    stiffness: Array
    friction: Array
    clearance: Array
    coefficient: Array
    exponent: Array
    memory: NDArray[np.bool_]

    @property
    def slip_start(self) -> Array:
        """S_1 (G,) [m]."""
        return self.friction / self.stiffness

    @property
    def row_stiffness(self) -> Array:
        """k of every row, (R,) [N/m]."""
        return self.stiffness[self.owner]


def stacked(groups: Sequence[LawGroup]) -> Laws:
    """The laws of the groups, rows in order."""
    counts = np.array([len(group.rows) for group in groups], dtype=np.int64)
    laws = [group.law for group in groups]

    def values(name: str) -> Array:
        return np.array([getattr(law, name) for law in laws], dtype=float)

    return Laws(
        first=np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)[: len(groups)],
        owner=np.repeat(np.arange(len(groups)), counts),
        stiffness=values("stiffness"),
        friction=values("friction"),
        clearance=values("clearance"),
        coefficient=values("coefficient"),
        exponent=values("exponent"),
        memory=np.array([law.memory and law.friction > 0 for law in laws], dtype=bool),
    )


def row_owner(laws: Laws, values: Array) -> Array:
    """Values of groups (..., G) at each row (..., R)."""
    return values[..., laws.owner]


def size(laws: Laws, rows: Array) -> Array:
    """Length |.| of each group's part of (..., R), (..., G)."""
    return np.sqrt(_dot(laws, rows, rows))


def radial_parts(laws: Laws, rho: Array) -> tuple[Array, Array]:
    """f and f' of the radial law at rho (..., G): [N], [N/m]."""
    beyond = rho - (laws.slip_start + laws.clearance)
    pressed = np.maximum(beyond, 0.0)
    n = laws.exponent
    value = np.minimum(laws.stiffness * rho, laws.friction) + laws.coefficient * pressed**n
    slope = np.where(beyond >= 0, laws.coefficient * n * pressed ** (n - 1), 0.0)
    slope += np.where(rho < laws.slip_start, laws.stiffness, 0.0)
    return value, slope


def potential(laws: Laws, delta: Array, anchor: Array | None = None) -> Array:
    """Energy of each group (..., G) [J]; with a memory that of one step from the slider `anchor` (..., R) [m]."""
    rho, start, n = size(laws, delta), laws.slip_start, laws.exponent
    pressed = np.maximum(rho - (start + laws.clearance), 0.0)
    stuck = laws.stiffness * rho**2 / 2
    with np.errstate(invalid="ignore"):
        dry = np.where(rho <= start, stuck, laws.friction * (rho - start / 2))
    energy = dry + laws.coefficient * pressed ** (n + 1) / (n + 1)
    if anchor is None or not laws.memory.any():
        return energy
    slider = slide(laws, delta, anchor)
    step = laws.stiffness * size(laws, delta - slider) ** 2 / 2 + laws.friction * size(laws, slider - anchor)
    return np.where(laws.memory, step, energy)


def force(laws: Laws, delta: Array, anchor: Array | None = None) -> Array:
    """Force along every row, the gradient of the potential (..., R) [N]."""
    rho = size(laws, delta)
    value, slope = radial_parts(laws, rho)
    secant = np.where(rho > 0, value / np.where(rho > 0, rho, 1.0), slope)
    result: Array = row_owner(laws, secant) * delta
    if anchor is None or not laws.memory.any():
        return result
    spring = laws.row_stiffness * (delta - slide(laws, delta, anchor))
    return np.where(row_owner(laws, laws.memory), spring, result)


def tangent(laws: Laws, delta: Array, anchor: Array | None = None) -> Array:
    """Derivative of the force, symmetric, block by block (..., R, R) [N/m]."""
    rho = size(laws, delta)
    value, slope = radial_parts(laws, rho)
    secant = np.where(rho > 0, value / np.where(rho > 0, rho, 1.0), slope)
    result = _blocks(laws, delta / row_owner(laws, np.where(rho > 0, rho, 1.0)), along=slope, across=secant)
    if anchor is None or not laws.memory.any():
        return result
    held = row_owner(laws, laws.memory)
    return np.where(held[:, None], _sliding_tangent(laws, delta, anchor), result)


def _blocks(laws: Laws, unit: Array, *, along: Array, across: Array) -> Array:
    """along n n' + across (1 - n n') in every group, for unit vectors n (..., R)."""
    same = laws.owner[:, None] == laws.owner
    dyad = row_owner(laws, along - across)[..., :, None] * unit[..., :, None] * unit[..., None, :]
    result: Array = np.where(same, dyad, 0.0)
    rows = np.arange(laws.owner.size)
    result[..., rows, rows] += row_owner(laws, across)
    return result


def kinks(laws: Laws, delta: Array, step: Array, anchor: Array | None = None) -> Array:
    """Lengths a at which delta + a step crosses S_1 or S_2 of a group, or is nearest to its middle, (T, 5 G).

    nan and negative where it does not.  With a memory S_1 counts from the slider.
    """
    start = laws.slip_start
    around = np.where(row_owner(laws, laws.memory), 0.0 if anchor is None else anchor, 0.0)
    square = size(laws, step) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        nearest = -_dot(laws, delta, step) / square
        first = _crossings(laws, delta - around, step, start)
        second = _crossings(laws, delta, step, start + laws.clearance)
    return np.concatenate([nearest, *first, *second], axis=-1)


def _crossings(laws: Laws, delta: Array, step: Array, radius: Array) -> tuple[Array, Array]:
    """Both a with |delta + a step| = radius."""
    square = size(laws, step) ** 2
    middle = -_dot(laws, delta, step) / square
    half = np.sqrt(middle**2 - (size(laws, delta) ** 2 - radius**2) / square)
    return middle - half, middle + half


def _dot(laws: Laws, a: Array, b: Array) -> Array:
    return np.add.reduceat(a * b, laws.first, axis=-1) if laws.first.size else a[..., :0]


def state(laws: Laws, delta: Array, anchor: Array | None = None) -> NDArray[np.int64]:
    """What each group does (..., G), as an index into `STATES`.

    play : inside the clearance, no force.  stick : elastic before the slip start.  slip : sliding at the friction
    force.  stop : beyond the clearance, on the elements or the teeth.
    """
    rho = size(laws, delta)
    before = np.where(laws.friction > 0, np.where(rho < laws.slip_start, 1, 2), 0)
    found = np.where(rho >= laws.slip_start + laws.clearance, 3, before)
    if anchor is None or not laws.memory.any():
        return found
    slider = slide(laws, delta, anchor)
    moved = size(laws, slider - anchor) > 0
    # rounding of the slider at its stop
    stopped = size(laws, slider) >= laws.clearance * (1 - 1e-12)
    return np.where(laws.memory, np.where(stopped, 3, np.where(moved, 2, 1)), found)


# the slider ----------------------------------------------------------------------------------------------------------


def slide(laws: Laws, delta: Array, anchor: Array) -> Array:
    """Slider of every group after a step to delta from a slider at `anchor`, (..., R) [m]; 0 without a memory."""
    slider, _ = _slid(laws, delta, anchor)
    return np.where(row_owner(laws, laws.memory), slider, 0.0)


def _slid(laws: Laws, delta: Array, anchor: Array) -> tuple[Array, Array]:
    """Slider (..., R), and a = k / (k + lambda) (..., G) with lambda the multiplier of the stop; 1 away from it.

    For a given lambda the least is anchor + shrunk(a delta - anchor, a S_1), and its length falls as lambda rises.
    """
    share = np.ones((*delta.shape[:-1], laws.first.size))
    slider = _shrunk(laws, delta, anchor, share)
    out = laws.memory & (size(laws, slider) > laws.clearance)
    if not out.any():
        return slider, share
    low, high = np.zeros_like(share), share.copy()
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        beyond = size(laws, _shrunk(laws, delta, anchor, middle)) > laws.clearance
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    share = np.where(out, low, 1.0)
    return _shrunk(laws, delta, anchor, share), share


def _shrunk(laws: Laws, delta: Array, anchor: Array, share: Array) -> Array:
    """anchor + w <1 - a S_1 / |w|>,  w = a delta - anchor."""
    pull = row_owner(laws, share) * delta - anchor
    length = size(laws, pull)
    factor = np.maximum(1.0 - share * laws.slip_start / np.where(length > 0, length, np.inf), 0.0)
    factor = np.where(length > 0, factor, 0.0)
    result: Array = anchor + row_owner(laws, factor) * pull
    return result


def _sliding_tangent(laws: Laws, delta: Array, anchor: Array) -> Array:
    """Derivative of k (delta - s): k where it sticks, F_m / |delta - anchor| across the slip where it slides.

    At the stop the slider can only move along it, by k / D of what delta does along it, with
    D = k + lambda + F_m (n . s / |s|)^2 / |s - anchor| and n the direction of the slip.
    """
    k, friction = laws.stiffness, laws.friction
    slider, share = _slid(laws, delta, anchor)
    moved, pull = size(laws, slider - anchor), size(laws, delta - anchor)
    slips, stopped = moved > 0, share < 1.0
    unit = (delta - anchor) / row_owner(laws, np.where(pull > 0, pull, 1.0))
    free = np.where(slips, friction / np.where(pull > 0, pull, 1.0), k)
    result = _blocks(laws, unit, along=np.where(slips, 0.0, k), across=free)
    if not stopped.any():
        return result
    radius = size(laws, slider)
    outward = slider / row_owner(laws, np.where(radius > 0, radius, 1.0))
    step = (slider - anchor) / row_owner(laws, np.where(slips, moved, 1.0))
    cosine = _dot(laws, step, outward)
    D = k / np.maximum(share, 1e-12) + friction * cosine**2 / np.where(slips, moved, np.inf)
    across = np.where(slips, k - k**2 / D, k)
    held = _blocks(laws, outward, along=k * np.ones_like(across), across=across)
    return np.where(row_owner(laws, stopped)[..., :, None], held, result)
