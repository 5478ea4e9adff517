"""The steady response at one speed with teeth that part, shaft orders included, as a labelled Dataset."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...errors import ConvergenceError, ModelError
from ...statics.signals import error_waves
from ...system.gaps import groups_past_the_end, past_the_end
from ...system.system import Array, System, faces
from ...warning_codes import CodedText, coded
from ..response import SteadyOptions
from ..response.response import require_stable_mean, response
from ..response.spectra import combinations, link_labels
from ..response.sweep_table import ROWS
from .branch_set import branch_set
from .in_time import followed_in_time, judged, rattle_warnings, ripple_causes
from .problem import embedded, gap_forces
from .rows import NO_TORQUE, gap_rows_of, largest_link_forces, law_warnings, reported_links
from .shaft_orders import (
    NEGLIGIBLE,
    LinearMotion,
    SuperposedLine,
    TorusOutputs,
    linear_error,
    linear_motion,
    superposed_lines,
    superposition_is_an_answer,
    superposition_is_exact,
    torus_outputs,
    unchanging_lines,
)
from .solutions import Refinement, Solution, Stability, solution, too_many_steps, with_stability
from .torus import TRUNCATION_NOTED, Torus, TorusPoint, memory, respond_torus, torus_of

# Least harmonics of the motion whose stability is asked for, by the number of mesh tones: with 14 a multiplier of
# ren2021 is off by 3e-3, a force by 2e-5.
_HARMONICS = {1: 24, 2: 8}
# Error of a superposed line per its own force above which it has none of its own: teeth that do not touch without it.
_NO_FORCE = 1e3


def contact_steady(system: System, options: SteadyOptions) -> xr.Dataset:
    """Steady response at one speed with flanks that only press: a motion on the torus of mesh and shaft phases.

    Curves over the mesh phase are of each mesh's own tone: the mean over all other phases, and least and most.  The RMS
    is that of all time; peak and minimum are those over all relative phases, which teeth meet at discrete values.
    Where there are several solutions, the one next to the linear response is found.  Its stability is that of the
    motion of mesh orders there; one that is not stable comes with a warning.

    Returns
    -------
    Dataset of docs/theory/contact-shaft-orders.md.

    Raises
    ------
    ModelError : no damping, no mesh frequency, torques out of balance, or an option out of range.
    ConvergenceError : no solution was found, or a vibration of the mean system grows.
    """
    relative_speed, shaft_orders, shaft_tones = options.relative_speed, options.shaft_orders, options.shaft_tones
    if not (math.isfinite(relative_speed) and relative_speed > 0):
        raise ModelError("out of range", path="relative_speed", given=relative_speed, allowed="a number above zero")
    torus = torus_of(response(system, asks_laws=True), shaft_orders=shaft_orders, most=shaft_tones, fine=True)
    if gap_rows_of(torus.ready).links is None:  # a body that the mean system loses may be held by the stop of its link
        require_stable_mean(torus.ready, float(relative_speed))
    linear = linear_motion(torus, float(relative_speed))
    lines = None if linear is None else unchanging_lines(torus, linear)
    rms = None
    if linear is not None and lines is not None:
        torus, point, rms = torus.mesh_orders_only, linear.point, linear.rms
    else:
        with np.errstate(over="ignore"):  # the error of a line of no force, which is none of its own
            torus, point, lines = steady_motion(torus, float(relative_speed))
    off = max((line.error for line in lines), default=0.0)
    if not point.converged or off > _NO_FORCE:
        loose = "" if system.force.any() else f"{NO_TORQUE}, transient shows how they rattle; "
        if off:
            raise ConvergenceError(
                "the torus of shaft orders was not solved, and lines superposed on the laws of links or tables, or on "
                f"teeth that part, are off by {off:.2g} of their own forces: {loose}"
                "transient follows the motion, static slow shafts; or try a slightly different speed"
            )
        raise ConvergenceError(
            f"no steady motion with contact loss found at {float(torus.ready.lines.tone) * relative_speed:.6g} Hz mesh "
            f"frequency ({point.status}, residual {point.residual:.2g}): {loose}"
            "transient follows the motion, static slow shafts; or try a slightly different speed, or more damping"
        )
    recorded = {"contact_loss": True, "relative_speed": relative_speed, "shaft_orders": shaft_orders}
    outputs = torus_outputs(torus, point, lines)
    ripples = ripple_causes(line.shaft.causes for line in lines)
    if shaft_tones is None and torus.mesh_tones == 1 and ripples and _pulled(outputs).any():
        return followed_in_time(torus.ready.lawful, float(relative_speed), ripples, recorded)
    stability, coarse = mesh_order_stability(torus, point), _coarse(torus, point, linear)
    return _labelled(torus, point, lines, outputs, stability, recorded, rms=rms, coarse=coarse)


def _pulled(outputs: TorusOutputs) -> NDArray[np.bool_]:
    """Whether superposed lines pull on the teeth of a mesh (w,) that touch without them."""
    return np.asarray((np.abs(outputs.force) < outputs.reach).any(axis=0))


def mesh_order_stability(torus: Torus, point: TorusPoint) -> Stability | None:
    """Stability of the motion of mesh orders next to a point of the torus; None where it is not known.

    That is with more than two mesh frequencies, at speeds so low that a mesh cycle takes too many steps of the highest
    mode, and where Newton's method finds no motion of mesh orders there.
    """
    if torus.mesh_tones > 2 or too_many_steps(torus.ready, point.state.speed):
        return None
    refinement, harmonics = Refinement(ready=torus.ready), max(*point.size.harmonics, _HARMONICS[torus.mesh_tones])
    if point.state.unchanging and point.problem.rows.parametric and not point.size.orders:
        # tangents that keep one value at each phase: no motion need be found again
        same = Solution(balance=point.problem, harmonics=harmonics, state=point.state, residual=point.residual)
        return with_stability(refinement, same).stability
    balance, points = refinement.problem(harmonics), point.problem.grid.points
    mesh = ~points[:, torus.mesh_tones :].any(axis=1)
    start = embedded(points[mesh, : torus.mesh_tones], point.state.y[:, mesh], balance)
    at = solution(refinement, start, point.state.speed, balance=balance, harmonics=harmonics)
    return None if at is None else with_stability(refinement, at).stability


def steady_motion(torus: Torus, speed: float) -> tuple[Torus, TorusPoint, list[SuperposedLine]]:
    """The torus used, the motion at one relative speed, and the lines superposed on it.

    Mesh orders come first, reached along the branch set where they are not found from the linear motion.  Where flanks
    touch whatever the phases of the shaft lines, mesh orders and superposed lines are the whole solution; the torus is
    for speeds at which they part.  One that is not found is tried with one shaft tone less, down to none.
    """
    mesh_point = respond_torus(torus.mesh_orders_only, speed)
    if not mesh_point.converged:
        # on the branch set, a stable one if there is
        refinement = Refinement(ready=torus.ready)
        crossings = branch_set(refinement, np.array([speed])).crossings[0]
        judged = [with_stability(refinement, crossing.solution) for crossing in crossings]
        if not judged:
            return torus.mesh_orders_only, mesh_point, []
        at = next((motion for motion in judged if motion.stable), judged[0])
        mesh_point = respond_torus(torus.mesh_orders_only, speed, start=(at.balance.grid.points, at.state.y))
    lines = superposed_lines(torus.mesh_orders_only, mesh_point) if mesh_point.converged else []
    if not mesh_point.converged or (mesh_point.status == "ok" and superposition_is_exact(mesh_point, lines)):
        return torus.mesh_orders_only, mesh_point, lines
    start = mesh_point.problem.grid.points, mesh_point.state.y
    while torus.shaft_tones.tones and memory(torus, speed)[1]:
        torus = torus.with_fewer_tones
    point = respond_torus(torus, speed, start=start)
    while not point.converged and torus.shaft_tones.tones:
        torus = torus.with_fewer_tones
        point = respond_torus(torus, speed, start=start)
    lines = superposed_lines(torus, point) if point.converged else []
    return torus, point if superposition_is_an_answer(point, lines) else replace(point, converged=False), lines


# --- the Dataset and its warnings -------------------------------------------------------------------------------------


def _labelled(
    torus: Torus,
    point: TorusPoint,
    lines: Sequence[SuperposedLine],
    outputs: TorusOutputs,
    stability: Stability | None,
    options: dict[str, Any],
    *,
    rms: Array | None,
    coarse: Sequence[CodedText],
) -> xr.Dataset:
    """The Dataset of a point of the torus and of the lines superposed on it.

    rms : (w,) of mesh forces, where it is known better than by the torus [N].  coarse : warnings of rows dropped.
    """
    from ...results.dataset import dataset

    ready, system = torus.ready, torus.ready.system
    face = faces(system.meshes)
    force, reach, counts = outputs.force, outputs.reach, point.problem.grid.counts
    axis = ready.lines.axis[face.first]
    opens = face.any(outputs.row_open > 0)
    pulled = _pulled(outputs) & ~opens  # where teeth would part
    past = past_the_end(system, point.problem.rows.flanks, outputs.measures.flank)
    if ready.lawful.groups:
        forces = gap_forces(point.problem, point.state)
        past += groups_past_the_end(ready.lawful, largest_link_forces(ready.lawful, point.problem.rows, forces))
    combined, label = _combinations(torus, point, force)
    at, rattle = outputs.measures, list[CodedText]()
    if ripple_causes(line.causes for line in ready.lawful.lines):
        rattle = rattle_warnings(face.name, force.mean(axis=0), (at.lowest, at.highest), at.open, outputs.far)
    along, slices = _along_the_face(torus, outputs, counts)
    links, link_labels = _link_variables(torus, outputs, counts)
    return dataset(
        {
            "mesh_force": (("mesh", "mesh_phase"), _over_phase(force, counts, axis, np.mean)),
            "mesh_force_least": (("mesh", "mesh_phase"), _over_phase(force - reach, counts, axis, np.min)),
            "mesh_force_most": (("mesh", "mesh_phase"), _over_phase(force + reach, counts, axis, np.max)),
            "mesh_force_rms": ("mesh", outputs.measures.rms if rms is None else rms),
            "mesh_force_bound": ("mesh", outputs.measures.highest),
            "mesh_force_minimum": ("mesh", outputs.measures.lowest),
            "open_share": ("mesh", outputs.measures.open),
            "far_share": ("mesh", outputs.far),
            "contact_lost": ("mesh", opens | pulled),
            "amplitude": ("dof", outputs.measures.amplitude),
            **along,
            **links,
            **combined,
            **judged(point.status, stability, residual=point.residual, dropped=point.truncation_residual),
        },
        {
            "mesh": list(face.name),
            **slices,
            **link_labels,
            "dof": list(system.dofs.names),
            "mesh_phase": np.arange(counts[0]) / counts[0],
            "combination": label,
            "mesh_frequency": float(ready.lines.tone) * point.state.speed,
        },
        verb="steady",
        options={
            **options,
            "shaft_tones": len(torus.shaft_tones.tones),  # those of the motion: fewer where it was not solved otherwise
            "harmonics": max(point.size.harmonics),
            "slow_orders": list(point.size.orders),
        },
        provenance=system.provenance,
        warnings=[
            *law_warnings(ready, point.problem.rows),
            *_instability(stability, too_many_steps(ready, point.state.speed)),
            *coarse,
            *_warnings(lines, bool(pulled.any())),
            *rattle,
            *past,
        ],
    )


def _over_phase(
    force: Array, counts: tuple[int, ...], axis: NDArray[np.int64], statistic: Callable[..., Array]
) -> Array:
    """A statistic over all phases but the own one of each column, (c, N_own), of a force (N, c) [N]."""
    box, phases = force.reshape(*counts, -1), range(len(counts))
    by_axis = [
        statistic(box, axis=tuple(phase for phase in phases if phase != own))
        for own in range(int(axis.max(initial=0)) + 1)
    ]
    return np.array(by_axis)[axis, :, np.arange(len(axis))]


def _combinations(torus: Torus, point: TorusPoint, force: Array) -> tuple[dict[str, Any], NDArray[np.object_]]:
    """Complex amplitude (w, J) at every lattice point [N] of mesh forces (N, w), and the names (J,) of these.

    A mesh tone is named after its stage, a shaft tone after the path in the file of the first line on it.
    """
    grid, ready, D = point.problem.grid, torus.ready, torus.mesh_tones
    J, rows = len(grid.points), grid.rows(force)
    tones = (*ready.lines.tones, *torus.shaft_tones.tones)
    names = ready.lines.stages(ready.system)
    for tone in range(len(torus.shaft_tones.tones)):
        causes = [line.causes for place, _, line in torus.shaft_tones.lines if place[D + tone] and line.causes]
        names.append(causes[0][0] if causes else f"slow tone {tone + 1}")
    labels, frequency = combinations(grid.points, names, tones, point.state.speed)
    return {
        "combination_force": (("mesh", "combination"), (rows[:J] + 1j * rows[J:]).T),
        "combination_frequency": ("combination", frequency),
    }, labels


def _link_variables(
    torus: Torus, outputs: TorusOutputs, counts: tuple[int, ...]
) -> tuple[dict[str, Any], dict[Hashable, Any]]:
    """Variables and coordinates of links: forces over the phase of the first mesh, and measures over all phases."""
    labels, errors = link_labels(reported_links(torus.ready)[0]), torus.ready.system.errors

    def over_phase(values: Array) -> Array:
        return _over_phase(values, counts, np.zeros(values.shape[1], dtype=np.int64), np.mean)

    variables: dict[str, Any] = {name: (ROWS[name], values) for name, values in outputs.measures.links.items()}
    variables = {name: column for name, column in variables.items() if column[1].size}
    if labels:
        variables["link_force"] = (("link_row", "mesh_phase"), over_phase(outputs.link_force))
    if errors.mesh:
        variables |= error_waves(errors, over_phase(outputs.error), "mesh_phase")
    return variables, {**labels, **({"shaft": list(errors.shaft)} if errors.shaft else {})}


def _along_the_face(
    torus: Torus, outputs: TorusOutputs, counts: tuple[int, ...]
) -> tuple[dict[str, Any], dict[Hashable, Any]]:
    """Forces of slices over the mesh phase, largest, open shares and face-load factors; nothing uncut."""
    meshes = torus.ready.system.meshes
    face = faces(meshes)
    if not face.cut.any():
        return {}, {}
    mean = outputs.row_force.mean(axis=0)
    static, moving = (face.load_factor(-face.least(-rows), face.total(mean)) for rows in (mean, outputs.row_peak))
    wave = _over_phase(outputs.row_force, counts, torus.ready.lines.axis, np.mean)
    return {
        "face_load_factor": ("mesh", static),
        "dynamic_face_load_factor": ("mesh", moving),
        "slice_force": (("mesh_slice", "mesh_phase"), wave[face.cut]),
        "slice_force_peak": ("mesh_slice", outputs.row_peak[face.cut]),
        "slice_open_share": ("mesh_slice", outputs.row_open[face.cut]),
    }, {"mesh_slice": np.array(meshes.name, dtype=object)[face.cut]}


def _instability(stability: Stability | None, steps: int) -> list[CodedText]:
    """A warning of a motion that is not stable, or whose stability is not known.

    steps : of a mesh cycle, where they are too many for multipliers, else 0.
    """
    if stability is None:
        why = f": a mesh cycle would take {steps:.1e} steps of the highest mode" if steps else ""
        return [coded("stability-unknown", f"the stability of this motion is not known{why}")]
    size, notes = abs(stability.multiplier), list[CodedText]()
    if not stability.decided:
        doubt = f"growth is not told from none: the multiplier is {size:.8g} a cycle, right to {stability.error:.2g}"
        notes.append(coded("stability-unknown", doubt))
    if not stability.stable:
        above = f"{size:.3g}" if size > 1.1 else f"1 + {size - 1:.3g}"
        text = (
            f"this motion is not stable ({stability.kind}, multiplier {above} a cycle): no train stays "
            "on it, and what takes its place may be larger; sweep --contact-loss or transient finds that"
        )
        notes.append(coded("motion-unstable", text))
    return notes


def _coarse(torus: Torus, point: TorusPoint, linear: LinearMotion | None) -> list[CodedText]:
    """A warning of how far forces may be off where rows dropped count, measured on the linear response if there is."""
    if point.truncation_residual <= TRUNCATION_NOTED:
        return []
    note = f"rows dropped are {point.truncation_residual:.2g} of the dynamic motion, above {TRUNCATION_NOTED:g}: "
    if linear is None:
        return [coded("rows-dropped", note + "forces of single meshes may be off by several times that")]
    counts = point.problem.grid.counts[: torus.mesh_tones]
    rms, largest = (max(error, point.truncation_residual) for error in linear_error(torus, linear, point.size, counts))
    note += (
        f"with the same rows the linear response is off by up to {rms:.2g} in the RMS of a mesh force and "
        f"{largest:.2g} in the largest one; where teeth part the error is of that size or larger"
    )
    return [coded("rows-dropped", note)]


def _warnings(lines: Sequence[SuperposedLine], pulled: bool) -> list[CodedText]:
    """Which lines are superposed on flanks that part; pulled : they part teeth that touch without them."""
    notes = []
    other = "; it parts teeth, which changes the mean forces too: transient or static shows them" if pulled else ""
    for line in lines:
        if line.error >= NEGLIGIBLE:
            text = (
                f"{'; '.join(line.shaft.causes) or 'a shaft line'}: superposed linearly on laws that part or bend; "
                f"its force is off by {line.error:.2g} of itself (RMS){other}"
            )
            notes.append(coded("lines-superposed", text))
    return notes
