"""Views of `steady` and `sweep`, with and without contact loss: forces at one speed and over it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...limits import carries_load
from ...results.dataset import first_largest, largest
from ...show.elements import (
    Company,
    Drawing,
    Finding,
    KeyFigure,
    Part,
    Section,
    Table,
    error_tables,
    extent,
    force_table,
    largest_heading,
    largest_over_speed,
    loaded,
    named_columns,
    relative_speed,
    sensor_tables,
    speed_range_of,
    status_table,
    torque_tables,
)
from ...show.part_tables import deflection_tables
from ...show.series import engineering, equal_runs, of_first_stage, own_tones, split_name, stage_count, texts, unbroken
from ...show.views import ResultView

# --- steady ----------------------------------------------------------------------------------------------------------


def steady_tables(result: xr.Dataset) -> Sequence[Table]:
    """Mesh forces, radial forces in bearings [N], shaft frequencies [Hz] with their largest amplitude [N]."""
    found = [force_table(result), *error_tables(result), *sensor_tables(result)]
    if "bearing_force_peak" in result:
        heading = largest_heading(result)
        bearings: dict[str, Any] = {
            "bearing": list(map(str, result.bearing.values)),
            "mean [N]": list(result.bearing_force_mean.values),
            "dynamic rms [N]": list(result.bearing_force_rms.values),
            heading: list(result.bearing_force_peak.values),
        }
        title = "Radial forces in bearings, supports and couplings"
        found.append(Table(title=title, columns=loaded(bearings, heading)))
    found += [*torque_tables(result), *deflection_tables(result)]
    if result.sizes.get("line"):
        columns: dict[str, Any] = {
            "cause": list(map(str, result.line.values)),
            "frequency [Hz]": list(result.line_frequency.values),
            "largest amplitude of a mesh force [N]": list(result.line_amplitude.max("mesh").values),
        }
        found.append(Table(title="Shaft frequencies", columns=columns))
    return found


def steady_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Mesh forces over the mesh cycle; with contact loss also their range over all shaft phases."""
    from ...show.charts.over_time import force_envelopes, mesh_forces, sensors, transmission_errors

    parts = []
    if "mesh_force" in result.variables:
        parts.append(Drawing(anchor="steady-forces", figure=mesh_forces(result)))
        if "mesh_force_most" in result.variables:
            parts.append(Drawing(anchor="steady-range", figure=force_envelopes(result)))
    if "transmission_error_rotation" in result.variables:
        parts.append(Drawing(anchor="steady-errors", figure=transmission_errors(result)))
    if "sensor" in result.dims:
        parts.append(Drawing(anchor="sensors", figure=sensors(result)))
    return [Section(anchor="steady", title="Steady response", parts=parts)]


# --- sweep of linear contact -----------------------------------------------------------------------------------------

# Operating range, per operating speed, as of the default range of a sweep.
_OPERATION = (0.05, 1.3)
_RANGES = 4  # of speed named in a sentence
_TITLES = {"operation": "Speed sweep about operation", "modes": "Speed sweep to the natural frequencies"}


def sweep_tables(result: xr.Dataset) -> Sequence[Table]:
    """Largest values over the speeds, and where: mesh forces [N], lateral bearing forces [N], accelerations [m/s2]."""
    frequency = result.mesh_frequency.values.ravel()
    title = f"Dynamic mesh forces, {len(frequency)} speeds, {extent(result)}"
    meshes = largest_over_speed(result, "mesh", "mesh_force_rms", "largest rms [N]")
    meshes["largest force [N]"] = largest_over_speed(result, "mesh", "mesh_force_peak", "force")["force"]
    meshes |= largest_over_speed(result, "mesh", "dynamic_factor", "largest K_v", at="K_v at [Hz]")
    found = [Table(title=title, columns=meshes)]
    if "bearing_force_peak" in result:
        heading = largest_heading(result)
        bearings = largest_over_speed(result, "bearing", "bearing_force_peak", heading)
        bearings["largest dynamic rms [N]"] = largest_over_speed(result, "bearing", "bearing_force_rms", "rms")["rms"]
        title = "Radial forces in bearings, supports and couplings"
        found.append(Table(title=title, columns=loaded(bearings, heading)))
    if "body_acceleration_rms" in result:
        bodies = largest_over_speed(result, "body", "body_acceleration_rms", "largest rms [m/s2]")
        title = "Accelerations of the bodies' centres"
        found.append(Table(title=title, columns=loaded(bodies, "largest rms [m/s2]")))
    return [*found, *error_tables(result), *sensor_tables(result), *torque_tables(result), status_table(result)]


