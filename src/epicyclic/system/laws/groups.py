"""Laws on groups of rows: play, rolling elements, splines with friction, each from one convex potential.

A group is the rows of one link (x and y of a bearing or spline, or one row) with the stretch delta (r,), rho = |delta|.
All laws but one are radial, force = f(rho) delta / rho with

    f(rho) = min(k rho, F_m) + C <rho - S_2>^n        S_1 = F_m / k,  S_2 = S_1 + clearance

Without friction (F_m = 0) that is play and then a power law; with friction it is a spline [dong2019, eq. 27]: elastic
up to the slip start S_1, sliding at F_m over the clearance, elastic again.  S_1 is derived: any other value makes the
force discontinuous.  C follows from k, the tangent stiffness at the given load F: k = n C^(1/n) F^((n - 1)/n).

The law with a memory (Coulomb) has a slider s in series with the spring, force = k (delta - s), and at each step
(derived here)

    s = argmin  k |delta - s|^2 / 2 + F_m |s - s_before|    over  |s| <= clearance

Along a first straight pull it equals the radial law; on reversal it sticks, where the radial law slides back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

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
_T = TypeVar("_T", bound=np.generic)

STATES = ("play", "stick", "slip", "stop")
# a slider within this share of the clearance is at the stop: rounding of its steps
_AT_STOP = 1e-12
# Newton steps or halvings until its angle there is found to rounding [rad]
_SEARCH, _ANGLE = 60, 1e-15


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """Law of one group of rows.

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
        """Name of the law in results."""
        if self.friction:
            return "coulomb spline" if self.memory else "holonomic spline"
        if self.exponent != 1.0:
            return "rolling elements with play" if self.clearance else "rolling elements"
        return "play" if self.clearance else "linear"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LawGroup:
    """Rows of one link that follow one law.

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

    def __repr__(self) -> str:
        """One line: name, law and number of rows."""
        return f"LawGroup({self.name!r}, {self.law.kind}, {len(self.rows)} rows, {self.law.stiffness:.4g} N/m)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Laws:
    """Laws of G groups over R rows as arrays: first (G,) row of each group, owner (R,) group of each row, and the
    numbers (G,) of `Law`."""

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
    def pair(self) -> NDArray[np.bool_]:
        """Whether a group has two rows (G,); else one."""
        two: NDArray[np.bool_] = np.diff(np.append(self.first, self.owner.size)) == 2
        return two

    @property
    def row_stiffness(self) -> Array:
        """k of every row, (R,) [N/m]."""
        return self.stiffness[self.owner]


def stacked(groups: Sequence[LawGroup]) -> Laws:
    """Laws of the groups as arrays, rows in order."""
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


def row_owner(laws: Laws, values: NDArray[_T]) -> NDArray[_T]:
    """Values of groups (..., G) at each row (..., R)."""
    result: NDArray[_T] = values[..., laws.owner]
    return result


def size(laws: Laws, rows: Array) -> Array:
    """Euclidean length (..., G) of the part of each group in rows (..., R), in their unit."""
    return np.sqrt(_dot(laws, rows, rows))


def radial_parts(laws: Laws, rho: Array) -> tuple[Array, Array]:
    """Force f (..., G) [N] and slope f' (..., G) [N/m] of the radial law at rho (..., G) [m]."""
    beyond = rho - (laws.slip_start + laws.clearance)
    pressed = np.maximum(beyond, 0.0)
    n = laws.exponent
    value = np.minimum(laws.stiffness * rho, laws.friction) + laws.coefficient * pressed**n
    slope = np.where(beyond >= 0, laws.coefficient * n * pressed ** (n - 1), 0.0)
    slope += np.where(rho < laws.slip_start, laws.stiffness, 0.0)
    return value, slope


def potential(laws: Laws, delta: Array, anchor: Array | None = None) -> Array:
    """Energy of each group (..., G) [J] at delta (..., R) [m]; with a memory that of one step from the slider `anchor`
    (..., R) [m]."""
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
    """Force along every row (..., R) [N], the gradient of the potential; delta, anchor : (..., R) [m]."""
    rho = size(laws, delta)
    value, slope = radial_parts(laws, rho)
    secant = np.where(rho > 0, value / np.where(rho > 0, rho, 1.0), slope)
    result: Array = row_owner(laws, secant) * delta
    if anchor is None or not laws.memory.any():
        return result
    spring = laws.row_stiffness * (delta - slide(laws, delta, anchor))
    return np.where(row_owner(laws, laws.memory), spring, result)


