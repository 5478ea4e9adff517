"""Numbers of a System that a parameter may change, side by side: their values, derivatives and weighted sums."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from typing import Any

import numpy as np

from ...errors import ModelError
from ...system.system import Array, ComplexArray, Line, System

__all__ = ["SystemNumbers", "combined", "is_nonzero", "mean_stiffness_change", "numbers", "with_lines"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SystemNumbers:
    """Values, or derivatives with respect to one parameter, of the arrays of a System without laws, in its units.

    M, C, G, K, Kg, Cskew : (n, n).  B : (n, m).  stiffness, damping : (m,).  variation : (m, L) complex.
    force : (n,).  zeta : ().  tones : (D,) [Hz].
    line_frequency : (R,) [Hz].  line_gap : (R, m) complex.  line_force : (R, 3, n) complex.
    """

    M: Array
    C: Array
    G: Array
    K: Array
    Kg: Array
    Cskew: Array
    B: Array
    stiffness: Array
    variation: ComplexArray
    damping: Array
    force: Array
    zeta: Array
    tones: Array
    line_frequency: Array
    line_gap: ComplexArray
    line_force: ComplexArray


def numbers(system: System) -> SystemNumbers:
    """Numbers of a System."""
    meshes, lines = system.meshes, system.lines
    n, m = meshes.B.shape
    return SystemNumbers(
        **{name: getattr(system, name) for name in ("M", "C", "G", "K", "Kg", "Cskew", "force")},
        B=meshes.B,
        stiffness=meshes.stiffness,
        variation=meshes.variation,
        damping=meshes.damping,
        zeta=np.array(system.zeta or 0.0),
        tones=np.array([float(tone) for tone in system.tones]),
        line_frequency=np.array([float(line.frequency) for line in lines]),
        line_gap=np.array([line.gap for line in lines], complex).reshape(-1, m),
        line_force=np.array([line.force for line in lines], complex).reshape(-1, 3, n),
    )


def combined(weights: Sequence[float], parts: Sequence[SystemNumbers]) -> SystemNumbers:
    """Weighted sum of several.

    Raises
    ------
    ModelError : they are not of one shape: something appeared, vanished or was renumbered between them.
    """
    first = parts[0]
    for name in (field.name for field in fields(SystemNumbers)):
        if len({getattr(part, name).shape for part in parts}) > 1:
            raise ModelError("moves, meshes or lines of excitation appear or vanish here: no derivative")

    def total(name: str) -> Any:
        return np.asarray(sum(weight * getattr(part, name) for weight, part in zip(weights, parts, strict=True)))

    return replace(first, **{field.name: total(field.name) for field in fields(SystemNumbers)})


def is_nonzero(change: SystemNumbers) -> bool:
    """Whether any number changes."""
    return any(bool(getattr(change, field.name).any()) for field in fields(SystemNumbers))


def mean_stiffness_change(system: System, change: SystemNumbers) -> Array:
    """Derivative of K + B k B^T, (n, n) [N/m per unit]."""
    B, k = system.meshes.B, system.meshes.stiffness
    mixed = (change.B * k) @ B.T
    result: Array = change.K + mixed + mixed.T + (B * change.stiffness) @ B.T
    return result


def with_lines(system: System, frequencies: Sequence[Fraction]) -> System:
    """The System with a line, empty where it has none, at each of the given frequencies [Hz]."""
    known = {line.frequency for line in system.lines}
    added = tuple(_empty(system, frequency) for frequency in frequencies if frequency not in known)
    if not added:
        return system
    return replace(system, lines=tuple(sorted((*system.lines, *added), key=lambda line: line.frequency)))


def _empty(system: System, frequency: Fraction) -> Line:
    """Line without errors and forces at a frequency [Hz]."""
    n, m = system.meshes.B.shape
    return Line(
        frequency=frequency,
        gap=np.zeros(m, complex),
        link_gap=np.zeros(len(system.links.name), complex),
        force=np.zeros((3, n), complex),
        group_gap=np.zeros(system.group_rows.shape[1], complex),
    )