def sweep_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Mesh forces, their order spectrum and bearing forces over speed, natural frequencies of `modes` behind them.

    Of a sweep to the modes beside one about operation the mesh forces alone.
    """
    from ...show.charts.over_speed import bearing_forces, error_sweep, speed_sweep
    from ...show.charts.over_time import sensors
    from ...show.charts.speed_maps import waterfall

    modes = company.get("modes")
    to_modes = speed_range_of(result) == "modes"
    words = "Dotted: natural frequencies in the colour of their kind."
    if to_modes:
        words = f"The whole range of the natural frequencies, {extent(result)}. {words}"
    elif modes is not None and modes.sizes.get("resonance", 0) and speed_range_of(result) == "operation":
        words = f"{extent(result)}. Dotted: speeds at which mesh orders meet modes, those with the largest forces."
    parts: list[Part] = [Drawing(anchor="sweep", figure=speed_sweep(result, modes), caption=words)]
    if "mesh_force_order" in result.variables and not (to_modes and company.get("sweep") is not result):
        words = (
            "The largest amplitude of all meshes; a resonance is where a line crosses a natural frequency and glows."
        )
        parts.append(Drawing(anchor="waterfall", figure=waterfall(result, modes), caption=words))
    if "bearing_force_peak" in result.variables and not (to_modes and company.get("sweep") is not result):
        words = "Length of the lateral force of a link; links that carry the same share a curve."
        parts.append(Drawing(anchor="bearings", figure=bearing_forces(result, modes), caption=words))
    if "transmission_error_rotation_peak_to_peak" in result.variables and not to_modes:
        words = "Largest less smallest over all phases of the shaft lines."
        parts.append(Drawing(anchor="error-sweep", figure=error_sweep(result, modes), caption=words))
    if "sensor" in result.dims and not to_modes:
        parts.append(Drawing(anchor="sensors", figure=sensors(result)))
    return [Section(anchor="sweep", title=_TITLES.get(speed_range_of(result), "Speed sweep"), parts=parts)]


def sweep_key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """The largest dynamic factor [1] at operation and RMS of a mesh force [kN] in its range; none of a sweep to the
    modes.

    From elsewhere only where the speeds asked for are elsewhere, and said so.
    """
    if speed_range_of(result) == "modes":
        return []
    speed = relative_speed(result)
    inside = (speed >= _OPERATION[0] - 1e-9) & (speed <= _OPERATION[1] + 1e-9)
    found: list[KeyFigure] = []
    at_operation = np.flatnonzero(np.isclose(speed, 1.0, rtol=0, atol=1e-9))
    if at_operation.size and "dynamic_factor" in result.variables:
        factor = _judged_factor(result)[:, at_operation[0]]
        if np.isfinite(factor).any():
            mesh = _mesh(result, *first_largest(factor))
            found.append((f"{np.nanmax(factor):.3f}", f"largest K_v at the operating speed: {mesh}"))
    rms = result["mesh_force_rms"].transpose("mesh", "speed").values
    shown = inside if np.isfinite(rms[:, inside]).any() else np.ones_like(inside)
    rms = np.where(shown, rms, np.nan)
    if not np.isfinite(rms).any():
        return found
    place, at = _first_most(rms)
    hertz = float(np.ravel(result["mesh_frequency"].values)[at]) if "mesh_frequency" in result.variables else np.nan
    hertz *= float(own_tones(result)[place])
    where = f"{engineering(hertz)} Hz, {engineering(100 * float(speed[at]))} % of the operating speed"
    outside = "" if inside[at] or not np.isfinite(speed[at]) else ", outside the operating range"
    words = f"largest RMS mesh force: {_mesh(result, place)}, {where}{outside}"
    return [*found, (f"{engineering(float(rms[place, at]) / 1e3)} kN", words)]


def sweep_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """Largest dynamic factor of the operating range, and the ranges of speed in which teeth would part."""
    if speed_range_of(result) == "modes" or "dynamic_factor" not in result.variables:
        return []
    speed = 100 * relative_speed(result)
    factor = _judged_factor(result)
    if not np.isfinite(factor).any() or not np.isfinite(speed).all():
        return []
    mesh, at = _first_most(factor)
    most = f"largest K_v {factor[mesh, at]:.3f} at {engineering(float(speed[at]))} %, {_mesh(result, mesh)}"
    # meshes of pairs and sides that have no K_v at any speed: they carry nothing
    pairs = [(stage, pair, side) for stage, pair, _, side in map(split_name, texts(result, "mesh"))]
    loaded = {pair for pair, known in zip(pairs, np.isfinite(factor).any(axis=1), strict=True) if known}
    idle = np.array([pair not in loaded for pair in pairs])
    least = result["mesh_force_minimum"].transpose("mesh", "speed").values
    apart = np.asarray((least[~idle] < 0).any(axis=0))  # teeth without load always part and meet again
    parted = _ranges(speed, apart)
    tone, change, text = "good", "", f"Teeth stay in contact {_extent_words(speed)}; {most}."
    if parted:
        tone = _parting_tone(parted)
        text = f"Teeth would part at {_range_words(parted)} of the operating speed; {most}."
        change = "Run outside these ranges, or move the resonances named above." if tone == "caution" else ""
    found = [Finding(tone=tone, text=text, change=change, anchor="sweep")]
    if idle.any():
        names = ", ".join(name for name, none in zip(texts(result, "mesh"), idle, strict=True) if none)
        text = f"K_v judges nothing in {names}: no load, or a drag alone. Such teeth may rattle within their backlash."
        found.append(Finding(tone="caution", text=text, anchor="sweep"))
    return found


def _judged_factor(result: xr.Dataset) -> np.ndarray:
    """K_v (mesh, speed) [1]; nan of meshes that idle, with less than a twentieth of the largest mean in their stage."""
    factor = result["dynamic_factor"].transpose("mesh", "speed").values
    if "mesh_force_mean" not in result.variables:
        return np.asarray(factor)
    mean = result["mesh_force_mean"].transpose("mesh", ...).values.reshape(len(factor), -1).max(axis=1)
    stages = [split_name(name)[0] for name in texts(result, "mesh")]
    return np.asarray(np.where(carries_load(mean, stages)[:, None], factor, np.nan))


def _first_most(values: np.ndarray) -> tuple[int, int]:
    """Mesh and speed of the largest of values (m, P); of meshes equal there the first."""
    at = int(np.nanmax(np.where(np.isfinite(values), values, -np.inf), axis=0).argmax())
    (mesh,) = first_largest(values[:, at])
    return mesh, at


def _ranges(speed: np.ndarray, inside: np.ndarray) -> list[tuple[float, float]]:
    """Stretches of the speeds (P,) that are inside (P,): first and last speed of each."""
    rank = np.argsort(speed)
    runs = (rank[run[[0, -1]]] for run in equal_runs(inside[rank]))
    return [(float(speed[a]), float(speed[b])) for a, b in runs if inside[a]]


def _parting_tone(ranges: Sequence[tuple[float, float]]) -> str:
    """Of ranges of speed [%] in which teeth part: bad where operation lies in one."""
    return "bad" if any(a <= 100 <= b for a, b in ranges) else "caution"


def _extent_words(speed: np.ndarray) -> str:
    """``from 5 to 130 % of the operating speed``, of speeds (P,) [%]; of one speed ``at`` it."""
    low, high = engineering(speed.min()), engineering(speed.max())
    return f"{f'from {low} to {high}' if low != high else f'at {low}'} % of the operating speed"


def _range_words(ranges: Sequence[tuple[float, float]]) -> str:
    """``60 to 70 %, 110 % and 2 more ranges``, of speeds [% of the operating speed]."""
    ends = [(engineering(a, 4), engineering(b, 4) if a < b else "") for a, b in ranges[:_RANGES]]
    shown = [f"{a} to {b} %" if b else f"{a} %" for a, b in ends]
    more = f" and {len(ranges) - _RANGES} more ranges" if len(ranges) > _RANGES else ""
    return f"{', '.join(shown)}{more}"


def _mesh(result: xr.Dataset, place: int) -> str:
    names = texts(result, "mesh")
    return unbroken(names[place], stages=stage_count(names))


# --- sweep with contact loss -----------------------------------------------------------------------------------------

_SHOWN = 40  # rows of what moves


def contact_sweep_tables(result: xr.Dataset) -> Sequence[Table]:
    """Largest forces of each mesh, ranges of speed by what moves there, folds."""
    title = f"{result.sizes['speed']} speeds, {extent(result)}"
    return [_forces(result, title), _motions(result), *_folds(result), status_table(result)]


def contact_sweep_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The most loaded mesh over speed, with its branches."""
    from ...show.charts.over_speed import contact_sweep

    words = "Dashed: unstable branches. Large marks: motions that take the place of an unstable one. Circles: folds."
    parts = [Drawing(anchor="contact-sweep", figure=contact_sweep(result), caption=words)]
    return [Section(anchor="contact-sweep", title="Speed sweep with contact loss", parts=parts)]


