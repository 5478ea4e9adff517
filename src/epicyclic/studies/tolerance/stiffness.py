"""Torques and stiffnesses that tolerances draw: what they change in a System, found by assembling it anew."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...document.tolerances import Tolerance
from ...errors import ModelError
from ...statics.load_map import at_mesh_order
from ...system.assembly import assemble
from ...system.system import System
from ...train.resolution import load

__all__ = ["Shift", "shift_of", "values_text"]

Array = NDArray[np.float64]

# Step of the value per its mean, and per its deviation where that is larger.
_STEP = 1e-2
# Relative difference that is rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shift:
    """What one number changes per unit of it, about its mean.

    mesh : (m,) stiffness of the mesh rows, link : (p,) of the links, force : (n,) torques, each per unit.
    """

    mean: float
    mesh: Array
    link: Array
    force: Array


def values_text(values: Sequence[float], unit: str) -> str:
    """Text of one number, or of a list with one per planet, as a model file has it."""
    text = repr(float(values[0])) if len(values) == 1 else f"[{', '.join(repr(float(value)) for value in values)}]"
    return f"{text} {unit}".strip()


def shift_of(
    document: Mapping[str, object], at_means: Mapping[str, object], entry: Tolerance, planet: int = 0
) -> Shift:
    """What the number of an entry changes, from three assemblies.

    Parameters
    ----------
    at_means : overrides with all such numbers at their mean, this one too.
    planet : whose number it is, from 0, of an entry with one per planet.

    Raises
    ------
    ModelError : it changes more than torques and stiffnesses, or those not in proportion.
    """
    mean = sum(float(one.mean.real) for one in (entry.own, entry.common) if one is not None)
    spread = max(one.std for one in (entry.own, entry.common) if one is not None)
    step = max(spread, _STEP * abs(mean)) or 1.0
    if 0 < abs(mean) < 2 * step:  # a stiffness stays above zero
        step = abs(mean) / 2

    def loaded(value: float) -> System:
        """The System with another value of that number."""
        numbers = [mean] * entry.count
        numbers[planet] = value
        train = load(document, {**at_means, entry.path: values_text(numbers, entry.unit)})
        # the gap of a table's tangent follows the load: that of the mean load stays
        return assemble(replace(train, mesh_errors=tuple(e for e in train.mesh_errors if e.cause != "contact")))

    base = loaded(mean)
    values = [_changes(entry.path, base, loaded(mean + part * step)) for part in (1.0, 0.5)]
    for whole, half in zip(*values, strict=True):
        if np.any(np.abs(whole - 2 * half) > _ROUNDING * (np.abs(whole).max(initial=0.0) + 1e-300)):
            raise ModelError(
                "torques or stiffnesses do not change in proportion to it",
                path=f"tolerance.{entry.path}",
                allowed="a torque, a stiffness of a mesh, a support, a bearing or a coupling",
            )
    if not any(part.any() for part in values[0]):
        raise ModelError(
            "it changes neither a torque nor a stiffness at rest",
            path=f"tolerance.{entry.path}",
            allowed="deviations, torques, stiffnesses of meshes, supports, bearings and couplings",
        )
    mesh, link, force = (part / step for part in values[0])
    return Shift(mean=mean, mesh=mesh, link=link, force=force)


def _changes(path: str, base: System, other: System) -> tuple[Array, Array, Array]:
    """Differences of mesh stiffness (m,), link stiffness (p,) and torques (n,); ModelError where others differ."""
    same = (
        base.links.name == other.links.name
        and base.meshes.name == other.meshes.name
        and base.tones == other.tones
        and _equal(base.meshes.B, other.meshes.B)
        and _equal(base.far_flanks.B, other.far_flanks.B)
        and _equal(base.links.B, other.links.B)
        and _equal(base.meshes.backlash, other.meshes.backlash)
        and _equal(base.M, other.M)
        and [(group.name, repr(group.law)) for group in base.groups] == [(g.name, repr(g.law)) for g in other.groups]
    )
    lines = [[line for line in one.lines if not at_mesh_order(one, line)] for one in (base, other)]
    same = same and [line.frequency for line in lines[0]] == [line.frequency for line in lines[1]]
    if same:
        mesh = other.meshes.stiffness - base.meshes.stiffness
        for part in base.meshes.laws:  # a tangent that follows the load: that of the mean load stays
            mesh[part.rows] = 0.0
        link = other.links.stiffness - base.links.stiffness
        L = base.links.B
        same = _equal(other.K - (L * link) @ L.T, base.K)
        for one, two in zip(*lines, strict=True):
            pulled = L @ (link * two.link_gap)
            same &= _equal(one.gap, two.gap) and _equal(one.link_gap, two.link_gap)
            same &= _equal(one.force[0], two.force[0] - pulled, np.abs(pulled).max(initial=0.0))
    if not same:
        raise ModelError(
            "it changes more than torques and stiffnesses",
            path=f"tolerance.{path}",
            allowed="deviations, torques, stiffnesses of meshes, supports, bearings and couplings",
        )
    return _cleaned(mesh, base.meshes.stiffness), _cleaned(link, base.links.stiffness), other.force - base.force


def _cleaned(change: Array, size: Array) -> Array:
    """Changes without those that are rounding of values of a size."""
    return np.where(np.abs(change) > 1e-12 * np.abs(size), change, 0.0)


def _equal(a: NDArray[Any], b: NDArray[Any], size: float = 0.0) -> bool:
    """Whether two arrays differ by rounding alone."""
    if a.shape != b.shape:
        return False
    finite = np.isfinite(a)
    if not np.array_equal(finite, np.isfinite(b)):
        return False
    largest = max(float(np.abs(a[finite]).max(initial=0.0)), size)
    return bool(np.all(np.abs(a[finite] - b[finite]) <= _ROUNDING * largest))
