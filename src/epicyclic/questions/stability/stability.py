"""Stability over speed with linear contact: Floquet multipliers, kinds of instability, combination resonances.

The period is the common one of all meshes that vary.  Where it has too many steps, each mesh frequency is judged alone.

Boundaries of parametric combination resonances are those of first-order averaging.  With
x_p = c_p(t) exp(i w_p t) + its conjugate, stiffness B k_l B^T exp(i l w t) of order l and D = Phi^T B k_l B^T Phi,
the slowly varying part of the equation is [hsu1963; lin2002a, lin2002b]

    w_p + w_q near l w:   c_p' = -s_p c_p + i D_pq / (4 w_p) conj(c_q)          sum type
    w_p - w_q near l w:   c_p' = -s_p c_p + i D_pq / (4 w_p) c_q                difference type

with decay rates s.  D being symmetric, the sum type grows with sqrt(b^2 - d^2/4) - s for equal s, where
b = |D_pq| / (4 sqrt(w_p w_q)) and d = l w - w_p - w_q; the difference type never does: its two couplings have opposite
signs.  Modes that lie close together, as the pairs of equal frequency of a symmetric train, are taken together, with
gyroscopic, centripetal and off-diagonal damping terms between them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import count
from math import gcd, lcm
from typing import Any, NamedTuple

import numpy as np
import scipy.optimize
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ...engine.run_folder import KeptPart, RunFolder
from ...engine.workers import each, import_results
from ...errors import ModelError
from ...results.dataset import largest
from ...statics.tangent import linear
from ...system.system import Array, ComplexArray, Index, System
from ...warning_codes import CodedText, coded
from ..modes.eigen import Modal, modal_form, modal_weights, repeated_roots
from ..response.response import FrameSpeed
from ..response.spectra import mesh_tones
from ..response.sweep_table import of_one_tone
from .floquet import STABLE, Floquet, floquet, multiplier_kind, steps_needed

# Modes closer than this part of their frequency are taken together: the width of the widest boundaries.
_CLOSE_FREQUENCY = 0.01
# Combinations looked into, the fastest first; points of a grid of mesh frequencies about one, at least.
_MOST, _GRID = 200, 61


def half_width(strength: float, *, first: float, second: float) -> float:
    """Detuning |l w - w_p - w_q| up to which the sum type grows [rad/s], 0 where damping keeps it closed [hsu1963].

    Unequal damping widens it: (s_p + s_q) sqrt(b^2 / (s_p s_q) - 1); open where b^2 > s_p s_q.

    Parameters
    ----------
    strength : b = |D_pq| / (4 sqrt(w_p w_q)) [1/s].  first, second : decay s_p, s_q of both modes [1/s].
    """
    if strength**2 <= first * second:
        return 0.0
    mean = (first + second) / 2
    # without any damping the two rates count as equal
    ratio = 1.0 if mean == 0 else first * second / mean**2
    return float(np.inf) if ratio == 0 else float(2 * np.sqrt(strength**2 / ratio - mean**2))


class Resonance(NamedTuple):
    """Two groups of close modes and one order of one mesh frequency that may couple them.

    first, second : indices of the modes, the same ones twice where a group meets itself.  order : l.
    tone_ratio : tone per tone of the first mesh.  stage : of the meshes that follow it.
    coupling : (p, q) complex D of the modes [1/s^2].  strength : its norm as b [1/s].
    damping_limit : sqrt(s_p s_q) of the least damped, what b has to exceed [1/s].
    """

    first: Index
    second: Index
    order: int
    tone_ratio: float
    stage: str
    coupling: ComplexArray
    strength: float
    damping_limit: float


class Combination(NamedTuple):
    """A range of speed in which w_p + w_q = l w makes the motion grow, to first order.

    first, second : modes that couple most, from 1 in the order of their frequencies.
    order : l.  stage : of the meshes that couple them.
    low, centre, high : mesh frequency of the first mesh [Hz].  growth : largest in it [1/s].
    threshold : factor of the variation of the stiffness at which it opens at `centre` [1].
    """

    first: int
    second: int
    order: int
    stage: str
    low: float
    centre: float
    high: float
    growth: float
    threshold: float


def resonances(system: System, modal: Modal, tones: tuple[float, ...]) -> list[Resonance]:
    """Every sum of two natural frequencies that some order of the stiffness couples, fastest growing first [hsu1963].

    Parameters
    ----------
    tones : (D,) mesh frequencies that meshes follow [Hz], that of the first mesh first.
    """
    omega = np.sqrt(modal.squared)
    elastic = np.flatnonzero(~modal.rigid)
    if not elastic.size:
        return []
    apart = np.diff(omega[elastic]) > _CLOSE_FREQUENCY * omega[elastic][1:]
    groups = np.split(elastic, np.flatnonzero(apart) + 1)
    rows = modal.gaps * modal_weights(modal.squared, modal.rigid)
    pairs: list[Resonance] = []
    followed = np.array([float(system.tones[i]) for i in system.meshes.tone])
    for tone in tones:
        meshes = np.flatnonzero(followed == tone)
        stage = system.meshes.stage[int(meshes[0])]
        for order in np.flatnonzero(np.any(system.meshes.variation[meshes] != 0, axis=0)) + 1:
            k = system.meshes.stiffness[meshes] * system.meshes.variation[meshes, order - 1]
            D = (rows[meshes].T * k) @ rows[meshes]
            for first, second, strength, limit in _coupled_groups(D, groups, omega, modal.damping / 2):
                pairs.append(
                    Resonance(
                        first=first,
                        second=second,
                        order=int(order),
                        tone_ratio=tone / tones[0],
                        stage=stage,
                        coupling=D[np.ix_(first, second)],
                        strength=strength,
                        damping_limit=limit,
                    )
                )
    return sorted(pairs, key=lambda pair: pair.damping_limit - pair.strength)


def _coupled_groups(
    D: ComplexArray, groups: list[Index], omega: Array, decay: Array
) -> Iterator[tuple[Index, Index, float, float]]:
    """Pairs of groups whose coupling exceeds their damping, with b and sqrt(s_p s_q) [1/s].

    D : (n, n) coupling of all modes [1/s^2].  omega, decay : (n,) [rad/s], [1/s].
    """
    modes, starts = np.concatenate(groups), np.cumsum([0, *(group.size for group in groups[:-1])])
    scaled = D[np.ix_(modes, modes)] / (4 * np.sqrt(np.outer(omega[modes], omega[modes])))
    squares = np.add.reduceat(np.add.reduceat(np.abs(scaled) ** 2, starts, axis=0), starts, axis=1)
    least = np.minimum.reduceat(decay[modes], starts)
    # 1e-12 of the frequency is rounding
    limit = np.maximum(np.sqrt(np.outer(least, least)), 1e-12 * omega[modes][starts])
    for i, j in np.argwhere(np.triu(np.sqrt(squares) > limit)):
        size = (groups[i].size, groups[j].size)
        block = scaled[starts[i] : starts[i] + size[0], starts[j] : starts[j] + size[1]]
        strength = float(np.linalg.norm(block, 2))
        if strength > limit[i, j]:
            yield groups[i], groups[j], strength, float(np.sqrt(least[i] * least[j]))


def combinations(
    system: System, modal: Modal, tones: tuple[float, ...], *, low: float, high: float, turning: bool = True
) -> list[Combination]:
    """Ranges of instability by averaging, between two mesh frequencies of the first mesh [Hz]; of the 200 fastest.

    Parameters
    ----------
    tones : as of `resonances`, at the operating speed.  turning : whether G, Kg, Cskew follow the speed.
    """
    omega = np.sqrt(modal.squared)
    near: list[Resonance] = []
    for resonance in resonances(system, modal, tones):
        # mesh frequency of the first mesh [Hz] at which the mean frequencies of the groups sum to the order
        total = float(omega[resonance.first].mean() + omega[resonance.second].mean())
        if low / 2 <= total / (2 * np.pi * resonance.order * resonance.tone_ratio) <= 2 * high:
            near.append(resonance)
    ranges: list[Combination] = []
    for resonance in near[:_MOST]:
        ranges += _unstable_ranges(_averaged_equations(modal, resonance, tones[0], turning), modal.squared)
    return sorted((each for each in ranges if each.high >= low and each.low <= high), key=lambda each: each.centre)


_GroupTerms = tuple[ComplexArray, ComplexArray, ComplexArray]
"""Averaged coefficients (p, p) within a group [1/s]: constant, linear and quadratic in the speed."""


@dataclass(frozen=True, slots=True, eq=False)
class _Averaged:
    """The averaged equations of one resonance; frequencies are those of the first mesh [rad/s].

    tone : at the operating speed [rad/s].  turning : whether G, Kg, Cskew follow the speed.
    mean_omega : mean frequency of each group [rad/s].  terms : within each group.
    coupling : (p, q) of each group on the other [1/s].
    """

    resonance: Resonance
    tone: float
    turning: bool
    mean_omega: tuple[float, float]
    terms: tuple[_GroupTerms, _GroupTerms]
    coupling: tuple[ComplexArray, ComplexArray]

    @property
    def centre(self) -> float:
        """Where the mean frequencies of the groups add up to the order [rad/s]."""
        return sum(self.mean_omega) / (self.resonance.order * self.resonance.tone_ratio)

    @property
    def width(self) -> float:
        """Half-width if all modes of a group had the same frequency [rad/s]."""
        first, second = (float(-constant.diagonal().real.max()) for constant, _, _ in self.terms)
        wide = half_width(self.resonance.strength, first=first, second=second)
        return (wide if np.isfinite(wide) else 20 * self.resonance.strength) / (
            self.resonance.order * self.resonance.tone_ratio
        )

    @property
    def reach(self) -> float:
        """How far from the centre anything can happen [rad/s]."""
        speed = self.speed(np.array([self.centre]))
        moved = 0.0
        for constant, first_order, second_order in self.terms:
            rest = constant - np.diag(constant.diagonal().real) + speed * first_order + speed**2 * second_order
            moved += float(np.abs(rest).sum(axis=1).max())
        return 1.2 * self.width + 2 * moved / (self.resonance.order * self.resonance.tone_ratio)

    def speed(self, mesh: Array) -> Array:
        """Relative speed of the frame terms at mesh frequencies (F,) [rad/s], (F,) [1]."""
        return mesh / self.tone if self.turning else np.ones_like(mesh)

    def matrix(self, mesh: Array) -> ComplexArray:
        """Matrices of the averaged equations at mesh frequencies (F,) [rad/s], (F, p + q, p + q) [1/s]."""
        half = (self.resonance.order * self.resonance.tone_ratio * mesh - sum(self.mean_omega))[:, None, None] / 2
        speed = self.speed(mesh)[:, None, None]
        first, second = (
            constant + speed * first_order + speed**2 * second_order - 1j * half * np.eye(len(constant))
            for constant, first_order, second_order in self.terms
        )
        p = first.shape[1]
        whole = np.empty((mesh.size, p + second.shape[1], p + second.shape[1]), complex)
        whole[:, :p, :p], whole[:, p:, p:] = first, second.conj()
        whole[:, :p, p:], whole[:, p:, :p] = self.coupling[0], self.coupling[1].conj()
        return whole

    def growth(self, mesh: Array) -> Array:
        """Largest growth rate at mesh frequencies (F,) [rad/s], (F,) [1/s]."""
        return np.asarray(np.linalg.eigvals(self.matrix(mesh)).real.max(axis=1))

    def growth_at(self, mesh: float) -> float:
        """Largest growth rate at one mesh frequency [rad/s], [1/s]."""
        return float(self.growth(np.array([mesh]))[0])


def _averaged_equations(modal: Modal, resonance: Resonance, tone: float, turning: bool) -> _Averaged:
    """The averaged equations of a resonance; tone : of the first mesh at the operating speed [Hz]."""
    omega, first, second = np.sqrt(modal.squared), resonance.first, resonance.second
    return _Averaged(
        resonance=resonance,
        tone=2 * np.pi * tone,
        turning=turning,
        mean_omega=(float(omega[first].mean()), float(omega[second].mean())),
        terms=(_group_terms(modal, first), _group_terms(modal, second)),
        coupling=(
            1j * resonance.coupling / (4 * omega[first, None]),
            1j * resonance.coupling.T / (4 * omega[second, None]),
        ),
    )


def _group_terms(modal: Modal, group: Index) -> _GroupTerms:
    """Averaged coefficients within a group (p,) of close modes."""
    omega, weight = np.sqrt(modal.squared)[group], modal_weights(modal.squared, modal.rigid)[group]
    rate, position = -omega / (2 * omega[:, None]), 1j / (2 * omega[:, None])

    def term(name: str) -> Array | float:
        """A frame or damping term within the group in mass-normalised coordinates, (p, p).

        0 where the train has none.
        """
        if name not in modal.coupling:
            return 0.0
        return modal.coupling[name].T[np.ix_(group, group)] * weight / weight[:, None]

    zero = np.zeros((group.size, group.size), complex)
    apart = 1j * (omega - omega.mean()) - modal.damping[group] / 2
    constant = np.diag(apart) + term("C") * rate
    return constant, zero + term("G") * rate + term("Cskew") * position, zero + term("Kg") * position


def _unstable_ranges(averaged: _Averaged, squared: Array) -> list[Combination]:
    """The ranges of mesh frequency in which a resonance grows."""
    reach, width, resonance = averaged.reach, averaged.width, averaged.resonance
    # the width spans several steps of the grid
    points = int(np.clip(16 * reach / width, _GRID, 10 * _GRID)) if width > 0 else _GRID
    mesh = averaged.centre + reach * np.linspace(-1, 1, points)
    mesh = mesh[mesh > 0]
    rates = averaged.growth(mesh)
    # rounding of an eigenvalue: without damping everything is at 0
    edge = 1e-9 * resonance.strength
    grows = np.concatenate([[False], rates > edge, [False]])
    starts, ends = np.flatnonzero(~grows[:-1] & grows[1:]), np.flatnonzero(grows[:-1] & ~grows[1:]) - 1
    first, second = _strongest_pair(resonance, squared)
    ranges = []
    for start, end in zip(starts, ends, strict=True):
        low = mesh[start] if start == 0 else _boundary(averaged, mesh[start - 1], mesh[start], edge)
        high = mesh[end] if end == mesh.size - 1 else _boundary(averaged, mesh[end], mesh[end + 1], edge)
        best = int(start) + int(np.argmax(rates[start : end + 1]))
        # to SciPy's default tolerance
        fastest = scipy.optimize.minimize_scalar(
            lambda frequency: -averaged.growth_at(frequency),
            bounds=(mesh[max(best - 1, 0)], mesh[min(best + 1, mesh.size - 1)]),
            method="bounded",
        ).x
        hertz = 2 * np.pi
        ranges.append(
            Combination(
                first=min(first, second) + 1,
                second=max(first, second) + 1,
                order=resonance.order,
                stage=resonance.stage,
                low=low / hertz,
                centre=float(fastest) / hertz,
                high=high / hertz,
                growth=averaged.growth_at(fastest),
                threshold=resonance.damping_limit / resonance.strength,
            )
        )
    return ranges


def _strongest_pair(resonance: Resonance, squared: Array) -> tuple[int, int]:
    """Indices of the modes that couple most, one of each group; of modes of one frequency the first stands for all.

    The norm over modes of one frequency does not hang on their basis.

    Parameters
    ----------
    squared : (n,) omega^2 of all modes [rad^2/s^2].
    """
    rows, columns = (repeated_roots(squared[group]) for group in (resonance.first, resonance.second))
    size = [[np.linalg.norm(resonance.coupling[row, column]) for column in columns] for row in rows]
    p, q = divmod(largest(size), len(columns))
    return int(resonance.first[rows[p].start]), int(resonance.second[columns[q].start])


def _boundary(averaged: _Averaged, low: float, high: float, edge: float) -> float:
    """Mesh frequency [rad/s] between two at which the growth rate is `edge` [1/s], to 1e-9 of it."""
    return float(scipy.optimize.brentq(lambda mesh: averaged.growth_at(mesh) - edge, low, high, xtol=1e-9 * high))


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


class FloquetScan(NamedTuple):
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
    rows = system.varying
    used = {rows.tones[i] for i, wave in zip(rows.tone, rows.wave, strict=True) if wave.any()} or {tones[0]}
    common = Fraction(gcd(*(t.numerator for t in used)), lcm(*(t.denominator for t in used)))
    orders = np.flatnonzero(np.any(rows.wave != 0, axis=0))
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
        if len(singles) > 1 or (singles and ready.system.passing is not None):
            points = [_point(single, frequency * float(single.tones[0] / ready.tones[0])) for single in singles]
            return replace(points[largest([point.growth for point in points])], alone=True)
        raise ModelError("a mesh cycle has too many steps of the highest mode: the speed is too low")
    solved = _floquet_at(ready, frequency, steps)
    if abs(abs(solved.largest) - 1) < _NEAR and 2 * steps <= _MOST_STEPS:
        steps *= 2
        solved = _floquet_at(ready, frequency, steps)
    size = abs(solved.largest)
    return _Point(
        multipliers=solved.multipliers,
        largest=size,
        growth=float(np.log(size) / period) if size > 0 else np.nan,
        kind=instability_kind(solved.multipliers[~solved.free]),
        steps=steps,
    )


def _each_alone(ready: ParametricSystem) -> list[ParametricSystem]:
    """The System with each mesh frequency that varies alone, other meshes and links that pass at their mean."""
    system, tone = ready.system, np.asarray(ready.system.meshes.tone)
    varying = np.unique(tone[system.meshes.variation.any(axis=1)])
    alone = {system.tones[i]: of_one_tone(system, system.tones[i], tone == i) for i in varying}
    own = len(system.meshes.name)
    modal = replace(ready.modal, gaps=ready.modal.gaps[:own], pulls=ready.modal.pulls[:own])
    return [
        replace(ready, system=single, modal=modal, tones=(f,), cycles=Fraction(1), fastest=1.0)
        for f, single in alone.items()
    ]


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
    """Stiffness of every varying row less its mean at equal steps of the common period, (v, steps) [N/m]."""
    rows, steps_done = ready.system.varying, np.arange(steps)
    # one turn in equal steps: a phase of many cycles is one of them, without the digits that whole turns would lose
    turn = 2 * np.pi / steps * steps_done
    turn = np.stack([np.cos(turn), -np.sin(turn)])
    change = np.zeros((len(rows.wave), steps))
    for place, tone in enumerate(rows.tones):
        followers = np.flatnonzero((np.asarray(rows.tone) == place) & rows.wave.any(axis=1))
        if not followers.size:
            continue
        # whole, for the period is one of all meshes that vary
        cycles = int(tone / ready.tones[0] * ready.cycles)
        waves = turn[:, np.outer(cycles * np.arange(1, ready.harmonics + 1), steps_done) % steps]
        varying = rows.wave[followers, : ready.harmonics]
        change[followers] = np.hstack([varying.real, varying.imag]) @ waves[:, : varying.shape[1]].reshape(-1, steps)
    return change


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
        tuple(map(float, mesh_tones(ready.system))),  # links that pass stand still in the housing: none of their own
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


def speed_columns(
    mesh_frequency: Array, ready: ParametricSystem, scan: FloquetScan, ranges: Sequence[Combination]
) -> dict[str, tuple[str, Any]]:
    """Variables over mesh frequency (P,) [Hz], of a scan and of a row of a map."""
    several = len(ready.tones) > 1
    names = [
        "" if kind in ("", "stable") else _combination_at(ranges, float(frequency), several)
        for frequency, kind in zip(mesh_frequency, scan.kind, strict=True)
    ]
    columns = {
        "largest_multiplier": scan.largest,
        "growth_rate": scan.growth,
        "stable": scan.kind == "stable",
        "instability": scan.kind,
        "taking_part": np.array(names, dtype=object),
        "period_steps": scan.steps,
        "status": scan.status,
    }
    return {name: ("speed", values) for name, values in columns.items()}


def _combination_at(ranges: Sequence[Combination], frequency: float, several: bool) -> str:
    """Name of the combination whose predicted range holds an unstable mesh frequency [Hz], the fastest.

    The ends of a range are known to first order: the next range counts up to half its width away; ``beyond first
    order`` without one.
    """
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


def _labelled(
    ready: ParametricSystem, frequency: Array, scan: FloquetScan, ranges: list[Combination], options: dict[str, Any]
) -> xr.Dataset:
    """The labelled result; frequency (P,) of the first mesh [Hz]."""
    from ...results.dataset import dataset

    several = len(ready.tones) > 1
    columns: dict[str, tuple[str, Any]] = {}
    for name in ("low", "centre", "high", "growth", "threshold", "first", "second", "order"):
        kind = np.int64 if name in ("first", "second", "order") else np.float64
        columns[f"resonance_{name}"] = "resonance", np.array([getattr(each, name) for each in ranges], dtype=kind)
    return dataset(
        {
            "floquet_multiplier": (("speed", "multiplier"), scan.multipliers),
            **speed_columns(frequency, ready, scan, ranges),
            "frequency": ("mode", np.sqrt(ready.modal.squared) / (2 * np.pi)),  # the combinations count them from 1
            **columns,
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
        warnings=[*ready.system.warnings, *scan_warnings([scan])],
        units={"speed": "1"},  # relative to the operating speed, not the rpm of `check`
    )


def scan_warnings(scans: Sequence[FloquetScan]) -> list[CodedText]:
    """Warnings of scans as of one: speeds without multipliers, and unstable speeds."""
    notes, speeds = list[CodedText](), sum(scan.status.size for scan in scans)
    failed = [str(status) for scan in scans for status in scan.status if status != "ok"]
    if failed:
        notes.append(coded("stability-unknown", f"{len(failed)} of {speeds} speeds have no multipliers: {failed[0]}"))
    if alone := sum(np.count_nonzero(scan.alone) for scan in scans):
        text = (
            f"{alone} of {speeds} speeds: the common period of all meshes is too long; each mesh frequency is judged "
            "alone, with the mean stiffness of all else, combinations of several are not"
        )
        notes.append(coded("stability-unknown", text))
    unstable = sum(kind not in ("", "stable") for scan in scans for kind in scan.kind)
    if unstable:
        notes.append(coded("motion-unstable", f"unstable at {unstable} of {speeds} speeds"))
    return notes
