"""Views of `stiffness`, `contact`, `relief` and `efficiency`."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...limits import RELIEF_GAIN
from ...results.dataset import largest
from ...show.elements import Company, Drawing, Finding, KeyFigure, Part, Section, Table, columns_of, number
from ...show.series import (
    READ_IN,
    by_pair_and_side,
    engineering,
    losses_of_pairs,
    numbers,
    pair_names,
    pair_titles,
    relief_effect,
    short_names,
    split_name,
    texts,
)
from ...show.views import ResultView

_LEADS = 6  # phases of meshes in a sentence
_NO_OVERLAP = 5e-8  # of tips, that reads as none [m]

# --- stiffness -------------------------------------------------------------------------------------------------------


def stiffness_tables(result: xr.Dataset) -> Sequence[Table]:
    """Mean, least and most stiffness of every mesh [N/um]."""
    history = result.mesh_stiffness.transpose("mesh", "mesh_phase").values * 1e-6
    columns: dict[str, Any] = {
        "mesh": list(map(str, result.mesh.values)),
        "mean [N/µm]": list(result.mean_mesh_stiffness.values * 1e-6),
        "least [N/µm]": list(history.min(axis=1)),
        "most [N/µm]": list(history.max(axis=1)),
    }
    return [Table(title="Mesh stiffness along the tooth normal", columns=columns)]


def stiffness_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """The mesh whose stiffness varies most over its cycle; nothing beside a `check`, whose report shows all."""
    if "check" in company:
        return []
    history = result.mesh_stiffness.transpose("mesh", "mesh_phase").values
    mean = history.mean(axis=1)
    swing = np.ptp(history, axis=1) / mean
    at = largest(swing)
    if not swing[at] > 1e-9:
        return [Finding(tone="", text="The mesh stiffness does not vary.", anchor="meshes")]
    text = (
        f"{short_names(texts(result, 'mesh'))[at]} varies most over its cycle, by {engineering(100 * swing[at], 3)} % "
        f"of its mean {engineering(1e-6 * mean[at], 4)} N/µm peak to peak"
    )
    if "phase_lead" in result.variables:  # a result of an earlier version has none
        leads = sorted({f"{lead:.3g}" for lead in numbers(result, "phase_lead").tolist()}, key=float)
        more = ", ..." if len(leads) > _LEADS else ""
        text += f"; phases of the meshes are {', '.join(leads[:_LEADS])}{more} mesh cycles"
    return [Finding(tone="", text=f"{text}.", anchor="meshes")]


def stiffness_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The curves; beside a `check` they stand among the meshes of that."""
    from ...show.charts.train import SERIES, mesh_stiffness

    if "check" in company:
        return []
    parts = [Drawing(anchor="stiffness", figure=mesh_stiffness(result), caption=SERIES)]
    return [Section(anchor="meshes", title="Meshes", parts=parts)]


# --- contact ---------------------------------------------------------------------------------------------------------


def contact_tables(result: xr.Dataset) -> Sequence[Table]:
    """All meshes at the operating load, of a mesh alone stress in the tooth roots there, then all loads."""
    return [_contact_meshes(result), *_roots(result), _loads(result)]


