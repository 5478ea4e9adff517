"""Where a varying stiffness makes two modes feed each other: boundaries of instability by first-order averaging.

With x_p = c_p(t) exp(i w_p t) + its conjugate, stiffness B k_l B^T exp(i l w t) of order l and D = Phi^T B k_l B^T Phi,
the part of the equation that does not turn is [hsu1963; lin2002a, lin2002b]

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

from ...system.system import Array, ComplexArray, System
from ..modes.basis import Modal
from .state import weights

__all__ = ["Combination", "Resonance", "combinations", "growth", "half_width", "resonances"]

Index = NDArray[np.int64]
# Modes closer than this part of their frequency are taken together: the width of the widest boundaries.
_CLOSE = 0.01
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
    multiple : tone per tone of the first mesh.  stage : of the meshes that follow it.
    coupling : (p, q) complex D of the modes [1/s^2].  strength : its norm as b [1/s].
    quiet : sqrt(s_p s_q) of the least damped, what b has to exceed [1/s].
    """

    first: Index
    second: Index
    order: int
    multiple: float
    stage: str
    coupling: ComplexArray
    strength: float
    quiet: float


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


@dataclass(frozen=True, slots=True, eq=False)
class _Modes:
    """Elastic modes: number, w (e,), s (e,), and G, C, Kg, Cskew among all of them in mass-normalised coordinates."""

    number: Index
    omega: Array
    decay: Array
    terms: dict[str, Array]


def resonances(system: System, modal: Modal, tones: tuple[float, ...]) -> list[Resonance]:
    """Every sum of two natural frequencies that some order of the stiffness couples, fastest first.

    Parameters
    ----------
    tones : (D,) mesh frequencies that meshes follow [Hz], that of the first mesh first.
    """
    omega = np.sqrt(modal.squared)
    elastic = np.flatnonzero(~modal.rigid)
    groups = _close(omega, elastic)
    if not groups:
        return []
    rows = modal.gaps * weights(modal)
    found: list[Resonance] = []
    at = np.array([float(system.tones[i]) for i in system.meshes.tone])
    for tone in tones:
        mine = at == tone
        stage = system.meshes.stage[int(np.argmax(mine))]
        for order in np.flatnonzero(np.any(system.meshes.variation[mine] != 0, axis=0)) + 1:
            k = system.meshes.stiffness[mine] * system.meshes.variation[mine, order - 1]
            D = (rows[mine].T * k) @ rows[mine]
            for first, second, strength, quiet in _coupled(D, groups, omega, modal.damping / 2):
                found.append(
                    Resonance(
                        first=first,
                        second=second,
                        order=int(order),
                        multiple=tone / tones[0],
                        stage=stage,
                        coupling=D[np.ix_(first, second)],
                        strength=strength,
                        quiet=quiet,
                    )
                )
    return sorted(found, key=lambda one: one.quiet - one.strength)


def _close(omega: Array, elastic: Index) -> list[Index]:
    """Elastic modes in groups of close ones."""
    gaps = np.diff(omega[elastic]) > _CLOSE * omega[elastic][1:]
    return [group for group in np.split(elastic, np.flatnonzero(gaps) + 1) if group.size]


