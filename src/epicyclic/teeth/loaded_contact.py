"""Loaded tooth contact analysis of one pair of gears on one helix, and of many micro-geometries of one pair at once.

    result = loaded_contact(pair, [10e3, 20e3], np.arange(50) / 50)
    result.transmission_error, result.tangent, result.mean_load

Forces and stiffnesses are along the tooth normal.  `tangent` is dF/dd at the load, `secant` is F/(d - d_0) from first
touch.

Helices that are mirror images of one another, in the plane normal to the axis, share one contact.  The two helices of a
herringbone gear with equal flanks lean to opposite sides.  Mirrored, the contact lines of one are those of the other at
every phase, and so are compliance, gaps and loads, from the other end of the face (derived here).

A table of a pair over the place of the contact and the load is its mesh stiffness.  `loaded_contact` yields the
approach d(F, sigma).  The linear model at an operating load F_0 has the tangent there,

    f = k(sigma) (d - e(sigma)),   k = dF/dd at F_0,   e = d(F_0, sigma) - F_0/k(sigma)

and so the exact loaded transmission error at F_0 (derived here).  The table holds d - e over all loads beside it.

Many micro-geometries of one pair have one compliance and many initial gaps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError
from . import gear_pair
from .contact_solver import ContactSolution, products, solve_hertzian, solve_linear, tangent_stiffness
from .gear_pair import ContactPair, Torsion
from .mesh_stiffness import DEFAULT_HARMONICS, ContactTable, error_samples, evaluate_series, table_series
from .path_of_contact import Array, Index, LineWindows, contact_lines, corner_reach, line_windows, tip_separation
from .segments import ContactSegments, contact_segments, initial_gap, microgeometry_gaps

# Loads of a table rise as squares, (i / _OPERATING)^2 times the operating load, which is one of them.
_STEPS, _OPERATING = 20, 12


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoadedContact:
    """Loaded contact of one pair: F loads, T phases, J pairs of teeth, K segments of the face.

    segments : the model that was solved.  load : (F, T) sum of the forces [N].  force : (F, T, J, K) normal to the
    tooth [N].  approach : (F, T) d along the normal [m].  no_load : (T,) d at first touch [m].
    tangent : (F, T) dF/dd [N/m].  residual : (F, T) of the contact conditions [1].  status : (F, T) "" where solved.
    corner : (F, 2) overlap of tip and flank before and behind the path of contact, largest over the cycle [m]; 0 where
        they stay apart or corner contact is solved.
    """

    segments: ContactSegments
    load: Array
    force: Array
    approach: Array
    no_load: Array
    tangent: Array
    residual: Array
    status: NDArray[np.object_]
    corner: Array

    @property
    def sigma(self) -> Array:
        """Places of the phases, (T,) [base pitches]."""
        return self.segments.sigma

    @property
    def transmission_error(self) -> Array:
        """Loaded transmission error in the transverse plane, lag of the driven gear positive, (F, T) [m]."""
        return self.approach / math.cos(self.segments.pair.plane.base_helix)

    @property
    def no_load_error(self) -> Array:
        """Transmission error of the unloaded flanks in the transverse plane, (T,) [m]."""
        return self.no_load / math.cos(self.segments.pair.plane.base_helix)

    @property
    def secant(self) -> Array:
        """Secant stiffness F/(d - d_0), (F, T) [N/m]; without load its limit, the tangent."""
        closed = self.approach - self.no_load
        return np.where(closed > 0, self.load / np.where(closed > 0, closed, 1.0), self.tangent)

    @property
    def share(self) -> Array:
        """Share of the load on each pair of teeth, (F, T, J) [1]; 0 without load."""
        whole = np.where(self.load > 0, self.load, 1.0)
        return np.asarray(self.force.sum(axis=3) / whole[:, :, None])

    @property
    def mean_load(self) -> Array:
        """Force per length of contact line, mean over a length about each segment, (F, T, J, K) [N/m].

        The mean over a stated length converges with the slices where a line begins at a corner of the flank.
        """
        return np.where(self.segments.lines.length > 0, self._windows.mean(self.force), 0.0)

    @property
    def mean_pressure(self) -> Array:
        """Largest contact pressure of `mean_load`, (F, T, J, K) [Pa] [weber1953]."""
        segments, windows = self.segments, self._windows
        plane = segments.pair.plane
        radius = plane.curvature_radius(np.clip(windows.sigma, *plane.limits))
        line = gear_pair.LineContact(A=segments.contact.A, B=np.zeros_like(radius), radius=radius)
        return gear_pair.pressure(line, self.mean_load)

    @property
    def largest_load(self) -> Array:
        """Largest of `mean_load` over the phases, (F,) [N/m]."""
        return np.asarray(self.mean_load.max(axis=(1, 2, 3)))

    @property
    def largest_pressure(self) -> Array:
        """Largest of `mean_pressure` over the phases, (F,) [Pa]."""
        return np.asarray(self.mean_pressure.max(axis=(1, 2, 3)))

    @property
    def _windows(self) -> LineWindows:
        return line_windows(self.segments.pair.plane, self.segments.lines)


def loaded_contact(pair: ContactPair, loads: ArrayLike, phases: ArrayLike) -> LoadedContact:
    """Loaded contact of a pair at given loads.

    Parameters
    ----------
    loads : (F,) or (F, T) forces normal to the tooth, 0 or more [N].  phases : (T,) places sigma of one pair of teeth
        at mid-face [base pitches]; the cycle of the flanks is 1.

    Raises
    ------
    ModelError : a pair that does not mesh (`check_pair`), a negative or infinite load.
    """
    return loaded_segments(contact_segments(pair, phases), loads)


def loaded_segments(segments: ContactSegments, loads: ArrayLike, *, tangents: bool = True) -> LoadedContact:
    """Loaded contact of given segments at loads (F,) or (F, T) [N], as `loaded_contact`.

    tangents : compute the tangent stiffness; else it is nan.
    """
    stated = np.atleast_1d(np.asarray(loads, dtype=float))
    wanted = np.broadcast_to(stated.reshape(len(stated), -1), (len(stated), len(segments.sigma)))
    if not (np.isfinite(wanted).all() and (wanted >= 0).all()):
        raise ModelError("a load on the teeth", path="loads", given=stated.tolist(), allowed="0 or more [N]")
    solutions: dict[int, ContactSolution] = {}
    solved: list[tuple[Array, Array]] = []
    model, phases = (segments.compliance, segments.gap, segments.valid), np.arange(len(segments.sigma))
    for i in np.argsort(wanted.max(axis=1), kind="stable").tolist():
        if segments.line is None:
            solutions[i] = solve_linear(*model, wanted[i])
            continue
        start = _extrapolated(solved, wanted[i])
        inverse = partial(segments.own_approach, phases=phases)
        solutions[i] = solve_hertzian(*model, wanted[i], segments.law, start=start, inverse=inverse)
        solved = [*solved[-1:], (wanted[i], _own_approach(segments, solutions[i]))] if (wanted[i] > 0).all() else []
    return _result(segments, [solutions[i] for i in range(len(wanted))], tangents)


def harmonics(values: Array, count: int) -> NDArray[np.complex128]:
    """One-sided complex amplitudes c_l (..., count + 1) of samples (..., T) over whole cycles, in the unit of these.

    values = Re sum_l c_l exp(2 pi i l sigma), l = 0 .. count; orders that the samples do not resolve are 0.
    """
    spectrum = np.fft.rfft(values, axis=-1) / values.shape[-1]
    amplitudes = np.zeros((*values.shape[:-1], count + 1), complex)
    most = min(count + 1, (values.shape[-1] + 1) // 2)
    amplitudes[..., :most] = spectrum[..., :most]
    amplitudes[..., 1:] *= 2
    return amplitudes


def _extrapolated(solved: list[tuple[Array, Array]], load: Array) -> Array | None:
    """Own approaches (T, n) [m] to start from at a load (T,) [N], from those at the one or two loads before.

    They are nearly linear in the load while no segment enters contact.
    """
    if not solved:
        return None
    last, own = solved[-1]
    if len(solved) < 2:
        return own
    first, before = solved[0]
    step = np.where(last > first, last - first, np.inf)
    return np.asarray(own + ((load - last) / step)[:, None] * (own - before))


def _own_approach(segments: ContactSegments, solution: ContactSolution) -> Array:
    """Approach of the line contacts themselves, (T, n) [m]."""
    shared = products(segments.compliance, np.arange(len(solution.force)), solution.force)
    return np.asarray(solution.approach[:, None] - segments.gap - shared)


def _result(segments: ContactSegments, solutions: list[ContactSolution], tangents: bool) -> LoadedContact:
    force = np.array([solution.force for solution in solutions])
    approach = np.array([solution.approach for solution in solutions])
    tangent = np.full(approach.shape, np.nan)  # dF/dd [N/m]
    for i, solution in enumerate(solutions if tangents else ()):
        slope = None
        if segments.line is not None:
            slope = segments.law(_own_approach(segments, solution), np.arange(len(solution.force)))[1]
        tangent[i] = tangent_stiffness(segments.compliance, solution.active, slope)
    return LoadedContact(
        segments=segments,
        load=force.sum(axis=2),
        force=segments.spread(force),
        approach=approach,
        no_load=segments.no_load,
        tangent=tangent,
        residual=np.array([solution.residual for solution in solutions]),
        status=np.array([solution.status for solution in solutions]),
        corner=_corner(segments, approach),
    )


def _corner(segments: ContactSegments, approach: Array) -> Array:
    """Overlap of tip and flank before and behind the path of contact, largest over the phases, (F, 2) [m]."""
    pair = segments.pair
    overlap = np.zeros((len(approach), 2))
    if pair.corner:
        return overlap
    plane = pair.plane
    most = max(float(np.nanmax(approach, initial=0.0) - segments.no_load.min()), 0.0)
    lines = contact_lines(plane, segments.sigma, pair.slices, beyond=corner_reach(plane, most))
    apart = initial_gap(pair, lines) + tip_separation(plane, lines.sigma)
    for side, there in enumerate((lines.sigma < plane.limits[0], lines.sigma > plane.limits[1])):
        nearest = np.where(there & (lines.length > 0), apart, np.inf).min(axis=(1, 2))
        overlap[:, side] = np.maximum(np.nanmax(approach - nearest, axis=1), 0.0)
    return overlap


# mirror images -------------------------------------------------------------------------------------------------------


def mirrored(pair: ContactPair) -> ContactPair:
    """Contact pair as a mirror normal to the axis shows it: left and right exchanged."""
    plane = pair.plane
    face_a, face_b = ((-right, -left) for left, right in (plane.face_a, plane.face_b))
    return replace(
        pair,
        plane=replace(plane, lean=-plane.lean, face_a=face_a, face_b=face_b),
        flank_a=replace(pair.flank_a, slope=-pair.flank_a.slope),
        flank_b=replace(pair.flank_b, slope=-pair.flank_b.slope),
        misalignment=-pair.misalignment,
        gap=tuple((-zeta, gap) for zeta, gap in reversed(pair.gap)),
        torsion_a=_mirrored_torsion(pair.torsion_a),
        torsion_b=_mirrored_torsion(pair.torsion_b),
    )


def first_images(pairs: Sequence[ContactPair], sigma: Sequence[Array]) -> list[int]:
    """Of every pair the number of the first one that it mirrors, at the same places sigma (T,), or its own number."""
    images: list[int] = []
    for i, pair in enumerate(pairs):
        image = mirrored(pair)
        near = (j for j in range(i) if np.array_equal(sigma[i], sigma[j]))
        # teeth are the same objects
        same = (j for j in near if all(getattr(image, f.name) == getattr(pairs[j], f.name) for f in fields(image)))
        images.append(next(same, i))
    return images


def all_segments(pairs: Sequence[ContactPair], sigma: Sequence[Array]) -> list[ContactSegments]:
    """`contact_segments` of every pair at its places sigma (T,) [base pitches]; mirror images share their compliance.

    Raises
    ------
    ModelError : as of `contact_segments`.
    """
    segments: list[ContactSegments] = []
    for i, first in enumerate(first_images(pairs, sigma)):
        pair = pairs[i]
        segments.append(contact_segments(pair, sigma[i]) if first == i else _mirrored_segments(segments[first], pair))
    return segments


def all_loaded(segments: Sequence[ContactSegments], loads: ArrayLike, *, tangents: bool) -> list[LoadedContact]:
    """`loaded_segments` of all segments at the same loads (F,) [N]; mirror images are solved once."""
    images = first_images([helix.pair for helix in segments], [helix.sigma for helix in segments])
    contacts: list[LoadedContact] = []
    for helix, first in zip(segments, images, strict=True):
        if first == len(contacts):
            contacts.append(loaded_segments(helix, loads, tangents=tangents))
        else:
            contacts.append(replace(contacts[first], segments=helix, force=contacts[first].force[..., ::-1]))
    return contacts


def _mirrored_torsion(torsion: Torsion | None) -> Torsion | None:
    return None if torsion is None else replace(torsion, end="right" if torsion.end == "left" else "left")


def _mirrored_segments(segments: ContactSegments, pair: ContactPair) -> ContactSegments:
    """Segments of a pair that is the mirror image of that of `segments`, each at the same place among the (T, n)."""
    lines = segments.lines
    tooth, place = np.divmod(segments.index, lines.length.shape[2])
    return replace(
        segments,
        pair=pair,
        lines=replace(
            lines,
            zeta=-lines.zeta[..., ::-1],
            sigma=lines.sigma[..., ::-1],
            length=lines.length[..., ::-1],
            centre=-lines.centre[::-1],
        ),
        index=tooth * lines.length.shape[2] + lines.length.shape[2] - 1 - place,
        zeta=-segments.zeta,
    )


# table over the load -------------------------------------------------------------------------------------------------


def contact_table(pair: ContactPair, load: float, *, samples: int = 50) -> ContactTable:
    """Tabulate the loaded contact of a pair around an operating load [N].

    samples : phases S of a mesh cycle.

    Raises
    ------
    ModelError : a load that is not positive, a phase without solution, and as of `loaded_contact`.
    """
    if not (load > 0 and math.isfinite(load)):
        raise ModelError("is no mesh force to take the stiffness at", given=load, allowed="above 0 N")
    sigma = np.arange(samples) / samples
    force = load * (np.arange(_STEPS + 1) / _OPERATING) ** 2
    contact = loaded_contact(pair, force[1:], sigma)
    if (contact.status != "").any():
        raise ModelError("tooth contact found no solution", given=str(contact.status[contact.status != ""][0]))
    tangent = contact.tangent
    mean, series = table_series(tangent[_OPERATING - 1])
    series = series[:DEFAULT_HARMONICS]
    linear = mean * evaluate_series(series, sigma)
    error = harmonics(contact.approach[_OPERATING - 1] - load / linear, DEFAULT_HARMONICS)
    gap = np.vstack([contact.no_load, contact.approach]).T - error_samples(error, samples)
    return ContactTable(
        load=load,
        stiffness=mean,
        variation=series,
        error=error,
        force=force,
        gap=gap,
        slope=_slopes(gap, force, tangent.T),
    )


def _slopes(gap: Array, force: Array, tangent: Array) -> Array:
    """Slopes dF/dd (S, L) [N/m] of a rising cubic through the table: the computed tangents, zero at first touch.

    gap : (S, L) [m].  force : (L,) [N].  tangent : (S, L - 1) [N/m].  A tangent above three times the secants beside it
    would make the cubic fall somewhere [fritsch1980].
    """
    secant = np.diff(force) / np.diff(gap, axis=1)
    slope = np.hstack([np.zeros((len(gap), 1)), tangent])
    slope[:, 1:] = np.minimum(slope[:, 1:], 3 * secant)
    slope[:, :-1] = np.minimum(slope[:, :-1], 3 * secant)
    return slope


# many micro-geometries -----------------------------------------------------------------------------------------------

# Most matrix entries solved at once; a larger batch is bound by memory.
_AT_ONCE = 4_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MicrogeometryContact:
    """Loaded contact of S micro-geometries at F loads and T phases.

    approach : (S, F, T) along the normal [m].  tangent : (S, F, T) dF/dd [N/m]; nan where not requested.
    largest_load : (S, F) force per length [N/m], means over a length as of `LoadedContact.largest_load`; nan where not
    requested.  residual : (S, F) of the contact conditions [1].  solved : (S, F) whether every phase converged.
    """

    approach: Array
    tangent: Array
    largest_load: Array
    residual: Array
    solved: NDArray[np.bool_]


def microgeometry_contact(
    segments: ContactSegments,
    pairs: Sequence[ContactPair],
    loads: ArrayLike,
    *,
    tangents: bool = False,
    largest: bool = True,
) -> MicrogeometryContact:
    """Loaded contact of pairs that differ in their initial gaps alone, at loads common to all.

    Parameters
    ----------
    segments : of one of them, by `contact_segments`.  pairs : (S,).
    loads : (F,) forces normal to the tooth, above 0 [N].  tangents : compute the tangent stiffness too.
    largest : compute the largest load per length too.

    Raises
    ------
    ModelError : micro-geometry that does not fit its flank.
    """
    force = np.sort(np.atleast_1d(np.asarray(loads, dtype=float)))
    order = np.argsort(np.argsort(np.atleast_1d(np.asarray(loads, dtype=float)), kind="stable"))
    T, n = segments.gap.shape
    gaps = microgeometry_gaps(segments, pairs)
    first = _spread_out(gaps, round(math.sqrt(len(gaps))))
    rest = np.setdiff1d(np.arange(len(gaps)), first)
    count = max(1, _AT_ONCE // (T * n * n))
    parts: list[MicrogeometryContact] = []
    heads: list[Array] = []
    for members in (first, rest):
        # own approaches (H, F, T, n) of the first, from the nearest of which the rest start; nan where not solved
        near = np.concatenate(heads) if heads else np.zeros((0, len(force), T, n))
        reached = np.flatnonzero(np.isfinite(near[:, 0, 0, 0]))
        for i in range(0, len(members), count):
            at = members[i : i + count]
            start: Array | None = None
            if reached.size:
                apart = np.array([_distance(gaps[at], gaps[k]) for k in first[reached]])
                start = near[reached[apart.argmin(axis=0)]]
            part, own = _solutions(segments, gaps[at], force, start, tangents, largest)
            parts.append(part)
            if members is first and segments.line is not None:
                whole = np.asarray(part.solved.all(axis=1))
                heads.append(np.where(whole[:, None, None, None], own, np.nan))
    back = np.argsort(np.concatenate([first, rest]), kind="stable")
    names = [field.name for field in fields(MicrogeometryContact)]
    joined = {name: np.concatenate([getattr(part, name) for part in parts])[back][:, order] for name in names}
    return MicrogeometryContact(**joined)


def _spread_out(gaps: Array, count: int) -> Index:
    """Indices (count,) of micro-geometries of gaps (S, T, n) [m], each the farthest from those before."""
    chosen = np.zeros(count, np.int64)
    nearest = np.full(len(gaps), np.inf)
    for k in range(1, count):
        nearest = np.minimum(nearest, _distance(gaps, gaps[chosen[k - 1]]))
        chosen[k] = np.argmax(nearest)
    return np.unique(chosen)


def _distance(gaps: Array, other: Array) -> Array:
    """Distance (S,) [m] of gaps (S, T, n) from others (T, n), beside a shift that is common to all."""
    return np.asarray((gaps - other).reshape(len(gaps), -1).std(axis=1))


def _solutions(
    segments: ContactSegments, gaps: Array, loads: Array, near: Array | None, tangents: bool, largest: bool
) -> tuple[MicrogeometryContact, Array]:
    """Contact of initial gaps (S, T, n) [m] at rising loads (F,) [N], and own approaches (S, F, T, n) [m].

    near : own approaches (S, F, T, n) [m] to start from.  tangents, largest : as of `microgeometry_contact`.  With a
    linear law there are no own approaches.
    """
    S, T, n = gaps.shape
    compliance = segments.compliance
    valid = np.broadcast_to(segments.valid, (S, T, n)).reshape(-1, n)
    gap, phase = gaps.reshape(-1, n), np.tile(np.arange(T), S)
    solutions: list[tuple[ContactSolution, Array, Array]] = []
    own: Array | None = None
    for place, load in enumerate(loads):
        tangent = np.full(S * T, np.nan)
        if segments.line is None:
            solution = solve_linear(compliance, gap, valid, np.full(S * T, load), phase=phase)
            tangent = tangent_stiffness(compliance, solution.active, phase=phase) if tangents else tangent
            solutions.append((solution, tangent, np.zeros((0, n))))
            continue
        solution = _hertzian(segments, gap, phase, load, own if near is None else near[:, place].reshape(-1, n))
        own = solution.approach[:, None] - gap - products(compliance, phase, solution.force)
        if tangents:
            tangent = tangent_stiffness(compliance, solution.active, segments.law(own, phase)[1], phase=phase)
        solutions.append((solution, tangent, own))

    def shaped(values: list[Array]) -> Array:
        return np.moveaxis(np.array(values).reshape(len(loads), S, -1), 0, 1)

    most = np.full((S, len(loads)), np.nan)
    if largest:
        windows = line_windows(segments.pair.plane, segments.lines)
        for place, (solution, _, _) in enumerate(solutions):
            spread = segments.spread(solution.force.reshape(S, T, n))
            most[:, place] = windows.mean(spread).max(axis=(1, 2, 3))
    part = MicrogeometryContact(
        approach=shaped([solution.approach for solution, _, _ in solutions]),
        tangent=shaped([tangent for _, tangent, _ in solutions]),
        largest_load=most,
        residual=shaped([solution.residual for solution, _, _ in solutions]).max(axis=2),
        solved=np.asarray(shaped([solution.status == "" for solution, _, _ in solutions]).all(axis=2)),
    )
    return part, shaped([own for _, _, own in solutions]).reshape(S, len(loads), -1, n)


def _hertzian(segments: ContactSegments, gap: Array, phase: Index, load: float, start: Array | None) -> ContactSolution:
    """Contact of initial gaps (t, n) [m] at phases (t,) under a load [N].

    start : own approaches (t, n) [m] of a near state.  Where Newton's method does not come from there to the solution,
    it starts from its own first estimate.
    """

    def solve(rows: Index, begin: Array | None) -> ContactSolution:
        at = phase[rows]
        return solve_hertzian(
            segments.compliance,
            gap[rows],
            segments.valid[at],
            np.full(len(rows), load),
            lambda u, index: segments.law(u, at[index]),
            start=begin,
            inverse=lambda force: segments.own_approach(force, at),
            phase=at,
        )

    solution = solve(np.arange(len(gap)), start)
    missed = np.flatnonzero(solution.status == "not converged")
    if start is None or not missed.size:
        return solution
    again = solve(missed, None)
    for name in solution.__dataclass_fields__:
        getattr(solution, name)[missed] = getattr(again, name)
    return solution