def contact_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Of a train load along every face and load factors over the torque; of a mesh alone load over the flank,
    transmission error over mesh cycle and load, stiffness, and stress in the roots."""
    from ...show.charts.flanks import contact_curves, contact_map, face_loads, load_factors, root_stress

    if "mesh" not in result.attrs:
        faces = Drawing(anchor="faces", figure=face_loads(result))
        factors = Drawing(anchor="factors", figure=load_factors(result))
        return [Section(anchor="contact", title="Teeth in contact in the train", parts=[faces, factors])]
    mesh = str(result.attrs["mesh"])
    words = (
        f"One mesh of the train, {mesh}. Others: epicyclic contact MODEL --mesh PAIR, "
        f"for instance planet-ring or {mesh.split('/')[0]}/planet-ring/1; all at once: without --mesh."
    )
    parts = [
        Drawing(anchor="flanks", figure=contact_map(result), caption=words),
        Drawing(anchor="contact", figure=contact_curves(result)),
        Drawing(anchor="roots", figure=root_stress(result)),
    ]
    return [Section(anchor="contact", title="Teeth in contact", parts=parts)]


def contact_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """The face-load factor at the operating load; of a mesh alone, whether tip edges bear."""
    at = _as_operated(result)
    factor = numbers(at, "face_load_factor")
    if not np.isfinite(factor).any():
        return [Finding(tone="", text="No load presses the teeth.", anchor="contact")]
    if "mesh" not in result.attrs:
        names, load = short_names(texts(result, "mesh")), at.largest_load_per_length.values / 1e3
        most, loaded = largest(factor), largest(load)
        beta = f"K_H beta up to {factor[most]:.2f} in {names[most]}"
        text = f"Largest load {load[loaded]:.0f} N/mm in {names[loaded]}; {beta}."
        return [Finding(tone="", text=text, anchor="contact")]
    overlap, mesh = float(np.nanmax(at.corner_overlap.values, initial=0.0)), result.attrs["mesh"]
    error = 1e6 * float(at.transmission_error_peak_to_peak)
    sizes = (
        f"transmission error {engineering(error, 3)} µm peak to peak, largest load "
        f"{float(np.nanmax(at.largest_load_per_length.values)) / 1e3:.0f} N/mm, largest pressure "
        f"{float(np.nanmax(at.largest_pressure.values)) / 1e6:.0f} MPa, K_H beta {float(np.nanmax(factor)):.2f}"
    )
    if overlap < _NO_OVERLAP:
        return [Finding(tone="good", text=f"No tip edge bears in {mesh}; {sizes}.", anchor="contact")]
    text = f"A tip edge bears in {mesh}: tips overlap by {1e6 * overlap:.1f} µm at the operating load; {sizes}."
    change = (
        "Relieve the tips by at least that much: epicyclic relief searches the relief. "
        'Dynamic forces count it where the mesh has stiffness = "contact".'
    )
    return [Finding(tone="caution", text=text, change=change, anchor="contact")]


def _as_operated(result: xr.Dataset) -> xr.Dataset:
    """The result at the operating load."""
    return result.isel(torque_factor=int(np.argmin(np.abs(result.torque_factor.values - 1.0))))


_OF_MESHES = {
    "mean_force": ("mean force [N]", 1.0),
    "least_force": ("least [N]", 1.0),
    "largest_force": ("largest [N]", 1.0),
    "face_load_factor": ("K_Hbeta", 1.0),
    "side_share": ("share of its side", 1.0),
    "shared_face": ("shared face [mm]", 1e3),
    "largest_load_per_length": ("largest load [N/mm]", 1e-3),
    "largest_pressure": ("largest pressure [MPa]", 1e-6),
    "average_stiffness": ("stiffness, tangent [N/µm]", 1e-6),
    "average_secant_stiffness": ("stiffness, secant [N/µm]", 1e-6),
    "overlap_before": ("tip overlap before [µm]", 1e6),
    "overlap_behind": ("tip overlap behind [µm]", 1e6),
    "root_stress_a": ("root stress a [MPa]", 1e-6),
    "root_stress_b": ("root stress b [MPa]", 1e-6),
}


def _contact_meshes(result: xr.Dataset) -> Table:
    """What is known of every mesh at the operating load."""
    attrs, at = result.attrs, _as_operated(result)
    at = at.assign({f"root_stress_{gear}": at.largest_root_stress.sel(mesh_gear=gear) for gear in ("a", "b")})
    if "mesh" in attrs:
        helix, torque = number(float(attrs["force"])), number(float(at.load_torque))
        title = f"Mesh {attrs['mesh']}, {helix} N a helix, {torque} N m on its first gear"
        at = at.assign({f"overlap_{end}": at.corner_overlap.sel(end=end) for end in ("before", "behind")})
    else:
        title, force = "Tooth contact in the train, at the operating torque", at.mesh_force
        at = at.assign(mean_force=force.mean("time"), least_force=force.min("time"), largest_force=force.max("time"))
    averaging = result.averaging_length.values
    lengths = " to ".join(dict.fromkeys(f"{1e3 * one:.3g}" for one in (averaging.min(), averaging.max()))) + " mm"
    used = _resolution(attrs, "phases" if "mesh" in attrs else "instants")
    lead = f"{used}; loads and pressures are means over {lengths} of contact line.{_errors(result)}"
    return Table(title=title, columns=columns_of(at, "mesh", _OF_MESHES), lead=lead)


def _roots(result: xr.Dataset) -> list[Table]:
    """Largest stresses in the roots of both gears of a mesh alone at the operating load."""
    if "root_stress" not in result:
        return []
    at, sides = _as_operated(result), texts(result, "side")
    gears = [str(result.attrs[f"gear_{one}"]) for one in texts(result, "mesh_gear")]
    places = result.tooth_place.values[result.root_stress.max("width").argmax("tooth_place").values]
    columns: dict[str, Any] = {
        "side": [side for side in sides for _ in gears],
        "gear": gears * len(sides),
        "tension [MPa]": list(at.largest_root_stress.values.ravel() / 1e6),
        "at a place of its contact [base pitches]": list(places.ravel()),
        "at a lean of the fillet of [deg]": list(np.degrees(result.root_stress_lean.values).ravel()),
        "compression [MPa]": list(at.lowest_root_stress.values.ravel() / 1e6),
    }
    return [Table(title="Stress in the tooth roots", columns=columns)]


def _resolution(attrs: Mapping[str, Any], instants: str = "phases") -> str:
    """Phases, or instants, and slices, and the error they leave."""
    error = float(attrs["estimated_error"])
    left = "" if np.isnan(error) else f", estimated error {100 * error:.2g} %"
    return f"{attrs['samples']} {instants} and {attrs['slices']} slices{left}"


def _errors(result: xr.Dataset) -> str:
    """Pitch and profile errors, and the mesh cycle they are shown in; empty without them."""
    attrs = result.attrs
    if "cycle" not in attrs:
        return ""
    parts = [f"pitch error {1e6 * float(attrs['pitch_error']):.4g} µm"] if attrs["pitch_error"] else []
    if attrs["profile_error"]:
        phase = np.degrees(float(attrs["profile_phase"]))
        parts.append(f"profile error {1e6 * float(attrs['profile_error']):.4g} µm at {phase:.4g} deg")
    parts += ["deviations of the file"] if attrs["deviations"] else []
    return f" With {', '.join(parts)}; the mesh cycle begins at {float(attrs['cycle']):.4g}."


def _loads(result: xr.Dataset) -> Table:
    """Load factors, transmission error and largest values over the load, as far as the result has them."""
    columns: dict[str, Any] = {"torque per operating": list(result.torque_factor.values)}
    if "branch_load_factor" in result:
        pairs = pair_names(texts(result, "mesh_pair"))
        columns |= {f"K_gamma {pair}": list(result.branch_load_factor.values[:, i]) for i, pair in enumerate(pairs)}
    if "mesh_load" in result:
        error = result.transmission_error_harmonic.values
        columns |= {
            "force of a helix [N]": list(result.mesh_load.values),
            "torque [N m]": list(result.load_torque.values),
            "mean error [µm]": list(error[:, 0].real * 1e6),
            "peak to peak [µm]": list(result.transmission_error_peak_to_peak.values * 1e6),
            **{f"order {k} [µm]": list(np.abs(error[:, k]) * 1e6) for k in (1, 2, 3)},
            "stiffness, tangent [N/µm]": list(result.average_stiffness.values.mean(axis=1) / 1e6),
        }
    columns["largest K_Hbeta"] = list(result.face_load_factor.values.max(axis=1))
    columns["largest load [N/mm]"] = list(result.largest_load_per_length.values.max(axis=1) / 1e3)
    if "largest_pressure" in result:
        columns["largest pressure [MPa]"] = list(result.largest_pressure.values.max(axis=1) / 1e6)
    title = "Loaded transmission error" if "mesh_load" in result else "Load factors over the torque"
    return Table(title=title, columns=columns)


# --- relief ----------------------------------------------------------------------------------------------------------

_SHOWN = 20  # solutions of a Pareto set


def relief_tables(result: xr.Dataset) -> Sequence[Table]:
    """The answer, the Pareto set where there are several objectives, and every mesh before and after."""
    front = [_front(result)] if result.sizes["objective"] > 1 else []
    return [_answer(result), _objectives(result), *front, _relieved_meshes(result)]


def relief_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The search, and error, load and force before and after."""
    from ...show.charts.flanks import relief_effect, relief_search

    search = Drawing(anchor="relief", figure=relief_search(result))
    effect = Drawing(anchor="relief-effect", figure=relief_effect(result))
    return [Section(anchor="relief", title="Relief", parts=[search, effect])]