def _coupled(
    D: ComplexArray, groups: list[Index], omega: Array, decay: Array
) -> Iterator[tuple[Index, Index, float, float]]:
    """Pairs of groups whose coupling exceeds their damping, with b and sqrt(s_p s_q) [1/s]."""
    modes, starts = np.concatenate(groups), np.cumsum([0, *(group.size for group in groups[:-1])])
    scaled = D[np.ix_(modes, modes)] / (4 * np.sqrt(np.outer(omega[modes], omega[modes])))
    squares = np.add.reduceat(np.add.reduceat(np.abs(scaled) ** 2, starts, axis=0), starts, axis=1)
    least = np.minimum.reduceat(decay[modes], starts)
    # 1e-12 of the frequency is rounding
    quiet = np.maximum(np.sqrt(np.outer(least, least)), 1e-12 * omega[modes][starts])
    for i, j in np.argwhere(np.triu(np.sqrt(squares) > quiet)):
        size = (groups[i].size, groups[j].size)
        block = scaled[starts[i] : starts[i] + size[0], starts[j] : starts[j] + size[1]]
        strength = float(np.linalg.norm(block, 2))
        if strength > quiet[i, j]:
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
    near = [one for one in resonances(system, modal, tones) if low / 2 <= _met(one, omega) <= 2 * high][:_MOST]
    found: list[Combination] = []
    for one in near:
        found += _ranges(_averaged(modal, one, tones[0], turning))
    return sorted((part for part in found if part.high >= low and part.low <= high), key=lambda part: part.centre)


def _met(one: Resonance, omega: Array) -> float:
    """Mesh frequency of the first mesh [Hz] at which the mean frequencies of the groups add up to the order."""
    total = float(omega[one.first].mean() + omega[one.second].mean())
    return total / (2 * np.pi * one.order * one.multiple)


@dataclass(frozen=True, slots=True, eq=False)
class _Averaged:
    """The averaged equations of one resonance; frequencies are those of the first mesh [rad/s].

    tone : at the operating speed [rad/s].  turning : whether G, Kg, Cskew follow the speed.
    at : mean frequency of each group [rad/s].  still, once, twice : what turns slowly within each group, of no power of
    the speed, of its first and second (p, p) [1/s].  push : (p, q) of each group on the other [1/s].
    """

    one: Resonance
    tone: float
    turning: bool
    at: tuple[float, float]
    still: tuple[ComplexArray, ComplexArray]
    once: tuple[ComplexArray, ComplexArray]
    twice: tuple[ComplexArray, ComplexArray]
    push: tuple[ComplexArray, ComplexArray]

    @property
    def centre(self) -> float:
        """Where the mean frequencies of the groups add up to the order [rad/s]."""
        return sum(self.at) / (self.one.order * self.one.multiple)

    @property
    def width(self) -> float:
        """Half-width if all modes of a group had the same frequency [rad/s]."""
        first, second = (float(-still.diagonal().real.max()) for still in self.still)
        wide = half_width(self.one.strength, first=first, second=second)
        return (wide if np.isfinite(wide) else 20 * self.one.strength) / (self.one.order * self.one.multiple)

    @property
    def reach(self) -> float:
        """How far from the centre anything can happen [rad/s]."""
        speed = self.speed(np.array([self.centre]))
        moved = 0.0
        for still, once, twice in zip(self.still, self.once, self.twice, strict=True):
            rest = still - np.diag(still.diagonal().real) + speed * once + speed**2 * twice
            moved += float(np.abs(rest).sum(axis=1).max())
        return 1.2 * self.width + 2 * moved / (self.one.order * self.one.multiple)

    @property
    def points(self) -> int:
        """Points of a grid over the reach that the width spans several steps of."""
        return int(np.clip(16 * self.reach / self.width, _GRID, 10 * _GRID)) if self.width > 0 else _GRID

    def speed(self, mesh: Array) -> Array:
        """Relative speed that the frame terms see."""
        return mesh / self.tone if self.turning else np.ones_like(mesh)

    def matrix(self, mesh: Array) -> ComplexArray:
        """Matrices of the averaged equations at mesh frequencies (F,) [rad/s], (F, p + q, p + q) [1/s]."""
        half = (self.one.order * self.one.multiple * mesh - sum(self.at))[:, None, None] / 2
        speed = self.speed(mesh)[:, None, None]
        first, second = (
            still + speed * once + speed**2 * twice - 1j * half * np.eye(len(still))
            for still, once, twice in zip(self.still, self.once, self.twice, strict=True)
        )
        p = first.shape[1]
        whole = np.empty((mesh.size, p + second.shape[1], p + second.shape[1]), complex)
        whole[:, :p, :p], whole[:, p:, p:] = first, second.conj()
        whole[:, :p, p:], whole[:, p:, :p] = self.push[0], self.push[1].conj()
        return whole

    def growth(self, mesh: Array) -> Array:
        """Largest growth rate at mesh frequencies (F,) [rad/s], (F,) [1/s]."""
        rates: Array = np.linalg.eigvals(self.matrix(mesh)).real.max(axis=1)
        return rates