def contact_sweep_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """The ranges of speed in which teeth part, and the largest force."""
    ends = ("mesh_force_peak", "mesh_force_minimum")  # on its far flank a mesh has negative forces alone
    if not {*ends, "contact_open"} <= set(result.variables):
        return []
    speed = 100 * relative_speed(result)
    force = np.array([np.abs(result[name].transpose("direction", "mesh", "speed").values) for name in ends])
    force = np.where(np.isfinite(force), force, -np.inf).max(axis=(0, 1))
    if not np.isfinite(force).any() or not np.isfinite(speed).all():
        return []
    mesh, at = _first_most(force)
    largest_shown = engineering(float(force[mesh, at]) / 1e3)
    most = f"largest force {largest_shown} kN at {engineering(float(speed[at]))} %, {_mesh(result, mesh)}"
    parted = np.asarray((result["contact_open"] > 0).any("mesh").transpose("direction", "speed").values)
    ranges = _ranges(speed, np.asarray(parted.any(axis=0)))
    failed = int(result["mesh_force_peak"].isnull().all("mesh").sum())
    left = f" {failed} {'points have' if failed > 1 else 'point has'} no motion." if failed else ""
    if not ranges:
        text = f"No tooth loses contact {_extent_words(speed)}; {most}.{left}"
        return [Finding(tone="good", text=text, anchor="contact-sweep")]
    both = ", not at the same speeds up and down" if (parted[0] != parted[-1]).any() else ""
    text = f"Teeth part at {_range_words(ranges)} of the operating speed{both}; {most}.{left}"
    return [Finding(tone=_parting_tone(ranges), text=text, anchor="contact-sweep")]


