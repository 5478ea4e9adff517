"""Gaps of the flanks of a System: every mesh row on its loaded flank, and on its far flank where backlash is finite.

One table of rows and one law a block of them.  The force along a row is f(delta) + c delta' where delta > touch, with
the gap delta = B^T q - e - opening.  A far flank is a row of its own, because its normal is not the opposite of the
loaded one, and is open by the backlash (docs/conventions.md).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..warning_codes import CodedText, coded
from .flank_laws import FlankAt, LawRows, LinearAt, LinearLaw
from .system import Array, ComplexArray, System

Number = TypeVar("Number", bound=np.inexact)
Rows = NDArray[np.int64] | slice
Values = NDArray[Any]

# Forces beyond the last one of a table by less than this part of it are not worth a word.
_NOTABLE = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Flanks:
    """F flanks: the loaded ones of the m mesh rows, then the far ones.

    B : (n, F).  mesh : (F,) mesh row of each.  tone : (F,) its mesh tone.  sense : (F,) +1 loaded, -1 far.
    opening : (F,) backlash of a far flank [m], else 0.  damping : (F,) acts where the flank presses [N s/m].
    linear : (F,) stiffness in the mean system [N/m]; 0 of a far flank.
    stiffness : (F,) and variation : (F, L) tangent at the operating load, as of `MeshRows`.
    laws : together they cover the F rows once.
    """

    B: Array
    mesh: NDArray[np.int64]
    tone: NDArray[np.int64]
    sense: Array
    opening: Array
    damping: Array
    linear: Array
    stiffness: Array
    variation: ComplexArray
    laws: tuple[LawRows, ...]

    def __repr__(self) -> str:
        """One line: number of rows and their laws."""
        return f"Flanks({len(self.mesh)} rows, {', '.join(repr(block.law) for block in self.laws)})"

    @property
    def parametric(self) -> bool:
        """Whether all laws are linear with parametric stiffness."""
        return all(isinstance(block.law, LinearLaw) for block in self.laws)

    @property
    def tangent(self) -> LinearLaw:
        """The linear law of all rows with the tangents at the operating load."""
        return LinearLaw(stiffness=self.stiffness, variation=self.variation, tone=self.tone)

    @property
    def end(self) -> Array:
        """Largest force (F,) [N] that the law of each row holds."""
        return self._gathered(lambda law: law.end)

    @property
    def stiffest(self) -> Array:
        """Bound of the tangents (F,) [N/m]."""
        return self._gathered(lambda law: law.stiffest)

    def at(self, phases: Array) -> FlanksAt:
        """Laws of all rows at phases (P, D) of the mesh tones [cycles]."""
        F = len(self.mesh)
        parts = tuple((block.law.at(phases), contiguous(block.rows)) for block in self.laws)
        return FlanksAt(parts=parts, count=F)

    def _gathered(self, value: Callable[[Any], Array]) -> Array:
        """Values (c,) of each law at their rows, (F,)."""
        result = np.zeros(len(self.mesh))
        for block in self.laws:
            result[block.rows] = value(block.law)
        return result


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlanksAt:
    """Laws of F rows at P phases, as of `flank_laws.FlankAt`.

    parts : a law and its rows each.
    """

    parts: tuple[tuple[FlankAt, Rows], ...]
    count: int

    @property
    def touch(self) -> Array:
        """Gap at which the force of each row begins (P, F) [m]."""
        return self._placed([law.touch for law, _ in self.parts])

    @property
    def kinks(self) -> Array:
        """Gaps at which the tangent jumps (P, F, K) [m], nan where a row has fewer than K."""
        kinks = [law.kinks for law, _ in self.parts]
        most = max((each.shape[2] for each in kinks), default=1)
        result = np.full((len(kinks[0]) if kinks else 0, self.count, most), np.nan)
        for each, (_, rows) in zip(kinks, self.parts, strict=True):
            result[:, rows, : each.shape[2]] = each
        return result

    def instants(self, chosen: Any) -> FlanksAt:
        """The same at the chosen ones of the P phases."""
        return FlanksAt(parts=tuple((law.instants(chosen), rows) for law, rows in self.parts), count=self.count)

    def rows(self, chosen: Any) -> FlanksAt:
        """The same of the chosen ones of the F rows, a slice or their numbers."""
        wanted = np.arange(self.count)[chosen]
        number = np.full(self.count, -1)
        number[wanted] = np.arange(wanted.size)
        parts = []
        for law, rows in self.parts:
            chosen_rows = number[rows]
            kept = np.flatnonzero(chosen_rows >= 0)
            if kept.size:
                parts.append((law.rows(contiguous(kept)), contiguous(chosen_rows[kept])))
        return FlanksAt(parts=tuple(parts), count=wanted.size)

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        """Force [N] and tangent [N/m] at gaps delta (..., P, F) [m]."""
        force, tangent = np.zeros_like(delta), np.zeros_like(delta)
        for law, rows in self.parts:
            force[..., rows], tangent[..., rows] = law.evaluate(delta[..., rows])
        return force, tangent

    def energy(self, delta: Array) -> Array:
        """Energy of each row (..., P, F) [J] at gaps delta [m]."""
        return self._placed([law.energy(delta[..., rows]) for law, rows in self.parts])

    def constant(self, low: Array, high: Array) -> NDArray[np.bool_]:
        """Whether each tangent keeps one value at every phase (F,) over the gaps low .. high (F,) [m]."""
        return self._placed([law.constant(low[rows], high[rows]) for law, rows in self.parts]).astype(bool)

    def _placed(self, values: Sequence[Values]) -> Values:
        """Values (..., c) of each part at their rows, (..., F)."""
        result = np.zeros((*(values[0].shape[:-1] if values else ()), self.count))
        for each, (_, rows) in zip(values, self.parts, strict=True):
            result[..., rows] = each
        return result


def linear_flanks(stiffness: Array) -> FlanksAt:
    """Flanks of stiffness (P, F) [N/m] at P phases."""
    F = stiffness.shape[1]
    return FlanksAt(parts=((LinearAt(stiffness=stiffness), slice(0, F)),), count=F)


def contiguous(chosen: NDArray[Any] | np.bool_) -> Rows:
    """Places chosen, or places (k,) in any order: a slice, which NumPy does not copy, where one follows the other."""
    rises = chosen.dtype == bool
    places: NDArray[np.int64] = np.flatnonzero(chosen) if rises else np.asarray(chosen)
    whole = places.size > 0 and places[-1] - places[0] + 1 == places.size and (rises or np.all(np.diff(places) == 1))
    return slice(int(places[0]), int(places[-1]) + 1) if whole else places


def flanks(system: System, *, far: bool = True) -> Flanks:
    """The flanks of a System.

    Parameters
    ----------
    far : whether far flanks come along, where backlash is finite.
    """
    meshes, behind = system.meshes, system.far_flanks
    of_far = behind.mesh if far else behind.mesh[:0]
    m, c = len(meshes.name), of_far.size
    stiffness = np.concatenate([meshes.stiffness, meshes.stiffness[of_far]])
    variation = np.concatenate([meshes.variation, behind.variation[:c]])
    tone = np.concatenate([meshes.tone, meshes.tone[of_far]]).astype(np.int64)
    laws = list(meshes.laws)
    if far:
        laws += [LawRows(law=block.law, rows=block.rows + m) for block in behind.laws]
    linear = np.ones(m + c, bool)
    for block in laws:
        linear[block.rows] = False
    if linear.any() or not laws:
        rows = np.flatnonzero(linear)
        law = LinearLaw(stiffness=stiffness[rows], variation=variation[rows], tone=tone[rows])
        laws.insert(0, LawRows(law=law, rows=rows))
    return Flanks(
        B=np.concatenate([meshes.B, behind.B[:, :c]], axis=1),
        mesh=np.concatenate([np.arange(m), of_far]),
        tone=tone,
        sense=np.concatenate([np.ones(m), -np.ones(c)]),
        opening=system.flank_opening[: m + c],
        damping=np.concatenate([meshes.damping, meshes.damping[of_far]]),
        linear=np.concatenate([meshes.stiffness, np.zeros(c)]),
        stiffness=stiffness,
        variation=variation,
        laws=tuple(laws),
    )


def net_force(force: NDArray[Number], far: NDArray[np.int64]) -> NDArray[Number]:
    """Force of every mesh row (..., m) [N], on its far flank negative, from those of flanks (..., m + c) [N].

    Parameters
    ----------
    far : (c,) mesh row of each far flank; no row has two.
    """
    m = force.shape[-1] - far.size
    net = force[..., :m].copy()
    net[..., far] = np.subtract(net[..., far], force[..., m:])
    return net


def past_the_end(system: System, rows: Flanks, largest: Array) -> list[CodedText]:
    """A warning for every pair whose forces pass the end of their table, by how much.

    Parameters
    ----------
    largest : (F,) largest force of every flank met [N].
    """
    ratio = largest / rows.end
    worst: dict[str, tuple[float, float]] = {}
    for row in np.flatnonzero(ratio > 1 + _NOTABLE).tolist():
        pair = system.meshes.pair[int(rows.mesh[row])]
        worst[pair] = max(worst.get(pair, (0.0, 0.0)), (float(ratio[row]), float(rows.end[row])))
    return [_exceeded(pair, ratio, end, "N a row") for pair, (ratio, end) in worst.items()]


def groups_past_the_end(system: System, largest: Array) -> Iterator[CodedText]:
    """A warning for every link whose forces pass the end of its table, by how much.

    Parameters
    ----------
    largest : (G,) largest force of every group met [N, N m].
    """
    for group, force in zip(system.groups, largest.tolist(), strict=True):
        end = group.law.end
        if force > (1 + _NOTABLE) * end:
            unit = "N m" if group.rows[0].endswith(("/rx", "/ry", "/rz")) else "N"
            yield _exceeded(group.name, force / end, end, unit)


def _exceeded(name: str, ratio: float, end: float, unit: str) -> CodedText:
    return coded(
        "table-exceeded",
        f"{name}: forces reach {ratio:.4g} times the last force of its table, {end:.4g} {unit}; behind it the law "
        "goes on along its last tangent",
    )