def relief_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """What the answer gains in its first objective, and what to grind where that is worth it."""
    effect = relief_effect(result)
    what, gain = effect.what, effect.gain
    pairs = [split_name(str(name))[:2] for name in result.relieved_mesh.values]
    meshes = " and ".join(dict.fromkeys(pair_titles(pairs)))
    fall = f"{effect.before} to {effect.after}{effect.at}"
    if not gain > RELIEF_GAIN:
        text = f"The relief that was found makes the {what} of {meshes} no {100 * RELIEF_GAIN:g} % smaller ({fall})."
        return [Finding(tone="good", text=text, anchor="relief", value=gain, limit=RELIEF_GAIN)]
    text = f"The {what} of {meshes} falls from {fall}, {100 * gain:.0f} % less, by the relief that was found."
    found = result.solution_text.values[int(result.attrs["picked"])]
    picked = [f"{name} {value.replace('um', 'µm')}" for name, value in zip(result.variable.values, found, strict=True)]
    change = f"Grind {', '.join(picked)}."
    return [Finding(tone="caution", text=text, change=change, anchor="relief", value=gain, limit=RELIEF_GAIN)]


def _answer(result: xr.Dataset) -> Table:
    picked = int(result.attrs["picked"])
    candidates, generations = result.sizes["evaluation"], result.sizes["generation"]
    title = f"{result.attrs['method']}, {candidates} candidates in {generations} generations"
    names = [str(name) for name in result.variable.values]
    columns: dict[str, Any] = {
        "varied": names,
        "found": [str(text) for text in result.solution_text.values[picked]],
        "from": [_bound(name, value) for name, value in zip(names, result.lower_bound.values, strict=True)],
        "to": [_bound(name, value) for name, value in zip(names, result.upper_bound.values, strict=True)],
    }
    attrs = result.attrs  # a result of an earlier version says no error
    lead = f"Before and after: {_resolution(attrs)}." if "estimated_error" in attrs else ""
    return Table(title=title, columns=columns, lead=lead)