def _averaged(modal: Modal, one: Resonance, tone: float, turning: bool) -> _Averaged:
    """The averaged equations of a resonance; tone : of the first mesh at the operating speed [Hz]."""
    omega = np.sqrt(modal.squared)
    first, second = _own(modal, one.first), _own(modal, one.second)
    return _Averaged(
        one=one,
        tone=2 * np.pi * tone,
        turning=turning,
        at=(float(omega[one.first].mean()), float(omega[one.second].mean())),
        still=(first[0], second[0]),
        once=(first[1], second[1]),
        twice=(first[2], second[2]),
        push=(1j * one.coupling / (4 * omega[one.first, None]), 1j * one.coupling.T / (4 * omega[one.second, None])),
    )


def _own(modal: Modal, group: Index) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """What turns slowly within a group: of no power of the speed, of its first and its second, (p, p) [1/s]."""
    omega, weight = np.sqrt(modal.squared)[group], weights(modal)[group]
    rate, position = -omega / (2 * omega[:, None]), 1j / (2 * omega[:, None])

    def term(name: str) -> Array | float:
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


def _ranges(averaged: _Averaged) -> list[Combination]:
    """The ranges in which a resonance grows."""
    mesh = averaged.centre + averaged.reach * np.linspace(-1, 1, averaged.points)
    mesh = mesh[mesh > 0]
    rates = averaged.growth(mesh)
    # rounding of an eigenvalue: without damping everything is at 0
    edge = 1e-9 * averaged.one.strength
    grows = np.concatenate([[False], rates > edge, [False]])
    starts, ends = np.flatnonzero(~grows[:-1] & grows[1:]), np.flatnonzero(grows[:-1] & ~grows[1:]) - 1
    first, second = _leading(averaged.one)
    found = []
    for start, end in zip(starts, ends, strict=True):
        low = mesh[start] if start == 0 else _crossing(averaged, mesh[start - 1], mesh[start], edge)
        high = mesh[end] if end == mesh.size - 1 else _crossing(averaged, mesh[end], mesh[end + 1], edge)
        best = int(start) + int(np.argmax(rates[start : end + 1]))
        fastest = _fastest(averaged, mesh[max(best - 1, 0)], mesh[min(best + 1, mesh.size - 1)])
        hertz = 2 * np.pi
        found.append(
            Combination(
                first=min(first, second) + 1,
                second=max(first, second) + 1,
                order=averaged.one.order,
                stage=averaged.one.stage,
                low=low / hertz,
                centre=fastest / hertz,
                high=high / hertz,
                growth=float(averaged.growth(np.array([fastest]))[0]),
                threshold=averaged.one.quiet / averaged.one.strength,
            )
        )
    return found


def _leading(one: Resonance) -> tuple[int, int]:
    """Indices of the modes that couple most, one of each group."""
    p, q = np.unravel_index(np.argmax(np.abs(one.coupling)), one.coupling.shape)
    return int(one.first[p]), int(one.second[q])


def _crossing(averaged: _Averaged, one: float, other: float, edge: float) -> float:
    def above(mesh: float) -> float:
        return float(averaged.growth(np.array([mesh]))[0]) - edge

    return float(scipy.optimize.brentq(above, one, other, xtol=1e-9 * other))


def _fastest(averaged: _Averaged, one: float, other: float) -> float:
    found = scipy.optimize.minimize_scalar(
        lambda mesh: -float(averaged.growth(np.array([mesh]))[0]), bounds=(one, other), method="bounded"
    )
    return float(found.x)
