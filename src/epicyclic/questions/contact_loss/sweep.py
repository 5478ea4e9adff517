"""Steady response over speed with teeth that part: run-up, coast-down and the whole branch set as one Dataset."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...engine.run_folder import RunFolder
from ...engine.workers import each, import_results, runs
from ...errors import ModelError
from ...machine_code import numba_available
from ...statics.signals import peaks_to_peaks
from ...system.gaps import past_the_end
from ...system.system import Array, System, faces
from ...warning_codes import CodedText, coded
from ..response import SweepOptions, Unstable
from ..response.response import MEAN_UNSTABLE, NO_SPEED, Response, instability_warnings, response, unstable_speeds
from ..response.spectra import link_labels
from ..response.sweep_table import ROWS, speeds_of
from .branch_set import BranchSet, Crossing, Measures, branch_set, force_level, periodic_measures
from .continuation import folds_of_speed
from .in_time import FOLLOWED, RATTLE, response_in_time, ripple_causes
from .rows import gap_rows_of, law_warnings, reported_links
from .shaft_orders import MeshOrders, ShaftResponse, link_outputs, mesh_orders, shaft_response
from .solutions import Refinement, Solution, Stability, distinct, require_fast_enough, with_stability
from .sweep_direction import Begin, IntegratedMotion, Reached, begin_of, resumed, sweep_direction
from .torus import TRUNCATION_NOTED, Torus, torus_of

_DIRECTIONS = ("up", "down")
# States of a point that holds numbers, or had lost them before shaft orders came.
_KNOWN = ("ok", "coarse", "not converged", FOLLOWED, RATTLE, NO_SPEED)

_Values = dict[str, Any]
"""Values at one speed of a direction by the names of their variables: arrays (w,) or (n,), numbers, texts."""
_Curves = dict[str, NDArray[Any]]
"""Curves (directions, .., P) over P speeds, by the names of their variables."""


def contact_sweep(
    system: System,
    options: SweepOptions,
    *,
    progress: Callable[[int, int], None] | None = None,
    kept: RunFolder | None = None,
) -> xr.Dataset:
    """RMS, extremes and amplitudes over speed as a slow run-up and a slow coast-down reach them, and all branches.

    What is reached is a motion of mesh orders; run-outs and other shaft lines come on top of it, at each speed.  The
    path and the folds are of mesh orders alone.

    Parameters
    ----------
    progress : called with (steps done, steps) once branches are followed: a step is a point reached, or its shaft
        orders; an exception in it ends the sweep.
    kept : keeps the branch set as it is followed, then stability, points reached and shaft orders as they come.

    Returns
    -------
    Dataset of docs/theory/contact-loss.md; a single speed that fails holds nan, and ``status`` says why.

    Raises
    ------
    ModelError : no damping, no or more than two mesh frequencies, torques out of balance, or an option out of range.
    """
    harmonics, unstable, kept = options.harmonics, options.unstable, kept or RunFolder()
    shaft_tones = 1 if options.shaft_tones is None else options.shaft_tones
    ready = response(system, frame_speed=options.frame_speed, asks_laws=True)
    if len(ready.lines.tones) > 2:
        raise ModelError(
            "contact loss is solved on the grid of all mesh phases",
            path="stages",
            given=f"{len(ready.lines.tones)} mesh frequencies",
            allowed="one or two",
        )
    speed = speeds_of(ready, options)
    if speed.ndim != 1 or not speed.size:
        raise ModelError("no speeds", path="mesh_frequency", given=list(speed.shape), allowed="one or more, in a row")
    usable = np.isfinite(speed) & (speed > 0)
    whirling = np.zeros(speed.size, dtype=bool)
    if gap_rows_of(ready).links is None:  # a body that the mean system loses may be held by the stop of its link
        whirling[usable] = unstable_speeds(ready, speed[usable])
    usable &= ~whirling
    if unstable != "ignore" and usable.any():
        require_fast_enough(ready, float(speed[usable].min()), "mesh_frequency")
    refinement, (rising, index) = Refinement(ready=ready), np.unique(speed[usable], return_inverse=True)
    shaft = torus_of(ready, most=shaft_tones) if options.shaft_orders and ready.lines.shaft else None
    nothing = _nothing(ready, shaft is not None)
    points = [[nothing] * rising.size for _ in _DIRECTIONS]
    branches = BranchSet(speeds=rising, segments=[], crossings=[], ended=[])
    largest: list[Array] = []
    if rising.size:
        kept.refer, kept.restore = refinement.size_of, lambda size: refinement.lattice(*size)
        branches = kept.made("branches", partial(branch_set, refinement, rising, harmonics=harmonics, kept=kept))
        if unstable != "ignore":
            _judge(refinement, branches, kept)
        largest = _fill_directions(refinement, branches, points, unstable, shaft, progress, kept)
    told = unstable != "ignore" and rising.size
    several = _several_motions(refinement, branches, _stacked(points)) if told else []
    # on the speeds asked for, nothing where those are none
    reached_at = np.full(speed.size, -1)
    reached_at[usable] = index
    lost = [nothing | ({"status": MEAN_UNSTABLE} if whirls else {}) for whirls in whirling]
    curves = _stacked(
        [[row[i] if i >= 0 else none for i, none in zip(reached_at.tolist(), lost, strict=True)] for row in points]
    )
    recorded = {
        "frame_speed": options.frame_speed,
        "contact_loss": True,
        "harmonics": harmonics,
        "unstable": unstable,
        "shaft_orders": options.shaft_orders,
        "shaft_tones": shaft_tones,
        **options.range_taken,
    }
    path = _path_curves(refinement, branches, unstable != "ignore")
    warnings = [*instability_warnings(ready, speed[whirling]), *_warnings(ready, curves, branches, largest), *several]
    variables = dict[str, tuple[tuple[str, ...], Any]]()
    for name, values in curves.items():
        row = ROWS.get(name, ("mesh",)) if values.ndim == 3 else ()
        variables[name] = (("direction", *row, "speed"), values)
    for name, values_along in path.items():
        along = "fold" if name == "fold_frequency" else "path"
        variables[name] = (("mesh", along) if values_along.ndim == 2 else (along,), values_along)
    from ...results.dataset import dataset

    return dataset(
        variables,
        {
            "direction": list(_DIRECTIONS),
            "mesh": list(faces(ready.system.meshes).name),
            "dof": list(ready.system.dofs.names),
            **link_labels(reported_links(ready)[0]),
            **({"shaft": list(ready.system.errors.shaft)} if ready.system.errors.shaft else {}),
            "speed": speed,
            "mesh_frequency": ("speed", speed * float(ready.lines.tone)),
        },
        verb="contact_sweep",
        options=recorded,
        provenance=ready.system.provenance,
        warnings=warnings,
        units={"speed": "1"},
    )


# --- the branch set, and what both directions reach -------------------------------------------------------------------


def _judge(refinement: Refinement, branches: BranchSet, kept: RunFolder) -> None:
    """Enter the stability of all solutions of the branch set, on several cores."""
    crossed = [crossing.solution for crossings in branches.crossings for crossing in crossings]
    followed = [at for segment in branches.segments for at in segment.solutions]
    every = {(at.state, at.backward): at for at in (*crossed, *followed)}
    work = partial(_stability, refinement, list(every.values()))
    judged = each(work, range(len(every)), kept=kept.part("stability"), meanwhile=_import_ahead)
    refinement.stability.update(zip(every, judged, strict=True))


def _import_ahead() -> None:
    """Import what the sweep directions and the result need."""
    import_results()
    if numba_available():
        from ..transient import compiled  # noqa: F401


def _stability(refinement: Refinement, solutions: list[Solution], index: int) -> Stability:
    """Stability of one of the solutions."""
    stability = with_stability(refinement, solutions[index]).stability
    assert stability is not None
    return stability


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Point:
    """What is reached at one speed: its index, the values of all curves, and forces (F,) as of `Measures`, if known.

    motion : on which shaft orders are still to come, else None.  begin : from where a direction can go on, else None.
    """

    index: int
    values: _Values
    flank: Array | None = None
    motion: MeshOrders | None = None
    begin: Begin | None = None


def _fill_directions(
    refinement: Refinement,
    branches: BranchSet,
    points: list[list[_Values]],
    unstable: Unstable,
    shaft: Torus | None,
    progress: Callable[[int, int], None] | None,
    kept: RunFolder,
) -> list[Array]:
    """Fill in the points (P) of both sweep directions; largest forces (F,) of the flanks of every motion [N].

    A motion that both directions reach is given its shaft orders once.
    """
    steps = 1 if shaft is None else 2
    total, done, largest = steps * 2 * len(branches.crossings), 0, list[Array]()
    waiting = dict[str, tuple[MeshOrders, list[tuple[int, int]]]]()

    def step(count: int) -> None:
        nonlocal done
        done += count
        if progress is not None:
            progress(done, total)

    def enter(direction: int, point: _Point) -> None:
        """Enter what a direction has reached at one speed."""
        points[direction][point.index] = point.values
        largest.extend([] if point.flank is None else [point.flank])
        if point.motion is not None:
            waiting.setdefault(point.motion.digest, (point.motion, []))[1].append((direction, point.index))
        step(steps if point.motion is None else 1)

    def enter_shaft_orders(number: int, solved: ShaftResponse) -> None:
        """Enter a motion with its shaft orders wherever it is reached."""
        for direction, index in reached[number]:
            points[direction][index] = points[direction][index] | _of_shaft_response(solved)
        largest.extend([] if solved.measures is None else [solved.measures.flank])
        step(len(reached[number]))

    def enter_new(number: int, point: _Point) -> None:
        """Enter a point that a direction has reached now, and keep it."""
        direction = left[number].direction
        if point.begin is not None:
            kept.keep_value(f"begin {_DIRECTIONS[direction]}", point.begin)
        kept.part(_DIRECTIONS[direction]).add(point.index, replace(point, begin=None))
        enter(direction, point)

    left = list[_Left]()
    for direction, name in enumerate(_DIRECTIONS):
        known = kept.part(name).known
        rest = _left(direction, len(branches.crossings), known, kept.value(f"begin {name}"))
        for index in sorted(known.keys() - set(rest.indices)):
            enter(direction, known[index])
        if rest.indices:
            left.append(rest)
    # the directions share nothing that one of them finds: each is a run of its own
    work = partial(_direction, refinement, branches, unstable, shaft is not None)
    # what replaces a motion that is unstable at a speed asked for takes seconds to find
    crossed = (crossing.solution for crossings in branches.crossings for crossing in crossings)
    long = unstable == "replace" and not all(with_stability(refinement, at).stable for at in crossed)
    runs(work, left, arrived=enter_new, long=long, kept=kept)
    motions, reached = [motion for motion, _ in waiting.values()], [indices for _, indices in waiting.values()]
    if shaft is not None:
        part = kept.part("shaft orders", list(waiting))
        each(partial(_shaft_response, shaft), motions, arrived=enter_shaft_orders, kept=part)
    return largest


def _shaft_response(shaft: Torus, motion: MeshOrders) -> ShaftResponse:
    """A motion with shaft orders; as a run in time has it where a ripple parts teeth and no torus is solved."""
    solved = shaft_response(shaft, motion)
    ripples = ripple_causes(line.causes for line in shaft.ready.system.lines)
    if solved.measures is not None or not ripples or motion.cycles > 1 or not motion.stable:
        return solved
    return response_in_time(shaft.ready, motion.speed, ripples)


class _Left(NamedTuple):
    """What is left of a sweep direction, 0 up or 1 down: speeds in turn, and from where it goes on, None: anew."""

    direction: int
    indices: list[int]
    begin: Begin | None


def _left(direction: int, count: int, known: Mapping[int, object], begin: Begin | None) -> _Left:
    """What is left of a direction of which some speeds are known, and one from which it can go on."""
    turn = list(range(count))[:: -1 if direction else 1]
    if all(index in known for index in turn):
        return _Left(direction, [], None)
    behind = [] if begin is None else turn[: turn.index(begin.index) + 1]
    if not behind or not all(index in known for index in behind):
        return _Left(direction, turn, None)
    return _Left(direction, turn[len(behind) :], begin)


def _direction(
    refinement: Refinement, branches: BranchSet, unstable: Unstable, shaft: bool, left: _Left
) -> Iterator[_Point]:
    """The points left of one sweep direction in turn; shaft : whether shaft orders come on top."""
    upward = left.direction == 0
    before = None if left.begin is None else resumed(refinement, left.begin)
    for index, reached in sweep_direction(refinement, branches, left.indices, before, upward=upward, unstable=unstable):
        point = _filled(refinement.ready, index, reached, shaft)
        yield replace(point, begin=begin_of(refinement, index, reached))


# --- curves -----------------------------------------------------------------------------------------------------------


def _nothing(ready: Response, shaft: bool) -> _Values:
    """Values at a speed before anything is reached; shaft : whether shaft orders come on top."""
    system, unknown = ready.system, np.full(ready.system.error_rows.shape[1], np.nan)
    m, n, labels = len(faces(system.meshes).name), system.force.size, link_labels(reported_links(ready)[0])
    return {
        **{name: np.full(m, np.nan) for name in ("mesh_force_rms", "mesh_force_peak", "mesh_force_minimum")},
        "contact_open": np.full(m, np.nan),
        "amplitude": np.full(n, np.nan),
        **{name: np.full(len(labels[dims[0]]), np.nan) for name, dims in ROWS.items() if dims and dims[0] in labels},
        **{name: part for name, (_, part) in peaks_to_peaks(system.errors, unknown).items()},
        "status": NO_SPEED,
        "motion": "",
        "branch_instability": "",
        "stable": False,
        "jumped": False,
        "largest_multiplier": np.nan,
        "multiplier_error": np.nan,
        "harmonics": 0,
        "residual": np.nan,
        **({"residual_dropped": np.nan, "superposed_error": np.nan} if shaft else {}),
    }


def _stacked(points: list[list[_Values]]) -> _Curves:
    """Curves of the points of each direction."""
    curves = _Curves()
    for name, value in points[0][0].items():
        every = [[point[name] for point in row] for row in points]
        curves[name] = np.moveaxis(np.array(every, dtype=object if isinstance(value, str) else None), 1, -1)
    return curves


def _filled(ready: Response, index: int, reached: Reached, shaft: bool) -> _Point:
    """The values of what is reached at one speed."""
    motion, values = reached.motion, _nothing(ready, shaft)
    values |= {"branch_instability": reached.instability, "jumped": reached.jumped, "status": "ok"}
    if motion is None:
        return _Point(index=index, values=values | {"status": "not converged"})
    if isinstance(motion, IntegratedMotion):
        measures = motion.measures
        finite = bool(np.isfinite(measures.rms).all())
        values |= {"motion": "integrated", "status": "ok" if finite else "not finite"}
        if shaft:
            unknown = "shaft orders are not known of a motion that is integrated"
            return _Point(index=index, values=values | _of_shaft_response(ShaftResponse(status=unknown)))
    else:
        values |= {"motion": motion.kind, "harmonics": motion.harmonics, "residual": motion.residual}
        values["stable"] = motion.stable
        if motion.stability is not None:
            values["largest_multiplier"] = abs(motion.stability.multiplier)
            values["multiplier_error"] = motion.stability.error
        if shaft:
            return _Point(index=index, values=values, motion=mesh_orders(motion))
        links = link_outputs(ready, motion.balance, motion.state, ready.lines.tones)[2]
        measures = replace(periodic_measures(ready.system, motion.balance, motion.state), links=links)
    return _Point(index=index, values=values | _of_measures(measures), flank=measures.flank)


def _of_shaft_response(solved: ShaftResponse) -> _Values:
    """Values of a motion with shaft orders."""
    return {
        "status": solved.status,
        "harmonics": solved.harmonics,
        "residual": solved.residual,
        "residual_dropped": solved.truncation_residual,
        "superposed_error": solved.superposed_error,
        **({} if solved.measures is None else _of_measures(solved.measures)),
    }


def _of_measures(measures: Measures) -> _Values:
    """Values of measures."""
    return {
        "mesh_force_rms": measures.rms,
        "mesh_force_peak": measures.highest,
        "mesh_force_minimum": measures.lowest,
        "contact_open": measures.open,
        "amplitude": measures.amplitude,
        **{name: values for name, values in measures.links.items() if values.size},
    }


def _path_curves(refinement: Refinement, branches: BranchSet, judge: bool) -> dict[str, NDArray[Any]]:
    """The whole branch set as curves over its K solutions, (K,) or (w, K)."""
    system, tone = refinement.ready.system, float(refinement.ready.lines.tone)
    path, parts, folds = list[Solution](), list[int](), list[float]()
    for segment in branches.segments:
        path += [with_stability(refinement, at) if judge else at for at in segment.solutions]
        parts += segment.parts
        folds += folds_of_speed([at.state.speed for at in segment.solutions]) if segment.branch else []
    rms = [force_level(system, at.balance, at.state) for at in path]
    kinds = ["" if at.stability is None else at.stability.kind or "stable" for at in path]
    size = [np.nan if at.stability is None else abs(at.stability.multiplier) for at in path]
    return {
        "path_frequency": np.array([at.state.speed * tone for at in path]),
        "path_force_rms": np.array(rms).reshape(len(path), len(faces(system.meshes).name)).T,
        "path_stable": np.array([at.stable for at in path], dtype=bool),
        "path_instability": np.array(kinds, dtype=object),
        "path_multiplier": np.array(size, dtype=float),
        "path_part": np.array(parts, dtype=np.int64),
        "path_harmonics": np.array([at.harmonics for at in path], dtype=np.int64),
        "fold_frequency": tone * np.array(folds, dtype=float),
    }


# --- the Dataset and its warnings -------------------------------------------------------------------------------------


def _warnings(ready: Response, curves: _Curves, branches: BranchSet, largest: list[Array]) -> list[CodedText]:
    """What the reader must know of the curves, of the branch set, and of the largest forces (F,) [N]."""
    rows, tone = gap_rows_of(ready), float(ready.lines.tone)
    notes = law_warnings(ready, rows)
    if largest:
        notes += past_the_end(ready.system, rows.flanks, np.fmax.reduce(largest))
    # the largest part of the cycle in which each whole mesh is open (w,)
    opened = np.nanmax(curves["contact_open"], axis=(0, 2), initial=0.0)
    parted = [name for name, share in zip(faces(ready.system.meshes).name, opened, strict=True) if share > 0]
    if parted:
        listed = ", ".join(parted[:4]) + (f" and {len(parted) - 4} more" if len(parted) > 4 else "")
        notes.append(coded("contact-lost", f"contact is lost for a part of the mesh cycle: {listed}"))
    doubtful = int(np.count_nonzero(np.abs(curves["largest_multiplier"] - 1) <= curves["multiplier_error"]))
    if doubtful:
        text = f"growth is not told from none at {doubtful} points: the largest multiplier is within its error of 1"
        notes.append(coded("stability-unknown", text))
    lost = int(np.count_nonzero(curves["status"] == "not converged"))
    if lost:
        notes.append(coded("no-motion-found", f"no motion was found at {lost} points"))
    if branches.ended:
        at = ", ".join(f"{speed * tone:.4g} Hz" for speed in branches.ended[:4])
        text = f"a branch ended before it was through, near {at}: motions may be missing there"
        notes.append(coded("branch-ended", text))
    if branches.cut:
        at = ", ".join(f"{speed * tone:.4g} Hz" for speed in branches.cut[:4])
        text = f"a branch that winds through unstable motions was cut near {at}: unstable motions may be missing"
        notes.append(coded("branch-cut", text))
    if ready.lines.shaft and "superposed_error" not in curves:
        notes.append(coded("shaft-orders-left-out", "run-outs and other shaft orders are left out"))
    elif ready.lines.shaft:
        notes += _of_shaft_orders(curves)
    return notes


def _several_motions(refinement: Refinement, branches: BranchSet, curves: _Curves) -> list[CodedText]:
    """A warning of each direction that has fallen from the end of a branch to where several motions are stable.

    Known are the stable motions of the branch set, and of others one a word of ``motion`` in the curves.
    """
    notes, tone = list[CodedText](), float(refinement.ready.lines.tone)
    known = np.array([_stable_motions(refinement, crossings) for crossings in branches.crossings], dtype=int)
    for kind in ("symmetry broken", "period 2", "integrated"):
        known += np.any(curves["motion"] == kind, axis=0)
    for name, jumped, turn in zip(_DIRECTIONS, curves["jumped"], (1, -1), strict=True):
        fallen = np.maximum.accumulate(jumped[::turn])[::turn]
        at = np.flatnonzero(fallen & (known > 1))
        if at.size:
            low, high = branches.speeds[at[0]] * tone, branches.speeds[at[-1]] * tone
            text = (
                f"the direction {name} has fallen from the end of a branch, and at {at.size} points from {low:.6g} to "
                f"{high:.6g} Hz up to {known[at].max()} stable motions are known: which of them it is on may depend on "
                "the speeds asked for"
            )
            notes.append(coded("several-motions", text))
    return notes


def _stable_motions(refinement: Refinement, crossings: list[Crossing]) -> int:
    """Number of stable motions of the branch set at one speed."""
    motions = list[Solution]()
    for crossing in crossings:
        at = with_stability(refinement, crossing.solution)
        if at.stable and all(distinct(at, other) for other in motions):
            motions.append(at)
    return len(motions)


def _of_shaft_orders(curves: _Curves) -> list[CodedText]:
    """Points of the curves that shaft orders have cost, and the error of lines superposed."""
    notes = []
    lost = sum(str(text) not in _KNOWN for text in curves["status"].ravel())
    if lost:
        notes.append(coded("shaft-orders-failed", f"with shaft orders nothing is known at {lost} points: see status"))
    status = curves["status"].astype(str)
    if count := int(np.isin(status, (FOLLOWED, RATTLE)).sum()):
        text = f"ripple parts teeth, and the motion is followed in time at {count} points"
        notes.append(coded("followed-in-time", text))
    if count := int((status == RATTLE).sum()):
        notes.append(coded("teeth-rattle", f"the mean load is below the ripple, teeth rattle at {count} points"))
    dropped = np.nan_to_num(curves["residual_dropped"])
    many = np.count_nonzero(dropped > TRUNCATION_NOTED)
    if many:
        text = (
            f"rows dropped are up to {dropped.max():.2g} of the dynamic motion, above {TRUNCATION_NOTED:g} at "
            f"{many} points: forces at an instant have about that error"
        )
        notes.append(coded("rows-dropped", text))
    off = float(np.nanmax(curves["superposed_error"], initial=0.0))
    if off > 0:
        text = f"shaft lines superposed on flanks that part are off by up to {off:.2g} of their own force (RMS)"
        notes.append(coded("lines-superposed", text))
    return notes