def _bound(name: str, value: float) -> str:
    """A bound with its unit; of shapes nothing."""
    if name.endswith("shape"):
        return ""
    return f"{number(value * 1e3)} mm" if name.endswith("length") else f"{number(value * 1e6)} µm"


def _objectives(result: xr.Dataset) -> Table:
    before, after = result.objective_before.values, result.objective_after.values
    units = [READ_IN[str(unit)] for unit in result.objective_unit.values]
    columns: dict[str, Any] = {
        "objective": [str(name) for name in result.objective.values],
        "what is made least": [str(text) for text in result.objective_meaning.values],
        "unit": [unit for _, unit in units],
        "before": [value * factor for value, (factor, _) in zip(before, units, strict=True)],
        "after": [value * factor for value, (factor, _) in zip(after, units, strict=True)],
        "change": [f"{100 * (b / a - 1):+.3g} %" if a else "" for a, b in zip(before, after, strict=True)],
    }
    return Table(title="Before and after", columns=columns)


def _front(result: xr.Dataset) -> Table:
    """The Pareto set, evenly thinned where it is long, the answer always among it."""
    count, picked = result.sizes["solution"], int(result.attrs["picked"])
    rows = np.unique([picked, *np.linspace(0, count - 1, min(count, _SHOWN)).round().astype(int)])
    units = [READ_IN[str(unit)] for unit in result.objective_unit.values]
    columns: dict[str, Any] = {"number": [f"{row}{' *' if row == picked else ''}" for row in rows]}
    for i, name in enumerate(result.variable.values):
        columns[str(name)] = [str(text) for text in result.solution_text.values[rows, i]]
    for i, (name, (factor, unit)) in enumerate(zip(result.objective.values, units, strict=True)):
        columns[f"{name} [{unit}]"] = list(result.solution_objective.values[rows, i] * factor)
    return Table(title=f"Pareto set, {len(rows)} of {count}; * the answer", columns=columns)


