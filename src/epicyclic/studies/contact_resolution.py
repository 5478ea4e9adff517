"""Phases and slices of a loaded tooth contact, doubled until its printed numbers hold within a tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..teeth.contact_lines import corner_phases, graded_phases
from ..teeth.gear_pair import ContactPair, uniform_along_face
from ..teeth.loaded_contact import LoadedContact, all_loaded, all_segments
from ..train.bodies import Mesh

__all__ = [
    "PHASE_SHARE",
    "Resolution",
    "check_tolerance",
    "doubled",
    "estimated_error",
    "mesh_phases",
    "resolution",
    "sigma_at",
]

Array = NDArray[np.float64]

# First and most phases and slices.  The first are as coarse as the estimate of an error bears; the most bound the time
# of a mesh to a minute and its memory to a gigabyte.
_PHASES, _SLICES = (32, 1024), (10, 160)
# Fewest that are kept: a curve over the mesh cycle and a map of the flank are drawn through them.
_FEWEST = (64, 20)
PHASE_SHARE = 0.25
"""Share of the tolerance for the phases; that of the slices, which cost more, is the larger one."""
# Errors of a peak to peak are relative to it, or to this share of the deflection where that is larger: with a default
# tolerance a ten-thousandth of the deflection, which optimal reliefs come near and no tooth is known to.
_LEAST_SWING = 1e-2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Resolution:
    """Discretisation of a mesh.

    phase : (T,) of the mesh cycle.  samples : even ones among them.  slices : of each face.
    graded : whether the corners of contact are among the phases.
    error : (3,) estimated relative errors of the peak to peak of the transmission error (of a hundredth of the
        deflection where that is larger), largest load and largest pressure at the operating load, from what was not
        given; nan where nothing was estimated.
    """

    phase: Array
    samples: int
    slices: int
    graded: bool
    error: Array

    @property
    def even(self) -> NDArray[np.int64]:
        """Indices (S,) of the even phases."""
        wanted = np.arange(self.samples) / self.samples
        return np.asarray(np.abs(self.phase - wanted[:, None]).argmin(axis=1))


def check_tolerance(tolerance: float) -> None:
    """Refuse a tolerance that is no relative error.

    Raises
    ------
    ModelError : not above 0 and below 1.
    """
    if not 0 < tolerance < 1:
        raise ModelError("a relative error", path="tolerance", given=tolerance, allowed="above 0, below 1")


def sigma_at(mesh: Mesh, phase: Array, start: float = 0.0) -> Array:
    """Places sigma (T,) [base pitches] of one pair of teeth of a helix at phases (T,) of the mesh cycle.

    start : beginning of that cycle [mesh cycles], which is whole where it is 0; phases before it are of the next one.
    """
    whole = np.ceil(start - phase) if start else 0.0
    return np.asarray(mesh.sense * (phase + whole + float(mesh.lead)))


def mesh_phases(helices: Sequence[Mesh], pairs: Sequence[ContactPair], samples: int) -> Array:
    """Even phases of the mesh cycle and the corners of contact of every helix, (T,)."""
    corners = [
        mesh.sense * corner_phases(pair.plane) - float(mesh.lead) for mesh, pair in zip(helices, pairs, strict=True)
    ]
    return graded_phases(np.concatenate(corners), samples)


def resolution(
    helices: Sequence[Mesh],
    pairs: Sequence[ContactPair],
    force: float,
    *,
    tolerance: float,
    samples: int | None = None,
    slices: int | None = None,
    start: float = 0.0,
) -> Resolution:
    """Phases and slices with which the operating load is solved within a tolerance.

    Parameters
    ----------
    pairs : of the helices, of any number of slices.  force : of a helix [N].  tolerance : of each number [1].
    samples, slices : given ones, even phases; None: doubled until the tolerance holds, or to a limit.
    start : as of `sigma_at`.

    Raises
    ------
    ModelError : a tolerance that is not above zero.
    """
    check_tolerance(tolerance)

    def phases(count: int) -> Array:
        return mesh_phases(helices, pairs, count) if samples is None else np.arange(count) / count

    def numbers(count: int, cut: int) -> Array:
        return _numbers(helices, [replace(pair, slices=cut) for pair in pairs], force, phases(count), start)

    error = np.zeros(3)
    coarse = _FEWEST[1] if slices is None else slices
    chosen = samples
    if chosen is None:
        reached, missed = doubled(lambda count: numbers(count, coarse), _PHASES, PHASE_SHARE * tolerance)
        chosen, error = max(reached, _FEWEST[0]), error + missed
    cut = slices
    if cut is None and all(uniform_along_face(pair) for pair in pairs):
        cut = _FEWEST[1]  # one would do
    elif cut is None:
        fewest = _PHASES[0] if samples is None else samples
        share = (1 - PHASE_SHARE) * tolerance
        reached, missed = doubled(lambda count: numbers(fewest, count), _SLICES, share, checked=True)
        cut, error = max(reached, _FEWEST[1]), error + missed
    given = samples is not None and (slices is not None or all(uniform_along_face(pair) for pair in pairs))
    return Resolution(
        phase=phases(chosen),
        samples=chosen,
        slices=cut,
        graded=samples is None,
        error=np.full(3, np.nan) if given else error,
    )


def _numbers(helices: Sequence[Mesh], pairs: Sequence[ContactPair], force: float, phase: Array, start: float) -> Array:
    """Peak to peak of the transmission error [m], largest load [N/m] and pressure [Pa] under a force [N], and scales.

    Rows : the numbers, and what their errors are relative to, (2, 3); nan where a phase is not solved.
    """
    segments = all_segments(pairs, [sigma_at(mesh, phase, start) for mesh in helices])
    found = all_loaded(segments, [force], tangents=False)
    if any((one.status != "").any() for one in found):
        return np.full((2, 3), np.nan)
    swing, deflection = _swing(found)
    load = max(float(one.largest_load[0]) for one in found)
    pressure = max(float(one.largest_pressure[0]) for one in found)
    return np.array([[swing, load, pressure], [max(swing, _LEAST_SWING * deflection), load, pressure]])


def _swing(found: Sequence[LoadedContact]) -> tuple[float, float]:
    """Peak to peak and mean of the transmission error under load, helices together [m]."""
    error = np.mean([one.transmission_error[0] for one in found], axis=0)
    none = np.mean([one.no_load_error for one in found], axis=0)
    return float(np.ptp(error)), float(np.mean(error - none))


def doubled(
    numbers: Callable[[int], Array], limits: tuple[int, int], tolerance: float, *, checked: bool = False
) -> tuple[int, Array]:
    """Count, doubled until numbers hold, or to a limit, and the estimated errors (m,) of them [1].

    Where there are no numbers at a count, the one before it is kept: finer ones are no better, and cost more.

    Parameters
    ----------
    numbers : count -> the numbers, and what their errors are relative to, (2, m); nan where there are none.
    limits : first and most of counts.
    tolerance : of each number [1].
    checked : a first change that is small may be so by accident, where lead modifications end within a slice; the
    next count then has to confirm it.
    """
    count, found = limits[0], []
    found.append(numbers(count))
    error = np.full(found[0].shape[1], np.nan)
    while np.isfinite(found[-1]).all():
        following = numbers(2 * count)
        if not np.isfinite(following).all():
            break
        count *= 2
        found.append(following)
        error = estimated_error([one[0] for one in found]) / found[-1][1]
        if 2 * count > limits[1]:
            break
        if (error > tolerance).any():
            continue
        if not checked or len(found) > 2:
            return count, error
        following = numbers(2 * count)
        if not (np.abs(following[0] - found[-1][0]) / following[1] > tolerance).any():
            return count, error
    return count, error


def estimated_error(values: Sequence[Array]) -> Array:
    """Error (m,) of the last of values (m,) at counts doubled each time, in their unit.

    Changes that fall by a ratio r at every doubling leave the last change times r/(1 - r): of the ratio seen, but
    neither below the 1/4 of second order nor above the 1/2 of first order, which a first change is taken for.
    """
    last = np.abs(values[-1] - values[-2])
    if len(values) < 3:
        return last
    before = np.abs(values[-2] - values[-3])
    ratio = np.clip(last / np.where(before > 0, before, np.inf), 0.25, 0.5)
    ratio = np.where(before > 0, ratio, 0.5)
    return np.asarray(last * ratio / (1 - ratio))
