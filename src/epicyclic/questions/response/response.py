"""Linear steady response of a System at many speeds: blocks of speeds, harmonics added until the truncation is small.

Whether the mean system has a steady motion at a speed: centripetal terms may exceed the stiffness (derived here).
In the turning axes of a carrier a body of mass m loses s^2 m Omega^2 of its stiffness.  Where K + s^2 Kg is positive
definite the mean deflection is unique and nothing drives a vibration.  At the first speed where it is singular the mean
deflection has a pole, the critical speed of the whirling body; beyond it dampers that turn with the body drive it, and
only the eigenvalues tell whether others hold it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...errors import ConvergenceError
from ...statics.tangent import linear
from ...system.system import Array, Index, System
from ...warning_codes import CodedText, coded
from ..modes.eigen import Modal, eigen, modal_form, whirl
from .balance import Batch, Guess, HarmonicSolution, at_points, solve
from .lattice import Integers, Kernel, LineFrequencies, integer_frequencies, kernel, line_frequencies
from .spectra import LineExcitation, excitation, line_excitation

FrameSpeed = Literal["kinematic", "operating"]
Truncation = tuple[int, ...]
"""Truncation of the balance: harmonics of each tone, then the cross order of combinations."""

# Doubles in one batch of modal rows: small enough to stay in the cache with the operator's copies of it.
_BATCH = 60_000
# Truncation allowed per tolerance: the RMS of a force converges with its square, the waveform directly.
_TRUNCATION = 30.0
# Cross order |a_1| + .. + |a_D| of combinations of several tones: initial, step, and largest by the number of tones.
_CROSS, _STEP, _LAST = 10, 4, {2: 34, 3: 18}
# Further cross orders where the truncation at the last one would be refused: spur stages whose lowest modes lie at many
# times the lower mesh frequency need 42 to 50.  50 are 2600 points.  Uneven links that pass a body shift every mesh
# order by many turns, and need 74 where the mesh moves the ring at high orders.
_FURTHER, _PASSING = {2: 50, 3: 26}, {2: 98, 3: 26}
_REFUSED = 1e-4
MEAN_UNSTABLE, NO_SPEED = "mean system unstable", "speed is not a number above zero"
"""Status of a speed without a steady motion, and of what is no speed."""
# Growth per largest |mu| that is more than rounding of a double eigenvalue (1e-8).
_GROWTH = 1e-7
_FASTEST = 1e50


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Response:
    """A System ready to be solved at any speed.

    frame_speed : whether G and Kg follow the speed (``kinematic``) or stay (``operating``).
    lawful : the system with the laws of its gaps, of which `system` has the tangents.
    kernels, frequencies, line_frequencies_made : what a truncation needs, made on first use.
    """

    system: System
    lawful: System
    modal: Modal
    lines: LineExcitation
    frame_speed: FrameSpeed = "kinematic"
    kernels: dict[tuple[Truncation, bool], Kernel] = field(default_factory=dict)
    frequencies: dict[tuple[Truncation, bool], tuple[Array, Array]] = field(default_factory=dict)
    line_frequencies_made: dict[tuple[Truncation, bool, bool], LineFrequencies] = field(default_factory=dict)

    @property
    def omega(self) -> Array:
        """Angular mesh frequencies at the operating speed, (D,) [rad/s]."""
        return 2 * np.pi * np.array([float(tone) for tone in self.lines.tones])

    def frame_factor(self, speed: Array) -> Array:
        """Factor of G and Cskew at relative speeds (P,), squared of Kg, (P,) [1]."""
        return speed if self.frame_speed == "kinematic" else np.ones_like(speed)

    def kernel(self, truncation: Truncation, *, shifted: bool) -> Kernel:
        """Convolution matrices of a truncation; shifted : around shaft frequencies."""
        key = (truncation, shifted)
        if key not in self.kernels:
            *harmonics, cross = truncation
            axis = np.concatenate([self.lines.axis, self.lines.passing])
            self.kernels[key] = kernel(self.system.varying, axis, tuple(harmonics), cross, mirrored=not shifted)
        return self.kernels[key]

    def exact_frequencies(self, truncation: Truncation, *, shifted: bool) -> tuple[Integers, int]:
        """Frequency of every harmonic, kept ones first, at the operating speed: (S, J + T) whole multiples of 1/unit
        Hz.

        S = 1 of mesh orders; the unit is the same for mesh and shaft orders.
        """
        made = self.kernel(truncation, shifted=shifted)
        shafts = [shaft.frequency for shaft in self.lines.shaft]
        unit = math.lcm(*(f.denominator for f in (*self.lines.tones, *shafts)))
        points = np.concatenate([made.lattice.points, made.truncated])
        return integer_frequencies(points, self.lines.tones, shafts if shifted else [Fraction(0)], unit), unit

    def frequency(self, truncation: Truncation, *, shifted: bool) -> tuple[Array, Array]:
        """Angular frequency of every harmonic kept (S, J) and truncated (S, T) at the operating speed [rad/s].

        S = 1 of mesh orders.  Exact before the last rounding: a combination of frequency 0 is exactly 0.
        """
        key = (truncation, shifted)
        if key not in self.frequencies:
            steps, unit = self.exact_frequencies(truncation, shifted=shifted)
            J = len(self.kernel(truncation, shifted=shifted).lattice.points)
            omega = 2 * np.pi * (steps / unit).astype(float)
            self.frequencies[key] = omega[:, :J], omega[:, J:]
        return self.frequencies[key]

    def line_frequencies(self, truncation: Truncation, *, shafts: bool, truncated: bool) -> LineFrequencies:
        """Line frequencies of a truncation: of mesh orders, with `shafts` of shaft orders too.

        truncated : whether the truncated harmonics are among them.
        """
        key = (truncation, shafts, truncated)
        if key not in self.line_frequencies_made:
            harmonics, unit = [], 1
            for shifted in (False, True)[: 1 + shafts]:
                steps, unit = self.exact_frequencies(truncation, shifted=shifted)
                J = len(self.kernel(truncation, shifted=shifted).lattice.points)
                harmonics.append((steps if truncated else steps[:, :J]).ravel())
            self.line_frequencies_made[key] = line_frequencies(np.concatenate(harmonics), unit)
        return self.line_frequencies_made[key]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Block:
    """Solved speeds.

    index : (P,) position of each among the speeds asked for.  speed : (P,) relative.
    truncation : harmonics of each tone and cross order.  mesh : mesh orders.
    shaft : shaft orders, speeds outermost, None without lines.  residual : (P,) largest relative residual, truncation
        too.
    """

    index: Index
    speed: Array
    truncation: Truncation
    mesh: HarmonicSolution
    shaft: HarmonicSolution | None
    residual: Array

    @property
    def harmonics(self) -> int:
        """Most harmonics kept of any tone."""
        return max(self.truncation[:-1])

    @property
    def uncertainty(self) -> Array:
        """Bound of the relative error near resonances of light damping, (P,) [1]; 0 elsewhere."""
        if self.shaft is None:
            return self.mesh.uncertainty
        of_shafts: Array = self.shaft.uncertainty.reshape(self.speed.size, -1).max(axis=1)
        return np.maximum(self.mesh.uncertainty, of_shafts)


@lru_cache(maxsize=2)  # with its kernels, for the curve and for the resonances of one train
def response(system: System, *, frame_speed: FrameSpeed = "kinematic", asks_laws: bool = False) -> Response:
    """Prepare a System for its steady response; tangents stand for laws (`statics.tangent.linear`).

    Parameters
    ----------
    frame_speed : as of `Response`.
    asks_laws : as of `statics.tangent.linear`, for contact loss.

    Raises
    ------
    ModelError : no damping; no mesh frequency; torques that do not balance.
    """
    if asks_laws and system.passing is not None:  # its methods know the mesh frequencies alone
        system = replace(system, passing=None)
    mean = linear(system, asks_laws=asks_laws, floating=asks_laws)
    modal = modal_form(mean)
    lines = excitation(mean, modal)
    return Response(system=mean, lawful=system, modal=modal, lines=lines, frame_speed=frame_speed)


def respond(ready: Response, speed: Array, *, tolerance: float, shaft_orders: bool = True) -> Iterator[Block]:
    """Solve relative speeds (P,), in blocks as they come out.

    The harmonics of each tone start at the fewest that hold the excitation, the cross order of combinations at 10; each
    grows until the forces on the truncated harmonics, an exact residual, are below 30 x tolerance of the dynamic part.
    tolerance : relative residual of the harmonics kept [1].
    """
    for part in response_parts(ready, speed, shaft_orders=shaft_orders):
        yield from respond_part(ready, speed, part, tolerance=tolerance, shaft_orders=shaft_orders)


def response_parts(ready: Response, speed: Array, *, shaft_orders: bool = True) -> list[tuple[Index, Truncation]]:
    """The parts of relative speeds (P,) that are solved apart.

    A part is an index of speeds and their initial truncation; its solution is the same with and without the others.
    """
    ready.system.require_scaling(speed)
    first = np.tile(initial_truncation(ready), (speed.size, 1))
    return list(_chunks(ready, np.arange(speed.size), first, shaft_orders=shaft_orders))


def respond_part(
    ready: Response, speed: Array, part: tuple[Index, Truncation], *, tolerance: float, shaft_orders: bool = True
) -> Iterator[Block]:
    """Solve one of the `response_parts` of relative speeds (P,), in blocks as they come out; see `respond`."""
    limit = largest_truncation(ready, speed)
    beyond = (_FURTHER if ready.system.passing is None else _PASSING).get(len(ready.lines.tones), 0)
    waiting: list[tuple[Index, Truncation, Block | None]] = [(*part, None)]
    while waiting:
        index, truncation, before = waiting.pop(0)
        with np.errstate(all="ignore"):  # a point that overflows ends as not finite, beside the others
            first = block = _block(
                ready, index, speed[index], truncation=truncation, tolerance=tolerance, before=before
            )
            more = _further(block.mesh.truncation_residual, truncation, limit[index], tolerance, beyond, before)
            coarse = np.any(more, axis=1)
            if shaft_orders and ready.lines.shaft and not np.all(coarse):
                block, worst = _with_shaft(ready, _select(block, ~coarse), tolerance=tolerance)
                more[~coarse] = _further(worst, truncation, limit[block.index], tolerance, beyond)
                coarse = np.any(more, axis=1)
        done = ~coarse[_among(index, block.index)]
        if np.any(done):
            yield block if np.all(done) else _select(block, done)
        if np.any(coarse):
            again = _chunks(ready, index[coarse], (np.array(truncation) + more)[coarse], shaft_orders=shaft_orders)
            waiting[:0] = [(*chunk, _select(first, _among(index, chunk[0]))) for chunk in again]


def _among(index: Index, some: Index) -> NDArray[np.bool_]:
    """Which of the speeds `index` (P,) are among some of them, mostly all: (P,)."""
    return np.ones(index.size, bool) if some.size == index.size else np.isin(index, some)


def initial_truncation(ready: Response) -> Index:
    """Initial harmonics of each tone and cross order, (D + 1,)."""
    several = len(ready.lines.tones) > 1
    combined = _CROSS if several and ready.system.varying.wave.any() else 0
    harmonics = [max(12 if several else 8, highest) for highest in ready.lines.highest]
    return np.array([*harmonics, combined], dtype=np.int64)


def largest_truncation(ready: Response, speed: Array) -> Index:
    """Largest harmonics and cross order at relative speeds (P,), (P, D + 1).

    Four times what reaches beyond the highest mode, 1.7 f_highest / f_mesh harmonics.
    """
    start = initial_truncation(ready)
    highest = float(np.sqrt(ready.modal.squared.max(initial=0.0)))
    with np.errstate(all="ignore"):
        wanted = np.ceil(1.7 * highest / np.outer(np.abs(speed), ready.omega))
    rule = np.nan_to_num(np.clip(wanted, 8, 400), nan=8.0).astype(np.int64)
    last = _LAST.get(len(ready.lines.tones), _CROSS) if start[-1] else 0
    return np.hstack([4 * np.maximum(start[:-1], rule), np.full((speed.size, 1), last)])


def _further(
    residual: Array, truncation: Truncation, limit: Index, tolerance: float, beyond: int, before: Block | None = None
) -> Index:
    """Increment of harmonics and cross order, (P, D + 1): 0 where the truncation is small enough, or at its limit.

    The cross order waits for the harmonics.  Where it converges so slowly that its limit is not enough, it goes there
    at once.  It goes beyond where the truncation would be refused at it.

    residual : of the truncation, (P, D + 1) by kind [1].  limit : (P, D + 1).  beyond : largest cross order where it
    would be refused.  before : solution of the truncation before.
    """
    allowed, current = _TRUNCATION * tolerance, np.array(truncation)
    coarse = truncation_norm(residual) > allowed
    # the kinds that make it too large: those above their part of what is allowed
    of_kind = allowed / np.sqrt(current.size)
    excessive = (residual > of_kind) & coarse[:, None]
    step = np.tile(np.maximum(4, current // 2), (len(coarse), 1))
    step[:, -1] = _STEP
    if before is not None and (gone := truncation[-1] - before.truncation[-1]):
        combined = residual[:, -1]
        rate = combined / before.mesh.truncation_residual[:, -1]
        step[combined * rate ** ((limit[:, -1] - truncation[-1]) / gone) > of_kind, -1] = _LAST[2]
    more: Index = np.where(excessive, np.clip(limit - current, 0, step), 0)
    more[np.any(more[:, :-1], axis=1), -1] = 0
    tones = len(truncation) - 1
    refused = residual[:, -1] > max(_REFUSED, 100 * tolerance) / np.sqrt(tones + 1)
    stuck = refused & ~np.any(more, axis=1) & (truncation[-1] < (beyond if truncation[-1] else 0))
    more[stuck, -1] = 2 * _STEP
    return more


def _chunks(
    ready: Response, index: Index, truncation: Index, *, shaft_orders: bool
) -> Iterator[tuple[Index, Truncation]]:
    """Parts of the speeds `index` (P,) of one truncation (P, D + 1) each, so small that a batch stays in the cache."""
    lines = len(ready.lines.shaft) if shaft_orders else 0
    # one for all, mostly: unique rows take half a millisecond
    alike = bool(np.all(truncation == truncation[:1]))
    for values in truncation[:1] if alike else np.unique(truncation, axis=0):
        key = tuple(int(value) for value in values)
        same = index[(truncation == values).all(axis=1)]
        points = len(ready.kernel(key, shifted=False).lattice.points)
        rows = 2 * max(points, (2 * points - 1) * lines)
        size = max(1, _BATCH // (rows * ready.modal.squared.size))
        yield from ((part, key) for part in np.array_split(same, -(-same.size // size)))


def _block(
    ready: Response, index: Index, speed: Array, *, truncation: Truncation, tolerance: float, before: Block | None
) -> Block:
    """Mesh orders of relative speeds (P,), without shaft orders; before : solution with fewer harmonics."""
    guess = None
    if before is not None:
        points = ready.kernel(before.truncation, shifted=False).lattice.points.tolist()
        more = ready.kernel(truncation, shifted=False).lattice.points.tolist()
        column = {tuple(point): i for i, point in enumerate(more)}
        y = np.zeros((speed.size, 2, len(more), before.mesh.y.shape[3]))
        y[:, :, [column[tuple(point)] for point in points]] = before.mesh.y
        guess = y, before.mesh.scale
    mesh = _solve(ready, speed, truncation=truncation, tolerance=tolerance, shifted=False, guess=guess)
    residual = np.maximum(mesh.residual, truncation_norm(mesh.truncation_residual))
    return Block(index=index, speed=speed, truncation=truncation, mesh=mesh, shaft=None, residual=residual)


def _with_shaft(ready: Response, block: Block, *, tolerance: float) -> tuple[Block, Array]:
    """A block with its shaft orders solved, and the largest truncation residual of each speed, by kind (P, D + 1)."""
    P = block.speed.size
    shaft = _solve(ready, block.speed, truncation=block.truncation, tolerance=tolerance, shifted=True)
    residual = np.maximum(shaft.residual, truncation_norm(shaft.truncation_residual)).reshape(P, -1).max(axis=1)
    dropped = shaft.truncation_residual.reshape(P, -1, shaft.truncation_residual.shape[1]).max(axis=1)
    block = replace(block, shaft=shaft, residual=np.maximum(block.residual, residual))
    return block, np.maximum(block.mesh.truncation_residual, dropped)


def _solve(
    ready: Response,
    speed: Array,
    *,
    truncation: Truncation,
    tolerance: float,
    shifted: bool,
    guess: Guess | None = None,
) -> HarmonicSolution:
    """Solve mesh orders, or shaft orders (`shifted`), at relative speeds (P,)."""
    made = ready.kernel(truncation, shifted=shifted)
    error, force = line_excitation(ready.system, ready.lines, speed, made.lattice)
    # of every line (S, J) and (S, T), speeds outermost
    omega, truncated_omega = ready.frequency(truncation, shifted=shifted)
    count = speed.size * len(omega)
    rows = Batch(
        frequency=np.multiply.outer(speed, omega).reshape(count, omega.shape[1]),
        truncated_frequency=np.multiply.outer(speed, truncated_omega).reshape(count, truncated_omega.shape[1]),
        frame=np.repeat(ready.frame_factor(speed), len(omega)),
        error=error,
        force=force,
    )
    return solve(ready.system, ready.modal, made, rows, tolerance=tolerance, guess=guess)


def truncation_norm(truncation_residual: Array) -> Array:
    """Truncation residual over all kinds, (P, D + 1) -> (P,)."""
    return np.asarray(np.sqrt((truncation_residual**2).sum(axis=1)))


def _select(block: Block, keep: NDArray[np.bool_]) -> Block:
    """The speeds of a block marked in `keep` (P,)."""
    if keep.all():
        return block

    shaft = None if block.shaft is None else at_points(block.shaft, np.repeat(keep, len(block.shaft.y) // keep.size))
    return replace(
        block,
        index=block.index[keep],
        speed=block.speed[keep],
        mesh=at_points(block.mesh, keep),
        shaft=shaft,
        residual=block.residual[keep],
    )


def critical_speed(ready: Response) -> tuple[float, str]:
    """Least relative speed at which K + s^2 Kg is singular beside rigid motions, inf where none; and who moves most.

    Returns
    -------
    (relative speed [1], name of a coordinate, "" where there is none).
    """
    dofs, (shapes, centripetal) = ready.system.dofs, _centripetal(ready)
    if not centripetal.any():
        return math.inf, ""
    values, vectors = np.linalg.eigh(centripetal)
    if values[0] >= 0:
        return math.inf, ""
    motion = np.abs(dofs.radius * (shapes @ vectors[:, 0]))
    return float(1 / math.sqrt(-values[0])), dofs.names[int(np.argmax(motion))]


def _centripetal(ready: Response) -> tuple[Array, Array]:
    """Shapes (n, e) of the elastic modes, of unit strain energy, and their Kg per stiffness, (e, e) [1]."""
    shapes, Kg = ready.modal.shapes[:, ~ready.modal.rigid], ready.system.Kg
    return shapes, shapes.T @ ((Kg + Kg.T) / 2) @ shapes


def unstable_speeds(ready: Response, speed: Array) -> NDArray[np.bool_]:
    """Relative speeds (P,) at which a vibration of the mean system grows.

    Gyroscopic terms, all dampers and the speed of the frames count; the varying stiffness does not (`stability` has
    it).  Speeds below the critical one are not asked.
    """
    frame = ready.frame_factor(speed)
    grows = np.zeros(speed.size, dtype=bool)
    # no eigenvalue is above the Frobenius norm: most trains are far from their critical speed by that alone
    fastest = float(np.max(frame, initial=0.0))
    if fastest < _FASTEST and fastest**2 * np.linalg.norm(_centripetal(ready)[1]) < 1:
        return grows
    # the square of a frame speed overflows far above any train: the response then says that it is not finite
    fast = (frame >= critical_speed(ready)[0]) & (frame < _FASTEST)
    if not np.any(fast):
        return grows
    modes = eigen(ready.system)
    for value in np.unique(frame[fast]):
        mu = whirl(ready.system, relative_speed=float(value), damped=True, modes=modes).mu
        grows[frame == value] = np.max(mu.real, initial=0.0) > _GROWTH * np.max(np.abs(mu), initial=0.0)
    return grows


def require_stable_mean(ready: Response, speed: float) -> None:
    """Refuse a relative speed at which a vibration of the mean system grows.

    Raises
    ------
    ConvergenceError : no steady motion.
    """
    if unstable_speeds(ready, np.array([speed]))[0]:
        raise ConvergenceError(_no_steady_motion(ready, f"at {float(ready.lines.tone) * speed:.6g} Hz mesh frequency"))


def instability_warnings(ready: Response, unstable: Array) -> list[CodedText]:
    """Warning where the mean system is unstable, at relative speeds (U,)."""
    if not unstable.size:
        return []
    lowest = float(ready.lines.tone) * unstable.min()
    text = _no_steady_motion(ready, f"at {unstable.size} speeds from {lowest:.6g} Hz mesh frequency on")
    return [coded("no-steady-motion", f"{text}; the values there are nan")]


def _no_steady_motion(ready: Response, where: str) -> str:
    """Why there is no steady motion at some speeds."""
    critical, name = critical_speed(ready)
    return (
        f"no steady motion {where}: the mean system is unstable, since above {float(ready.lines.tone) * critical:.6g} "
        f"Hz the centripetal terms exceed the stiffness (first of {name})"
    )