def tangent(laws: Laws, delta: Array, anchor: Array | None = None) -> Array:
    """Derivative of the force (..., R, R) [N/m], symmetric, block by block; delta, anchor : (..., R) [m]."""
    rho = size(laws, delta)
    value, slope = radial_parts(laws, rho)
    secant = np.where(rho > 0, value / np.where(rho > 0, rho, 1.0), slope)
    result = _blocks(laws, delta / row_owner(laws, np.where(rho > 0, rho, 1.0)), along=slope, across=secant)
    if anchor is None or not laws.memory.any():
        return result
    held = row_owner(laws, laws.memory)
    return np.where(held[:, None], _sliding_tangent(laws, delta, anchor), result)


def _blocks(laws: Laws, unit: Array, *, along: Array, across: Array) -> Array:
    """Blocks along n n' + across (1 - n n') (..., R, R) [N/m] for unit vectors n (..., R); along, across : (..., G)."""
    same = laws.owner[:, None] == laws.owner
    dyad = row_owner(laws, along - across)[..., :, None] * unit[..., :, None] * unit[..., None, :]
    result: Array = np.where(same, dyad, 0.0)
    rows = np.arange(laws.owner.size)
    result[..., rows, rows] += row_owner(laws, across)
    return result


def kinks(laws: Laws, delta: Array, step: Array, anchor: Array | None = None) -> Array:
    """Step lengths a (T, 5 G) [1] at which delta + a step crosses S_1 or S_2 of a group, or is nearest to its centre.

    delta, step, anchor : (T, R) [m].  nan or negative where it does not.  With a memory S_1 counts from the slider.
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
    """Both step lengths a (..., G) [1] with |delta + a step| = radius; delta, step : (..., R), radius : (G,) [m]."""
    square = size(laws, step) ** 2
    middle = -_dot(laws, delta, step) / square
    half = np.sqrt(middle**2 - (size(laws, delta) ** 2 - radius**2) / square)
    return middle - half, middle + half


def _dot(laws: Laws, a: Array, b: Array) -> Array:
    """Scalar products (..., G) of the parts of each group in a and b (..., R)."""
    return np.add.reduceat(a * b, laws.first, axis=-1) if laws.first.size else a[..., :0]


def state(laws: Laws, delta: Array, anchor: Array | None = None) -> NDArray[np.int64]:
    """State of each group (..., G), an index into `STATES`; delta, anchor : (..., R) [m].

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
    stopped = size(laws, slider) >= laws.clearance * (1 - _AT_STOP)
    return np.where(laws.memory, np.where(stopped, 3, np.where(moved, 2, 1)), found)


# the slider ----------------------------------------------------------------------------------------------------------


def slide(laws: Laws, delta: Array, anchor: Array) -> Array:
    """Slider of every group after a step to delta (..., R) from a slider at `anchor` (..., R), (..., R) [m]; 0 without
    a memory."""
    slider, _ = _slid(laws, delta, anchor)
    return np.where(row_owner(laws, laws.memory), slider, 0.0)


