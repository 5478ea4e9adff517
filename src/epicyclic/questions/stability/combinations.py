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
from ..modes.basis import Modal, modal_weights
from ..modes.eigen import repeated_roots

Index = NDArray[np.int64]
# Modes closer than this part of their frequency are taken together: the width of the widest boundaries.
_CLOSE_FREQUENCY = 0.01
# Combinations looked into, the fastest first.
_MOST = 200
_GRID = 61


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
    groups = _close_groups(omega, elastic)
    if not groups:
        return []
    rows = modal.gaps * modal_weights(modal.squared, modal.rigid)
    found: list[Resonance] = []
    at = np.array([float(system.tones[i]) for i in system.meshes.tone])
    for tone in tones:
        mine = at == tone
        stage = system.meshes.stage[int(np.argmax(mine))]
        for order in np.flatnonzero(np.any(system.meshes.variation[mine] != 0, axis=0)) + 1:
            k = system.meshes.stiffness[mine] * system.meshes.variation[mine, order - 1]
            D = (rows[mine].T * k) @ rows[mine]
            for first, second, strength, limit in _coupled_groups(D, groups, omega, modal.damping / 2):
                found.append(
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
    return sorted(found, key=lambda one: one.damping_limit - one.strength)


def _close_groups(omega: Array, elastic: Index) -> list[Index]:
    """Elastic modes in groups of close ones; omega (n,) [rad/s], elastic (e,) their indices."""
    gaps = np.diff(omega[elastic]) > _CLOSE_FREQUENCY * omega[elastic][1:]
    return [group for group in np.split(elastic, np.flatnonzero(gaps) + 1) if group.size]


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
    near = [one for one in resonances(system, modal, tones) if low / 2 <= _centre_frequency(one, omega) <= 2 * high][
        :_MOST
    ]
    found: list[Combination] = []
    for one in near:
        found += _unstable_ranges(_averaged_equations(modal, one, tones[0], turning), modal.squared)
    return sorted((part for part in found if part.high >= low and part.low <= high), key=lambda part: part.centre)


def _centre_frequency(one: Resonance, omega: Array) -> float:
    """Mesh frequency of the first mesh [Hz] at which the mean frequencies of the groups, of omega (n,).

    Sum to the order.
    """
    total = float(omega[one.first].mean() + omega[one.second].mean())
    return total / (2 * np.pi * one.order * one.tone_ratio)


@dataclass(frozen=True, slots=True, eq=False)
class _Averaged:
    """The averaged equations of one resonance; frequencies are those of the first mesh [rad/s].

    tone : at the operating speed [rad/s].  turning : whether G, Kg, Cskew follow the speed.
    mean_omega : mean frequency of each group [rad/s].  constant, linear, quadratic : coefficients (p, p) within each
        group by power of the speed [1/s].  coupling : (p, q) of each group on the other [1/s].
    """

    resonance: Resonance
    tone: float
    turning: bool
    mean_omega: tuple[float, float]
    constant: tuple[ComplexArray, ComplexArray]
    linear: tuple[ComplexArray, ComplexArray]
    quadratic: tuple[ComplexArray, ComplexArray]
    coupling: tuple[ComplexArray, ComplexArray]

    @property
    def centre(self) -> float:
        """Where the mean frequencies of the groups add up to the order [rad/s]."""
        return sum(self.mean_omega) / (self.resonance.order * self.resonance.tone_ratio)

    @property
    def width(self) -> float:
        """Half-width if all modes of a group had the same frequency [rad/s]."""
        first, second = (float(-constant.diagonal().real.max()) for constant in self.constant)
        wide = half_width(self.resonance.strength, first=first, second=second)
        return (wide if np.isfinite(wide) else 20 * self.resonance.strength) / (
            self.resonance.order * self.resonance.tone_ratio
        )

    @property
    def reach(self) -> float:
        """How far from the centre anything can happen [rad/s]."""
        speed = self.speed(np.array([self.centre]))
        moved = 0.0
        for constant, linear, quadratic in zip(self.constant, self.linear, self.quadratic, strict=True):
            rest = constant - np.diag(constant.diagonal().real) + speed * linear + speed**2 * quadratic
            moved += float(np.abs(rest).sum(axis=1).max())
        return 1.2 * self.width + 2 * moved / (self.resonance.order * self.resonance.tone_ratio)

    @property
    def points(self) -> int:
        """Points of a grid over the reach that the width spans several steps of."""
        return int(np.clip(16 * self.reach / self.width, _GRID, 10 * _GRID)) if self.width > 0 else _GRID

    def speed(self, mesh: Array) -> Array:
        """Relative speed of the frame terms at mesh frequencies (F,) [rad/s], (F,) [1]."""
        return mesh / self.tone if self.turning else np.ones_like(mesh)

    def matrix(self, mesh: Array) -> ComplexArray:
        """Matrices of the averaged equations at mesh frequencies (F,) [rad/s], (F, p + q, p + q) [1/s]."""
        half = (self.resonance.order * self.resonance.tone_ratio * mesh - sum(self.mean_omega))[:, None, None] / 2
        speed = self.speed(mesh)[:, None, None]
        first, second = (
            constant + speed * linear + speed**2 * quadratic - 1j * half * np.eye(len(constant))
            for constant, linear, quadratic in zip(self.constant, self.linear, self.quadratic, strict=True)
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


def _averaged_equations(modal: Modal, one: Resonance, tone: float, turning: bool) -> _Averaged:
    """The averaged equations of a resonance; tone : of the first mesh at the operating speed [Hz]."""
    omega = np.sqrt(modal.squared)
    first, second = _group_terms(modal, one.first), _group_terms(modal, one.second)
    return _Averaged(
        resonance=one,
        tone=2 * np.pi * tone,
        turning=turning,
        mean_omega=(float(omega[one.first].mean()), float(omega[one.second].mean())),
        constant=(first[0], second[0]),
        linear=(first[1], second[1]),
        quadratic=(first[2], second[2]),
        coupling=(
            1j * one.coupling / (4 * omega[one.first, None]),
            1j * one.coupling.T / (4 * omega[one.second, None]),
        ),
    )


def _group_terms(modal: Modal, group: Index) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Averaged coefficients within a group (p,) by power of the speed.

    constant, linear, quadratic, (p, p) each [1/s].
    """
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
    return (
        np.diag(apart) + term("C") * rate,
        zero + term("G") * rate + term("Cskew") * position,
        zero + term("Kg") * position,
    )


def _unstable_ranges(averaged: _Averaged, squared: Array) -> list[Combination]:
    """The ranges of mesh frequency in which a resonance grows."""
    mesh = averaged.centre + averaged.reach * np.linspace(-1, 1, averaged.points)
    mesh = mesh[mesh > 0]
    rates = averaged.growth(mesh)
    # rounding of an eigenvalue: without damping everything is at 0
    edge = 1e-9 * averaged.resonance.strength
    grows = np.concatenate([[False], rates > edge, [False]])
    starts, ends = np.flatnonzero(~grows[:-1] & grows[1:]), np.flatnonzero(grows[:-1] & ~grows[1:]) - 1
    first, second = _strongest_pair(averaged.resonance, squared)
    found = []
    for start, end in zip(starts, ends, strict=True):
        low = mesh[start] if start == 0 else _boundary(averaged, mesh[start - 1], mesh[start], edge)
        high = mesh[end] if end == mesh.size - 1 else _boundary(averaged, mesh[end], mesh[end + 1], edge)
        best = int(start) + int(np.argmax(rates[start : end + 1]))
        fastest = _fastest_growth(averaged, mesh[max(best - 1, 0)], mesh[min(best + 1, mesh.size - 1)])
        hertz = 2 * np.pi
        found.append(
            Combination(
                first=min(first, second) + 1,
                second=max(first, second) + 1,
                order=averaged.resonance.order,
                stage=averaged.resonance.stage,
                low=low / hertz,
                centre=fastest / hertz,
                high=high / hertz,
                growth=float(averaged.growth(np.array([fastest]))[0]),
                threshold=averaged.resonance.damping_limit / averaged.resonance.strength,
            )
        )
    return found


def _strongest_pair(one: Resonance, squared: Array) -> tuple[int, int]:
    """Indices of the modes that couple most, one of each group; of modes of one frequency the first stands for all.

    The norm over modes of one frequency does not hang on their basis.

    Parameters
    ----------
    squared : (n,) omega^2 of all modes [rad^2/s^2].
    """
    rows, columns = (repeated_roots(squared[group]) for group in (one.first, one.second))
    size = [[np.linalg.norm(one.coupling[row, column]) for column in columns] for row in rows]
    p, q = divmod(largest(size), len(columns))
    return int(one.first[rows[p].start]), int(one.second[columns[q].start])


def _boundary(averaged: _Averaged, one: float, other: float, edge: float) -> float:
    """Mesh frequency [rad/s] between two at which the growth rate is `edge` [1/s], to 1e-9 of it."""

    def above(mesh: float) -> float:
        return float(averaged.growth(np.array([mesh]))[0]) - edge

    return float(scipy.optimize.brentq(above, one, other, xtol=1e-9 * other))


def _fastest_growth(averaged: _Averaged, one: float, other: float) -> float:
    """Mesh frequency [rad/s] of the largest growth rate between two.

    By bounded minimisation of SciPy's default tolerance.
    """
    found = scipy.optimize.minimize_scalar(
        lambda mesh: -float(averaged.growth(np.array([mesh]))[0]), bounds=(one, other), method="bounded"
    )
    return float(found.x)