def _forces(result: xr.Dataset, title: str) -> Table:
    rows = []
    for mesh in result.mesh.values:
        row: list[Any] = [str(mesh)]
        for direction in result.direction.values:
            series = result.mesh_force_rms.sel(mesh=mesh, direction=direction).values
            found = np.isfinite(series).any()
            at = largest(series)
            row += [float(series[at]), float(result.mesh_frequency.values[at]) if found else np.nan]
        # a mesh that rests on its far flank has negative forces alone: the largest in size counts
        ends = np.stack([result[name].sel(mesh=mesh).values for name in ("mesh_force_peak", "mesh_force_minimum")])
        known = ends[np.isfinite(ends)]
        force = float(known[np.abs(known).argmax()]) if known.size else np.nan
        apart = float(np.nanmax(result.contact_open.sel(mesh=mesh).values, initial=0.0)) if known.size else np.nan
        rows.append((*row, force, round(100 * apart, 1)))
    of = of_first_stage(result)
    where = f"at mesh frequency{of} [Hz]" if of else "at [Hz]"
    sides = ("up: largest rms [N]", where, "down: largest rms [N]", f"{where} ")
    headings = ("mesh", *sides, "largest force [N]", "apart at most [% of the time]")
    return Table(title=f"Dynamic mesh forces with contact loss, {title}", columns=named_columns(headings, rows))


def _motions(result: xr.Dataset) -> Table:
    """Runs of speeds with one kind of motion, in each direction."""
    rank = np.argsort(result.mesh_frequency.values, kind="stable")
    frequency, rows = result.mesh_frequency.values[rank], []
    for direction in result.direction.values:
        part = result.sel(direction=direction)
        # periodic, integrated (quasi-periodic), ...: the motion, and what its branch was left by
        said = [
            f"{motion or 'none'}{f' ({left})' if left else ''}{', teeth part' if apart > 0 else ''}"
            for motion, left, apart in zip(
                part.motion.values, part.branch_instability.values, part.contact_open.max("mesh").values, strict=True
            )
        ]
        label = np.array(said, dtype=object)[rank]
        for run in equal_runs(label):
            rows.append((str(direction), *frequency[run[[0, -1]]].tolist(), str(label[run[0]])))
    of = of_first_stage(result) and f" mesh frequency{of_first_stage(result)}"
    headings = ("direction", f"from{of} [Hz]", f"to{of} [Hz]", "motion")
    left = f", first {_SHOWN} of {len(rows)}" if len(rows) > _SHOWN else ""
    return Table(title=f"What moves{left}", columns=named_columns(headings, rows[:_SHOWN]))


def _folds(result: xr.Dataset) -> list[Table]:
    if not result.sizes.get("fold"):
        return []
    heading = f"mesh frequency{of_first_stage(result)} [Hz]"
    return [Table(title="Folds of the branches", columns={heading: list(result.fold_frequency.values)})]


VIEWS = (
    ResultView("steady", 60, steady_tables, steady_sections),
    ResultView("sweep", 80, sweep_tables, sweep_sections, key_figures=sweep_key_figures, findings=sweep_findings),
    ResultView("contact_sweep", 110, contact_sweep_tables, contact_sweep_sections, findings=contact_sweep_findings),
)
