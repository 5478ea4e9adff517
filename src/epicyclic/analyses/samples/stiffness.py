"""Samples of mesh and link stiffness, solved exactly in the gaps of the rows that vary instead of all coordinates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import ModelError
from ...system.system import Array, System, faces
from ..steady.balance import HarmonicSolution
from ..steady.gmres import gmres
from ..steady.measures import force_extremes, mean, mean_square
from ..steady.periodic import checked_speed
from ..steady.response import (
    Block,
    Response,
    Truncation,
    largest_truncation,
    respond,
    response,
    truncation_increment,
    truncation_norm,
)
from ..steady.waveform import Signal, Spectrum, force_spectrum, mesh_axis, whole_mesh_signal
from .errors import MEASURES, Measure
from .gap_map import GapMap, gap_map

__all__ = ["StiffnessSamples", "stiffness_samples"]

Index = NDArray[np.int64]
# Doubles of one batch of samples.
_BATCH = 60_000
# Vectors kept in single precision for all samples of a batch, and in double precision for those that are not done.
_FEW, _MANY = 24, 60
# Tolerance of the map per tolerance of a sample.
_FINER = 1e-2
# A residual above so many tolerances counts as not converged.
_ACCEPTED = 100.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StiffnessSamples:
    """Measures of S samples.

    mesh : (w,) names of the whole meshes.  values : (w, S) the measure [N], nan where a sample did not converge.
    residual : (S,) relative, truncation included.  harmonics : (S,) kept.
    """

    mesh: tuple[str, ...]
    values: Array
    residual: Array
    harmonics: Index


def stiffness_samples(
    system: System,
    mesh: ArrayLike | None = None,
    *,
    links: Sequence[str] = (),
    link: ArrayLike | None = None,
    relative_speed: float = 1.0,
    shaft_orders: bool = True,
    measure: Measure = "rms",
    tolerance: float = 1e-6,
) -> StiffnessSamples:
    """Measure of every mesh force for every sample of stiffness, linear contact.

    Dampers stay as they are: a modal ratio stands for the damping of the nominal train, not of each sample, whose own
    modes would shift it by half of what the stiffness shifts.

    Parameters
    ----------
    mesh : (S, w) factors on the stiffness of each whole mesh, k(t) as a whole; None: 1.
    links : links (``main/sun/support``) or single rows of them (``main/sun/support/x``) that vary.
    link : (S, l) factors on them.
    relative_speed : speed per operating speed, above zero.  shaft_orders : whether lines between mesh orders count.
    measure : as of `error_samples`.  tolerance : relative residual of every sample; the truncation stays below 30 times
        that.

    Raises
    ------
    ModelError : as of `response`; factors below zero or of another shape; no such link; an option out of range.
    """
    if measure not in MEASURES:
        raise ModelError("no such measure", path="measure", given=measure, allowed=", ".join(MEASURES))
    speed = np.array([checked_speed(relative_speed)])
    ready = response(system)
    rows, factors = _factors(ready.system, mesh, links, link)
    face, count = faces(ready.system.meshes), len(factors)
    values, residual = np.full((len(face.name), count), np.nan), np.full(count, np.nan)
    harmonics = np.zeros(count, np.int64)
    groups = (None, *range(len(ready.lines.shaft) if shaft_orders else 0))
    limit = largest_truncation(ready, speed)
    first = next(respond(ready, speed, tolerance=tolerance, shaft_orders=shaft_orders))
    waiting: list[tuple[Index, Truncation]] = [(np.arange(count), first.truncation)]
    while waiting:
        index, truncation = waiting.pop()
        maps = [gap_map(ready, truncation, speed[0], rows, shaft=s, tolerance=_FINER * tolerance) for s in groups]
        more = np.zeros((index.size, len(truncation)), np.int64)
        for part in _batches(index.size, maps):
            at, factor = index[part], factors[index[part]]
            with np.errstate(all="ignore"):  # a sample that overflows ends as nan, beside the others
                found = [_solve(each, factor, tolerance=tolerance) for each in maps]
                values[:, at] = _measured(ready, maps, truncation, speed[0], found, measure)
            worst = np.max([each.truncation_residual for each in found], axis=0)
            more[part] = truncation_increment(worst, truncation, np.repeat(limit, len(part), axis=0), tolerance)
            residual[at] = np.max(
                [np.maximum(each.residual, truncation_norm(each.truncation_residual)) for each in found], axis=0
            )
            harmonics[at] = max(truncation[:-1])
        coarse = more.any(axis=1)
        if coarse.any():
            waiting.append((index[coarse], tuple((np.array(truncation) + more.max(axis=0)).tolist())))
    values[:, ~(residual <= _ACCEPTED * tolerance)] = np.nan
    return StiffnessSamples(mesh=face.name, values=values, residual=residual, harmonics=harmonics)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _GapSolution:
    """Mesh gaps of P samples.

    gap : (m, P, 2 J) [m].  scaled_gap : the same times the stiffness factors.  residual : (P,) relative.
    truncation_residual : (P, D + 1).
    """

    gap: Array
    scaled_gap: Array
    residual: Array
    truncation_residual: Array


def _factors(
    system: System, mesh: ArrayLike | None, links: Sequence[str], link: ArrayLike | None
) -> tuple[Index, Array]:
    """Link rows that vary (l,), and factors on all meshes and these (S, m + l).

    Raises
    ------
    ModelError : as of `stiffness_samples`.
    """
    face = faces(system.meshes)
    row_sets = [_rows(system, name) for name in links]
    on_links = _checked_factors("link", link, len(links), None if mesh is None else len(np.asarray(mesh)))
    on_meshes = _checked_factors("mesh", mesh, len(face.name), len(on_links))
    rows = np.array([row for found in row_sets for row in found], np.int64)
    if len(set(rows.tolist())) < rows.size:
        raise ModelError("a row is named twice", path="links", given=", ".join(links))
    owner = np.repeat(np.arange(len(links)), [len(found) for found in row_sets])
    return rows, np.concatenate([on_meshes[:, face.row], on_links[:, owner]], axis=1)


def _rows(system: System, name: str) -> list[int]:
    """Rows of a link, or the one row of that name; those without stiffness do nothing.

    Raises
    ------
    ModelError : no such link.
    """
    own = [place for place, pair in enumerate(zip(system.links.name, system.links.link, strict=True)) if name in pair]
    if not own:
        known = ", ".join(dict.fromkeys(system.links.link))
        raise ModelError("no such link", path="links", given=name, allowed=known or "none: there are no links")
    return [row for row in own if system.links.stiffness[row] > 0]


def _checked_factors(path: str, given: ArrayLike | None, width: int, count: int | None) -> Array:
    """Factors (S, width), 1 where none are given.

    Raises
    ------
    ModelError : another shape, or a factor that is negative or not finite.
    """
    if given is None:
        return np.ones((1 if count is None else count, width))
    values = np.asarray(given, dtype=float)
    if values.ndim != 2 or values.shape[1] != width or (count is not None and len(values) != count):
        wanted = f"({'samples' if count is None else count}, {width})"
        raise ModelError("wrong shape", path=path, given=values.shape, allowed=wanted)
    if not (np.isfinite(values).all() and np.all(values >= 0)):
        raise ModelError("out of range", path=path, allowed="finite factors, 0 or more")
    return values


def _batches(count: int, maps: list[GapMap]) -> list[Index]:
    """Indices 0 .. count - 1 in parts that fit the cache."""
    size = max(1, _BATCH // max(each.nominal.size for each in maps))
    return np.array_split(np.arange(count), max(1, -(-count // size)))


def _solve(each: GapMap, factor: Array, *, tolerance: float) -> _GapSolution:
    """All P samples of a batch on one map; factor : (P, R)."""
    P, R = factor.shape
    change = np.repeat(factor - 1, each.nominal.size // R, axis=1)
    start = -(each.nominal * change) @ each.feedback
    scale = np.sqrt(each.dynamic**2 + np.einsum("pn,pn->p", start, start))
    scale[scale == 0] = 1.0
    step, left = _step(each.feedback, change, start, tolerance * scale)
    x = (each.nominal + step).reshape(P, R, -1)[:, : each.meshes]
    scaled_gap = x * factor[:, : each.meshes, None]
    truncation_residual = [
        np.linalg.norm(scaled_gap.reshape(P, -1) @ matrix, axis=1) / each.scale for matrix in each.truncated_basis
    ]
    weight = each.weight[: each.meshes, None, None]
    return _GapSolution(
        gap=x.swapaxes(0, 1) / weight,
        scaled_gap=scaled_gap.swapaxes(0, 1) / weight,
        residual=left / scale,
        truncation_residual=np.array(truncation_residual).T,
    )


def _step(feedback: Array, change: Array, right: Array, target: Array) -> tuple[Array, Array]:
    """Solve x + (x change) feedback = right for x (P, N), to |residual| <= target (P,); returns x and that residual
    (P,).

    change, right : (P, N).  Samples that need many iterations, near a resonance that the sample has moved, go on
        without
    the others, and in the end by elimination, which costs as much as N / 3 iterations.
    """
    half = np.float32  # takes half the time, and the residual below is not its own
    apply = _operator(feedback.astype(half), change.astype(half))
    size = np.maximum(np.linalg.norm(right, axis=1), np.finfo(half).tiny)[:, None]
    step32, *_ = gmres(apply, (right / size).astype(half), target=target / size[:, 0], basis=_FEW, restarts=1)
    step = size * step32
    rest = right - _operator(feedback, change)(step)
    left = np.linalg.norm(rest, axis=1)
    unconverged = np.flatnonzero(~(left <= target))
    if unconverged.size:
        apply, restarts = _operator(feedback, change[unconverged]), max(2, right.shape[1] // (3 * _MANY))
        more, left[unconverged], _ = gmres(
            apply, rest[unconverged], target=target[unconverged], basis=_MANY, restarts=restarts
        )
        step[unconverged] += more
    unit = np.eye(right.shape[1])
    for place in np.flatnonzero(~(left <= target)):
        matrix = unit + change[place][:, None] * feedback
        with suppress(np.linalg.LinAlgError):  # a singular one keeps the residual it has
            step[place] = np.linalg.solve(matrix.T, right[place])
            left[place] = np.linalg.norm(right[place] - step[place] @ matrix)
    return step, left


def _operator(feedback: Array, change: Array) -> Callable[[Array], Array]:
    """Operator x -> x + (x change) feedback of samples (P, N); feedback : (N, N)."""

    def apply(x: Array) -> Array:
        """x + (x change) feedback, (P, N)."""
        result: Array = x + (x * change) @ feedback
        return result

    return apply


def _measured(
    ready: Response,
    maps: list[GapMap],
    truncation: Truncation,
    speed: float,
    found: list[_GapSolution],
    measure: Measure,
) -> Array:
    """Measure of the whole meshes, (w, P) [N]; speed : relative."""
    block = _block(maps, truncation, speed, found)
    rows = Signal(
        orders=_force(ready, block, maps[:1], found[:1], shifted=False),
        lines=_force(ready, block, maps[1:], found[1:], shifted=True) if maps[1:] else None,
        line_frequencies=ready.line_frequencies(truncation, shafts=len(maps) > 1, truncated=True),
        cross=truncation[-1],
    )
    force = whole_mesh_signal(rows, faces(ready.system.meshes))
    if measure == "rms":
        rms: Array = np.sqrt(mean_square(force))
        return rms
    if measure == "mean":
        return mean(force)
    low, high = force_extremes(force, axis=mesh_axis(ready))
    return high if measure == "peak" else low


def _block(maps: list[GapMap], truncation: Truncation, speed: float, found: list[_GapSolution]) -> Block:
    """Samples as the speeds of a block, with the gaps at which nominal stiffnesses give the forces of the samples."""
    P = found[0].residual.size
    mesh, shaft = (_stacked(maps[part], found[part]) if maps[part] else None for part in (slice(1), slice(1, None)))
    if mesh is None:
        raise ValueError("no mesh orders were solved")
    return Block(
        index=np.arange(P),
        speed=np.full(P, speed),
        truncation=truncation,
        mesh=mesh,
        shaft=shaft,
        residual=found[0].residual,
    )


def _stacked(maps: list[GapMap], found: list[_GapSolution]) -> HarmonicSolution:
    """Shaft groups of every sample one after the other."""
    m, P, J2 = found[0].gap.shape
    return HarmonicSolution(
        y=np.zeros((P * len(found), 2, J2 // 2, 0)),
        gap=np.stack([each.scaled_gap for each in found], axis=2).reshape(m, -1, J2),
        frequency=np.tile([each.frequency for each in maps], (P, 1)),
        residual=np.stack([each.residual for each in found], axis=1).ravel(),
        truncation_residual=np.stack([each.truncation_residual for each in found], axis=1).reshape(P * len(found), -1),
        scale=np.tile([each.scale for each in maps], P),
        calls=0,
    )


def _force(ready: Response, block: Block, maps: list[GapMap], found: list[_GapSolution], *, shifted: bool) -> Spectrum:
    """Force spectra of the samples [N]: laws with their factors, dampers as they are."""
    meshes = ready.system.meshes
    bare = replace(ready, system=replace(ready.system, meshes=replace(meshes, damping=np.zeros(len(meshes.name)))))
    force = force_spectrum(bare, block, shifted=shifted)
    if meshes.damping.any():
        gap = np.stack([each.gap for each in found], axis=2)
        J = gap.shape[3] // 2
        rate = 1j * np.array([each.frequency for each in maps]) * (gap[..., :J] + 1j * gap[..., J:])
        force.amplitude[..., :J] += meshes.damping[:, None, None, None] * rate
    return force