def _relieved_meshes(result: xr.Dataset) -> Table:
    swing, load = result.relieved_peak_to_peak.values * 1e6, result.relieved_largest_load.values / 1e3
    forces = np.outer(result.relieved_force.values, result.load_factor.values)
    columns: dict[str, Any] = {
        "mesh": [name for name in texts(result, "relieved_mesh") for _ in result.load_factor],
        "force of a helix [N]": list(forces.ravel()),
        "error before [µm]": list(swing[0].ravel()),
        "error after [µm]": list(swing[1].ravel()),
        "largest load before [N/mm]": list(load[0].ravel()),
        "largest load after [N/mm]": list(load[1].ravel()),
    }
    return Table(title="Peak to peak of the loaded transmission error, and load on the flank", columns=columns)


# --- efficiency ------------------------------------------------------------------------------------------------------

_MEMBERS = {
    "torque": ("torque [N m]", 1.0),
    "lossless_torque": ("without losses [N m]", 1.0),
    "power": ("power [kW]", 1e-3),
    "lossless_power": ("without losses [kW]", 1e-3),
}
_LEAD = "Losses of the meshes alone: bearings, seals and oil take more."


def efficiency_tables(result: xr.Dataset) -> Sequence[Table]:
    """Efficiency and power of the train, loaded members, meshes by pair and side, stages."""
    members = Table(title="Torques and power with losses", columns=columns_of(result, "member", _MEMBERS))
    return [_train(result), members, _mesh_losses(result), *_stages(result)]