def _slid(laws: Laws, delta: Array, anchor: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Slider (..., R) [m], and whether it is at its stop (..., G).

    Away from the stop it is anchor + w <1 - S_1 / |w|> with w = delta - anchor.
    """
    pull = delta - anchor
    length = size(laws, pull)
    factor = np.where(length > laws.slip_start, 1.0 - laws.slip_start / np.where(length > 0, length, 1.0), 0.0)
    slider: Array = anchor + row_owner(laws, factor) * pull
    out = laws.memory & (size(laws, slider) > laws.clearance * (1 + _AT_STOP))
    if out.any():
        slider = np.where(row_owner(laws, out), _at_stop(laws, delta, anchor, out), slider)
    return slider, out


def _at_stop(laws: Laws, delta: Array, anchor: Array, out: NDArray[np.bool_]) -> Array:
    """Slider (..., R) [m] on the circle of the clearance, between the directions of delta and the anchor.

    Of a group of one row it is on the side of delta.  At the angle theta from delta and psi from the anchor the slope
    of the energy along the circle, k |delta| sin theta - F_m |anchor| sin psi / |slip|, is zero.  Safeguarded Newton
    steps on the whole array find it: the groups of all instants at once, in every step of a static history.
    """
    first, pair = laws.first, laws.pair
    second = first + pair
    dx, dy = delta[..., first], np.where(pair, delta[..., second], 0.0)
    px, py = anchor[..., first], np.where(pair, anchor[..., second], 0.0)
    reach, radius, c = np.hypot(dx, dy), np.hypot(px, py), laws.clearance
    cross = dx * py - dy * px
    side = np.where(cross < 0, -1.0, 1.0)
    end = np.where(out & pair, np.arctan2(np.abs(cross), dx * px + dy * py), 0.0)
    # a slider at the stop already and pressed on may be held there by friction
    stuck = (radius >= c * (1 - _AT_STOP)) & (reach * np.cos(end) >= c)
    stuck &= laws.stiffness * reach * np.sin(end) <= laws.friction
    low, high = np.where(stuck, end, 0.0), end
    theta = (low + high) / 2
    for _ in range(_SEARCH):
        psi = end - theta
        slip = np.sqrt(np.maximum((c - radius) ** 2 + 4 * c * radius * np.sin(psi / 2) ** 2, np.finfo(float).tiny))
        drag, lean = laws.friction * radius / slip, np.sin(psi)
        slope = laws.stiffness * reach * np.sin(theta) - drag * lean
        bend = laws.stiffness * reach * np.cos(theta) + drag * (np.cos(psi) - c * radius * (lean / slip) ** 2)
        low, high = np.where(slope < 0, theta, low), np.where(slope < 0, high, theta)
        trial = theta - slope / np.where(bend > 0, bend, 1.0)
        trial = np.where((bend > 0) & (trial >= low) & (trial <= high), trial, (low + high) / 2)
        change, theta = np.abs(trial - theta), trial
        if np.all(change <= _ANGLE):
            break
    along, across = c * np.cos(theta), side * c * np.sin(theta)
    unit = np.where(reach > 0, reach, 1.0)
    result = np.empty_like(delta)
    result[..., second] = (along * dy + across * dx) / unit
    result[..., first] = (along * dx - across * dy) / unit
    return result


def _sliding_tangent(laws: Laws, delta: Array, anchor: Array) -> Array:
    """Derivative (..., R, R) [N/m] of k (delta - s): k in stick, F_m / |delta - anchor| across the slip in slip.

    At the stop the slider moves along the circle only, by k / D of the motion of delta along it, with
    D = (k delta - F_m n) . s / |s|^2 + F_m (n . s / |s|)^2 / |s - anchor| and n the direction of the slip.
    """
    k, friction = laws.stiffness, laws.friction
    slider, stopped = _slid(laws, delta, anchor)
    moved, pull = size(laws, slider - anchor), size(laws, delta - anchor)
    slips = moved > 0
    unit = (delta - anchor) / row_owner(laws, np.where(pull > 0, pull, 1.0))
    free = np.where(slips, friction / np.where(pull > 0, pull, 1.0), k)
    result = _blocks(laws, unit, along=np.where(slips, 0.0, k), across=free)
    if not stopped.any():
        return result
    radius = size(laws, slider)
    outward = slider / row_owner(laws, np.where(radius > 0, radius, 1.0))
    step = (slider - anchor) / row_owner(laws, np.where(slips, moved, 1.0))
    cosine = _dot(laws, step, outward)
    D = (k * _dot(laws, delta, outward) - friction * cosine) / np.where(stopped, laws.clearance, 1.0)
    D += friction * cosine**2 / np.where(slips, moved, np.inf)
    across = np.where(slips & (D > 0), k - k**2 / np.where(D > 0, D, 1.0), k)
    held = _blocks(laws, outward, along=k * np.ones_like(across), across=across)
    return np.where(row_owner(laws, stopped)[..., :, None], held, result)
