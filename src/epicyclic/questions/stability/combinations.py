"""Parametric combination resonances: boundaries of instability by first-order averaging.

With x_p = c_p(t) exp(i w_p t) + its conjugate, stiffness B k_l B^T exp(i l w t) of order l and D = Phi^T B k_l B^T Phi,
the slowly varying part of the equation is [hsu1963; lin2002a, lin2002b]

    w_p + w_q near l w:   c_p' = -s_p c_p + i D_pq / (4 w_p) conj(c_q)          sum type
    w_p - w_q near l w:   c_p' = -s_p c_p + i D_pq / (4 w_p) c_q                difference type

with decay rates s.  D being symmetric, the sum type grows with sqrt(b^2 - d^2/4) - s for equal s, where
b = |D_pq| / (4 sqrt(w_p w_q)) and d = l w - w_p - w_q; the difference type never does: its two couplings have opposite
signs.  Modes that lie close together, as the pairs of equal frequency of a symmetric train, are taken together, with
gyroscopic, centripetal and off-diagonal damping terms between them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from ...results.ties import largest
from ...system.system import Array, ComplexArray, System
from ..modes.eigen import Modal, modal_weights, repeated_roots

Index = NDArray[np.int64]
# Modes closer than this part of their frequency are taken together: the width of the widest boundaries.
_CLOSE_FREQUENCY = 0.01
# Combinations looked into, the fastest first; points of a grid of mesh frequencies about one, at least.
_MOST, _GRID = 200, 61


def growth(strength: float, *, detuning: float = 0.0, first: float, second: float) -> float:
    """Growth rate of the sum type of two modes [1/s], negative where it decays [hsu1963].

    Parameters
    ----------
    strength : b = |D_pq| / (4 sqrt(w_p w_q)) [1/s].  detuning : d = l w - w_p - w_q [rad/s].
    first, second : decay rates s_p, s_q = zeta w of the modes [1/s].
    """
    split = complex((first - second) / 2, detuning / 2)
    return float((np.sqrt(split**2 + strength**2)).real - (first + second) / 2)


def half_width(strength: float, *, first: float, second: float) -> float:
    """Detuning |l w - w_p - w_q| up to which the sum type grows [rad/s], 0 where damping keeps it closed [hsu1963].

    Unequal damping widens it: (s_p + s_q) sqrt(b^2 / (s_p s_q) - 1); open where b^2 > s_p s_q.

    Parameters
    ----------
    strength, first, second : as of `growth`.
    """
    if strength**2 <= first * second:
        return 0.0
    mean = (first + second) / 2
    # without any damping the two rates count as equal
    ratio = 1.0 if mean == 0 else first * second / mean**2
    return float(np.inf) if ratio == 0 else float(2 * np.sqrt(strength**2 / ratio - mean**2))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Resonance:
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Combination:
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
        meshes = followed == tone
        stage = system.meshes.stage[int(np.argmax(meshes))]
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
        for constant, linear, quadratic in self.terms:
            rest = constant - np.diag(constant.diagonal().real) + speed * linear + speed**2 * quadratic
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
            constant + speed * linear + speed**2 * quadratic - 1j * half * np.eye(len(constant))
            for constant, linear, quadratic in self.terms
        )
        p = first.shape[1]
        whole = np.empty((mesh.size, p + second.shape[1], p + second.shape[1]), complex)
        whole[:, :p, :p], whole[:, p:, p:] = first, second.conj()
        whole[:, :p, p:], whole[:, p:, :p] = self.coupling[0], self.coupling[1].conj()
        return whole

    def growth(self, mesh: Array) -> Array:
        """Largest growth rate at mesh frequencies (F,) [rad/s], (F,) [1/s]."""
        rates: Array = np.linalg.eigvals(self.matrix(mesh)).real.max(axis=1)
        return rates

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
        block: Array = modal.coupling[name].T[np.ix_(group, group)] * weight / weight[:, None]
        return block

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