def efficiency_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The losses by pair, the tables, and sliding along the path of contact."""
    from ...show.charts.flanks import mesh_losses, sliding

    bars: list[Part] = []
    if np.isfinite(result["power_loss"].values):
        caption = "Share of the power into the train."
        bars.append(Drawing(anchor="losses", figure=mesh_losses(result), caption=caption))
    caption = (
        "Zero is the pitch point; the tip of the first gear ends the path on the right. The load is that on one pair "
        "of teeth; of helical teeth it is a mean over mesh cycle and face."
    )
    path = Drawing(anchor="sliding", figure=sliding(result), caption=caption)
    return [Section(anchor="efficiency", title="Efficiency", parts=[*bars, *efficiency_tables(result), path])]


def efficiency_key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """Efficiency of the meshes [%] and the power they lose [kW]."""
    efficiency = float(result["train_efficiency"])
    if not np.isfinite(efficiency) or efficiency <= 0:
        return [("self-locking", f"friction in the meshes, {_friction(result)}")]
    loss = engineering(float(result["power_loss"]) / 1e3)
    words = f"efficiency of the meshes, {_friction(result)}: {loss} kW lost, without bearings, seals and oil"
    return [(f"{100 * efficiency:.2f} %", words)]


def efficiency_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """Efficiency of the meshes and where most is lost; whether friction locks the train."""
    efficiency = float(result["train_efficiency"])
    if not np.isfinite(efficiency) or efficiency <= 0:
        text = f"The train locks itself by friction, {_friction(result)}."
        return [Finding(tone="bad", text=text, anchor="efficiency")]
    losses = losses_of_pairs(texts(result, "mesh"), numbers(result, "mesh_power_loss"))
    stage, pair, most = max(losses, key=lambda row: row[2])
    total = float(result["power_loss"])
    where = f"{stage} {pair}" if result.sizes["stage"] > 1 else pair
    share = f", {100 * most / total:.0f} % of it in {where}" if total > 0 else ""
    text = f"The meshes lose {100 * (1 - efficiency):.2f} % of the power, {engineering(total / 1e3)} kW{share}."
    return [Finding(tone="", text=text, anchor="efficiency")]


def _train(result: xr.Dataset) -> Table:
    names = {"power_in": "power in [kW]", "power_loss": "lost in the meshes [kW]", "power_out": "power out [kW]"}
    columns = {"efficiency [%]": [100 * float(result["train_efficiency"])]}
    columns |= {heading: [float(result[name]) / 1e3] for name, heading in names.items()}
    return Table(title=f"Efficiency of the meshes, {_friction(result)}", columns=columns, lead=_LEAD)


def _friction(result: xr.Dataset) -> str:
    """How friction was stated: ``coefficient of friction 0.05``, or the oil with the range of coefficients."""
    options = json.loads(str(result.attrs.get("options", "{}")))
    values = numbers(result, "friction_coefficient")
    if "viscosity" not in options:
        return f"coefficient of friction {engineering(float(values.max()))}"
    low, high = (engineering(float(value), 2) for value in (values.min(), values.max()))
    oil = f"oil of {engineering(1e3 * options['viscosity'])} mPa s, Ra {engineering(1e6 * options['roughness'])} µm"
    return f"{oil}, coefficients of friction {low} to {high}"


def _mesh_losses(result: xr.Dataset) -> Table:
    """A row each pair and side: what its meshes have alike, and the sums of their power."""
    names = texts(result, "mesh")
    groups = by_pair_and_side(names)
    pairs = [str(name).split(".") for name in result["mesh_pair"].values]
    friction = dict(zip((f"{p[1]}/{p[-1]}" for p in pairs), numbers(result, "friction_coefficient"), strict=True))
    rolling, loss = numbers(result, "mesh_rolling_power"), numbers(result, "mesh_power_loss")
    factor, driver = numbers(result, "loss_factor"), texts(result, "driving_gear")
    several = len({p[1] for p in pairs}) > 1
    short = [(pair.replace("/", " ") if several else pair.split("/")[1], side) for pair, side in groups]
    columns: dict[str, Any] = {
        "mesh": [" ".join(words).strip() for words in short],
        "meshes": [len(meshes) for meshes in groups.values()],
        "driver": [driver[meshes[0]].split("/")[1] if driver[meshes[0]] else "" for meshes in groups.values()],
        "loss factor H_V": [float(factor[meshes[0]]) for meshes in groups.values()],
        "coefficient of friction": [float(friction[pair]) for pair, _ in groups],
        "rolling power [kW]": [float(rolling[meshes].sum()) / 1e3 for meshes in groups.values()],
        "lost [kW]": [float(loss[meshes].sum()) / 1e3 for meshes in groups.values()],
        "lost [% of power in]": [100 * float(loss[meshes].sum() / result["power_in"]) for meshes in groups.values()],
    }
    return Table(title="Meshes, all branches together (driver and power in the frame of the carrier)", columns=columns)


def _stages(result: xr.Dataset) -> list[Table]:
    """Losses by stage, of several."""
    if result.sizes["stage"] < 2:
        return []
    loss = numbers(result, "stage_power_loss")
    columns: dict[str, Any] = {
        "stage": texts(result, "stage"),
        "lost [kW]": [float(value) / 1e3 for value in loss],
        "lost [% of power in]": [100 * float(value / result["power_in"]) for value in loss],
    }
    return [Table(title="Stages", columns=columns)]


VIEWS = (
    ResultView("stiffness", 20, stiffness_tables, stiffness_sections, findings=stiffness_findings),
    ResultView("contact", 140, contact_tables, contact_sections, findings=contact_findings),
    ResultView("relief", 150, relief_tables, relief_sections, findings=relief_findings),
    ResultView(
        "efficiency",
        75,
        efficiency_tables,
        efficiency_sections,
        key_figures=efficiency_key_figures,
        findings=efficiency_findings,
    ),
)
