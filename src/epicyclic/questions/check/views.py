"""Views of `check` and `matrices`: what a train is, and its mean linear system."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...show.brief_check import brief_tables, check_over_cases, driven_kinds, locked_words, power_ends, ratio_of
from ...show.elements import (
    Company,
    Drawing,
    Finding,
    KeyFigure,
    Part,
    Section,
    Styled,
    Table,
    assumed_tables,
    columns_of,
    value_tables,
)
from ...show.part_tables import NOMINAL, bearing_tables, ring_tables
from ...show.series import Member, engineering, grouped, members_of, mesh_tones, numbers, short_names, texts
from ...show.views import ResultView, in_section

# --- check -----------------------------------------------------------------------------------------------------------

_DEGREES = 180 / np.pi
_UNITS = {"x": "N/m", "y": "N/m", "z": "N/m", "rx": "N m/rad", "ry": "N m/rad", "rz": "N m/rad"}
# SI unit: unit of the drawing, factor
_DRAWN = {
    "m": ("µm", 1e6),
    "rad": ("mrad", 1e3),
    "N/m": ("N/µm", 1e-6),
    "N/m^2": ("N/(mm µm)", 1e-9),
    "N m": ("kN m", 1e-3),
}
_BODIES = {
    "kind": ("kind", 1),
    "speed": ("speed [rpm]", 1),
    "torque": ("torque [N m]", 1),
    "power": ("power [kW]", 1e-3),
    "mass": ("mass [kg]", 1),
    "inertia": ("inertia [kg m2]", 1),
    "station": ("station [mm]", 1e3),
    "axes_angle": ("angle [deg]", _DEGREES),
}
_GEARS = {
    "module": ("module [mm]", 1e3),
    "helix_angle": ("helix [deg]", _DEGREES),
    "profile_shift": ("shift [-]", 1.0),
    "face_width": ("face width [mm]", 1e3),
    "base_radius": ("base radius [mm]", 1e3),
    "reference_radius": ("reference radius [mm]", 1e3),
    "tip_radius": ("tip radius [mm]", 1e3),
    "root_radius": ("root radius [mm]", 1e3),
}
_MESHES = "Meshes (stiffness, force and backlash along the tooth normal)"
_PATHS = {
    "path_from": ("from", 1),
    "path_to": ("to", 1),
    "path_torque": ("torque [N m]", 1),
    "path_power": ("power [kW]", 1e-3),
    "path_share": ("share of the input [%]", 100),
    "path_rolling_power": ("rolling power [kW]", 1e-3),
    "path_circulating": ("circulates", 1),
}

_FRONT = "Seen from the right end; teeth as they stand at time zero."
_APART = (
    " Stages stand side by side to be seen: how they lie to each other is not in the model, mostly behind each other "
    "on one axis."
)
_SECTION = (
    "Through the axis and branch 1, branches turned into the plane; below the axis the second axis of a branch with "
    "two. Gears end at their pitch circles. A support in the middle of its member is drawn on the shaft that shows, "
    "others where they stand; shafts, couplings and what lies between stages are a scheme."
)


def check_tables(result: xr.Dataset) -> Sequence[Table]:
    """Stages, bodies, gears, meshes; frequencies, power paths, links; choices; needs of verbs; every resolved value."""
    found = [
        _stages(result),
        Table(title="Bodies", columns=columns_of(result, "body", _BODIES)),
        _gears(result, texts(result, "gear")),
        _meshes(result, texts(result, "mesh")),
    ]
    if result.sizes.get("order_name"):
        orders = {"order_frequency": ("frequency [Hz]", 1), "order": ("mesh orders", 1)}
        found.append(Table(title="Shaft and mesh frequencies", columns=columns_of(result, "order_name", orders)))
    found += driven_kinds(result)
    if "path_power" in result.variables and numbers(result, "path_power").any():
        title = "Power paths (from first to second, seen from the housing; rolling: seen from the carrier)"
        found.append(Table(title=title, columns=columns_of(result, "path", _PATHS)))
    return [
        *found,
        *_deviations(result),
        *_tolerances(result),
        _links(result),
        *_spans(result),
        *ring_tables(result),
        *bearing_tables(result, NOMINAL),
        *_choices(result),
        *_readiness(result),
        *assumed_tables(result),
        *value_tables(result),
    ]


def check_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The drawings with stages and gears; speeds, torques and power; meshes, with their stiffness where it is known."""
    return [
        Section(anchor="train", title="Train", parts=_train(result)),
        Section(anchor="operation", title="Speeds and torques", parts=_operation(result)),
        Section(anchor="meshes", title="Meshes", parts=_mesh_parts(result, company.get("stiffness"))),
    ]


def check_key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """Power through the train [kW], mesh frequencies [Hz], speeds of the members that turn about the axis [rpm]."""
    members = members_of(result)
    powers = [one.power for one in members if np.isfinite(one.power) and one.power > 0]
    found = [(f"{engineering(sum(powers) / 1e3)} kW", "power through the train")] if powers else []
    found += [(f"{engineering(tone, 6)} Hz", f"mesh frequency, {stage}") for stage, tone in mesh_tones(result).items()]
    turning = _turning(members)
    by_speed = grouped((one.speed for one in turning), (one.name for one in turning))
    return found + [
        (f"{engineering(speed, 6)} rpm", f"speed of {', '.join(names)}: {engineering(speed * np.pi / 30, 5)} rad/s")
        for speed, names in by_speed.items()
    ]


def check_headline(result: xr.Dataset) -> str:
    """Ratio, power, speeds and stages in one sentence, as far as the model says them."""
    members = members_of(result)
    driving, driven = power_ends(members)
    said = [text.rstrip(".")] if (text := locked_words(result)) else []
    if driving is not None:
        said.append(f"ratio {ratio_of(driving, driven[0])}")
        said.append(f"{engineering(driving.power / 1e3)} kW")
        said.append(f"{_turns(driving)} drives {_turns(driven[0])}")
    elif turning := _turning(members):
        said.append(", ".join(map(_turns, turning)))
    said += _teeth(result)
    text = "; ".join(said)
    return f"{text[0].upper()}{text[1:]}." if text else ""


def check_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """What is wrong with the drawing itself, each warning once; what the model did not allow is none."""
    said = [str(text) for text in json.loads(str(result.attrs.get("warnings", "[]")))]
    sentences = [text.rsplit(" [", 1)[0] if text.endswith("]") else text for text in said if ":" in text]  # no codes
    return [Finding(tone="caution", text=text, anchor="warnings") for text in sentences]


def _turning(members: Sequence[Member]) -> list[Member]:
    return [one for one in members if one.count == 1 and np.isfinite(one.speed) and one.speed != 0]


def _turns(one: Member) -> str:
    """``sun (100 rpm)``."""
    return f"{one.name.removeprefix('main.')} ({engineering(one.speed)} rpm)"


def _teeth(check: xr.Dataset) -> list[str]:
    """``differential: z = 37, 149, 56, 3 branches``, of every stage."""
    if "gear" not in check.dims:
        return []
    gears, teeth = _by_member(check), numbers(check, "teeth", "gear")
    found: dict[str, dict[str, int]] = {}
    for name, z in zip(gears, teeth, strict=True):
        found.setdefault(name.split(".")[0], {}).setdefault(name, int(z))
    branches = dict(zip(texts(check, "stage", "stage"), numbers(check, "planets", "stage"), strict=True))
    several = len(found) > 1
    return [
        f"{f'{stage}: ' if several else ''}"
        + ", ".join(f"{name.split('.')[-1]} z = {z}" for name, z in own.items())
        + (f", {int(branches[stage])} branches" if np.isfinite(branches.get(stage, np.nan)) else "")
        for stage, own in found.items()
    ]


def _train(check: xr.Dataset) -> list[Part]:
    from ...show.drawing.painter import train_front, train_section

    if "gear" not in check.dims or not check.sizes["gear"]:
        return []
    apart = _APART if len({name.split("/")[0] for name in texts(check, "gear")}) > 1 else ""
    return [
        Drawing(anchor="front", figure=train_front(check), caption=_FRONT + apart),
        Drawing(anchor="section", figure=train_section(check), caption=_SECTION),
        _stages(check),
        _gears(check, _by_member(check), "Gears; hand of the left helix, width of one helix"),
    ]


def _operation(check: xr.Dataset) -> list[Part]:
    from ...show.charts.train import members, orders

    parts: list[Part] = []
    if np.isfinite(check["speed"].values).any() or np.isfinite(check["torque"].values).any():
        caption = "Counter-clockwise positive; power into the train positive."
        parts.append(Drawing(anchor="members", figure=members(check), caption=caption))
    parts.append(_members(check))
    if check.sizes.get("order_name", 0):
        parts.append(Drawing(anchor="orders", figure=orders(check)))
    return [*parts, *ring_tables(check)[:1], *bearing_tables(check, NOMINAL)]


def _mesh_parts(check: xr.Dataset, stiffness: xr.Dataset | None) -> list[Part]:
    from ...show.charts.train import SERIES, mesh_stiffness, phases

    parts: list[Part] = []
    if "phase_lead" in check.variables and np.isfinite(check["phase_lead"].values).any():
        caption = "One turn of a dial is one mesh cycle; a branch that points clockwise of another meshes earlier."
        parts.append(Drawing(anchor="phases", figure=phases(check), caption=caption))
    if stiffness is not None:
        parts.append(Drawing(anchor="stiffness", figure=mesh_stiffness(stiffness), caption=SERIES))
    names = short_names(texts(check, "mesh"))
    return [*parts, _meshes(check, names, stiffness, "Meshes; stiffness, force and backlash along the tooth normal")]


def _stages(check: xr.Dataset) -> Table:
    columns = {
        "planets": ("branches", 1),
        "mesh_frequency": ("mesh frequency [Hz]", 1),
        "centre_distance": ("centre distance [mm]", 1e3),
        "hunting_period": ("hunting period [mesh cycles]", 1),
        "k_gamma_limit": ("K_gamma limit [-]", 1),
    }
    table = columns_of(check, "stage", columns)
    return Table(title="Stages", columns={**table, "of": texts(check, "k_gamma_limit_source", "stage")}, digits=7)


def _members(check: xr.Dataset) -> Table:
    """Speed, torque, power, mass and inertia of every member."""
    found = members_of(check)
    columns: dict[str, Any] = {
        "member": [one.name for one in found],
        "kind": [one.kind for one in found],
        "bodies": [one.count for one in found],
        "speed [rpm]": [one.speed for one in found],
        "external torque [kN m]": [one.torque * 1e-3 for one in found],
        "power [kW]": [one.power * 1e-3 for one in found],
        "mass [kg]": [one.mass for one in found],
        "inertia [kg m²]": [one.inertia for one in found],
    }
    return Table(title="Members (mass of one body)", columns=columns)


def _by_member(check: xr.Dataset) -> list[str]:
    """Member of every gear, the name of the gear where no body is known."""
    member = dict(zip(texts(check, "body"), texts(check, "member", "body"), strict=True))
    return [member.get(name, name) for name in texts(check, "gear")]


def _gears(check: xr.Dataset, names: Sequence[str], title: str = "Gears") -> Table:
    """Geometry of the first gear of every name."""
    rows = [names.index(name) for name in dict.fromkeys(names)]
    hand = np.nan_to_num(numbers(check, "hand", "gear"))[rows]
    columns: dict[str, Any] = {
        "gear": [names[row] for row in rows],
        "hand": [{1: "right", -1: "left"}.get(int(value), "spur") for value in hand],
        "teeth": [int(value) for value in numbers(check, "teeth", "gear")[rows]],
    }
    for name, (heading, factor) in _GEARS.items():
        columns[heading] = list(factor * numbers(check, name, "gear")[rows])
    return Table(title=title, columns=columns)


def _meshes(
    check: xr.Dataset, names: Sequence[str], stiffness: xr.Dataset | None = None, title: str = _MESHES
) -> Table:
    """Phase, contact ratios and mean stiffness of every mesh, that of `stiffness` where it is known."""
    mean = numbers(check, "mean_mesh_stiffness", "mesh")
    if stiffness is not None and "mean_mesh_stiffness" in stiffness.variables:
        given = dict(zip(texts(stiffness, "mesh"), numbers(stiffness, "mean_mesh_stiffness"), strict=True))
        mean = np.array([given.get(name, value) for name, value in zip(texts(check, "mesh"), mean, strict=True)])
    columns = {
        "mesh": list(names),
        "phase lead [cycles]": list(numbers(check, "phase_lead", "mesh")),
        "working angle [deg]": list(_DEGREES * numbers(check, "working_pressure_angle", "mesh")),
        "contact ratio [-]": list(numbers(check, "contact_ratio", "mesh")),
        "overlap ratio [-]": list(numbers(check, "overlap_ratio", "mesh")),
        "mean stiffness [N/µm]": list(1e-6 * mean),
        "tangent at a force of [N]": list(numbers(check, "tangent_load", "mesh")),
    }
    if np.isfinite(numbers(check, "backlash", "mesh")).any():
        columns["backlash [µm]"] = list(1e6 * numbers(check, "backlash", "mesh"))
    return Table(title=title, columns=columns)


def _deviations(result: xr.Dataset) -> list[Table]:
    """What each deviation shows in each mesh."""
    if not result.sizes.get("mesh_deviation"):
        return []
    columns: dict[str, Any] = {
        "deviation": texts(result, "deviation_path", "mesh_deviation"),
        "mesh": texts(result, "deviation_mesh", "mesh_deviation"),
        "amplitude [µm]": list(1e6 * numbers(result, "deviation_amplitude")),
        "phase [deg]": list(_DEGREES * numbers(result, "deviation_phase")),
        "frequency [Hz]": list(numbers(result, "deviation_frequency")),
    }
    title = (
        "Deviations in the meshes (opening of the loaded flanks along the tooth normal, a cosine; of a displaced seat "
        "as if the body followed it)"
    )
    return [Table(title=title, columns=columns)]


def _tolerances(result: xr.Dataset) -> list[Table]:
    """What the drawing lets vary, in the units of drawings."""
    if "tolerance_std" not in result.variables:
        return []
    scale = [_DRAWN.get(unit, (unit, 1.0)) for unit in texts(result, "tolerance_unit", "toleranced")]
    factors = np.array([factor for _, factor in scale])
    columns: dict[str, Any] = {
        "path": texts(result, "tolerance_path", "toleranced"),
        "distribution": texts(result, "tolerance_distribution", "toleranced"),
        "mean": list(factors * numbers(result, "tolerance_mean")),
        "deviation": list(factors * numbers(result, "tolerance_std")),
        "unit": [unit or "1" for unit, _ in scale],
        "drawn": texts(result, "tolerance_part", "toleranced"),
        "draws": [int(value) for value in numbers(result, "tolerance_draws")],
    }
    return [Table(title="Tolerances (standard deviation, of a vector that of each component)", columns=columns)]


def _links(result: xr.Dataset) -> Table:
    columns: dict[str, Any] = {"link": texts(result, "link")}
    for direction, stiffness in zip(texts(result, "direction"), result.link_stiffness.values.T, strict=True):
        columns[f"{direction} [{_UNITS[direction]}]"] = list(stiffness)
    columns["clearance [µm]"] = [1e6 * value or np.nan for value in numbers(result, "link_clearance", "link")]
    return Table(title="Supports, bearings, couplings (inf = rigid)", columns=columns)


def _spans(result: xr.Dataset) -> list[Table]:
    """Spans of the shafts that bend, with the stiffness of their links at the elastic centre."""
    if "span_start" not in result.variables:
        return []
    links = result.sel(link=result["span"].values)
    columns: dict[str, Any] = {
        "span": texts(result, "span"),
        **{
            f"{end} [mm]": list(1e3 * numbers(result, f"span_{name}"))
            for end, name in (("from", "start"), ("to", "end"))
        },
        "elastic centre [mm]": list(1e3 * numbers(links, "link_station", "link")),
        "mass [kg]": list(numbers(result, "span_mass")),
    }
    for heading, direction in (("lateral [N/m]", "x"), ("bending [N m/rad]", "rx"), ("torsion [N m/rad]", "rz")):
        columns[heading] = list(links["link_stiffness"].sel(direction=direction).values)
    columns["lowest bending mode [Hz]"] = list(numbers(result, "span_frequency"))
    columns["per mesh frequency [-]"] = list(numbers(result, "span_frequency_ratio"))
    return [Table(title="Shafts that bend, between their supports (mode with clamped ends)", columns=columns)]


def _choices(result: xr.Dataset) -> list[Table]:
    """What the file says, or leaves to a default, of tilt and slices, and what that does."""
    if "choice_value" not in result.variables:
        return []
    names = {"choice_value": "is", "choice_origin": "from", "choice_effect": "what it does"}
    columns: dict[str, Any] = {"key": texts(result, "choice")}
    columns |= {heading: texts(result, name, "choice") for name, heading in names.items()}
    return [Table(title="Choices that matter", columns=columns)]


def _readiness(result: xr.Dataset) -> list[Table]:
    """Every verb and what it still needs: paths in the rows, each message once below."""
    if "verb_needs" not in result.variables:
        return []
    needs = [text.split("\n") if text else [] for text in texts(result, "verb_needs", "verb_name")]
    said = list(dict.fromkeys(text for texts in needs for text in texts))
    columns: dict[str, Any] = {
        "verb": [name.replace("_", "-") for name in texts(result, "verb_name")],
        "state": [
            Styled(text=f"needs {', '.join(str(said.index(text) + 1) for text in own)}", tone="caution")
            if own
            else Styled(text="ready", tone="good")
            for own in needs
        ],
    }
    return [Table(title="What each verb still needs, with default options", columns=columns, notes=tuple(said))]


# --- matrices --------------------------------------------------------------------------------------------------------

_MATRICES = ("M", "C", "G", "K", "B", "L", "T", "F", "excitation", "gap_error")


def matrices_tables(result: xr.Dataset) -> Sequence[Table]:
    """Every matrix with its size, every coordinate with its unit, meshes and ports with their numbers."""
    names = [name for name in _MATRICES if name in result.variables]
    sizes: dict[str, Any] = {
        "matrix": names,
        "rows": [result[name].shape[0] for name in names],
        "columns": [result[name].shape[1] for name in names],
        "meaning": [str(result[name].attrs.get("long_name", "")) for name in names],
    }
    coordinates: dict[str, Any] = {
        "row": list(range(1, result.sizes["dof"] + 1)),
        "coordinate": [str(name) for name in result["dof"].values],
        "unit": [str(unit) for unit in result["coordinate_unit"].values],
        "load": [str(unit) for unit in result["load_unit"].values],
    }
    meshes: dict[str, Any] = {
        "mesh row": [str(name) for name in result["mesh_row"].values],
        "mean stiffness [N/m]": list(result["mesh_stiffness"].values),
        "damping [N s/m]": list(result["mesh_damping"].values),
    }
    ports: dict[str, Any] = {
        "port": [str(name) for name in result["port"].values],
        "operating torque [N m]": list(result["port_torque"].values),
    }
    lead = "M q'' + (C + G) q' + K q = F u + B (k e + c e') + load"
    return [
        Table(title="Mean linear system", columns=sizes, lead=lead),
        Table(title="Coordinates", columns=coordinates),
        Table(title="Meshes", columns=meshes),
        Table(title="Ports", columns=ports),
    ]


VIEWS = (
    ResultView(
        "check",
        10,
        check_tables,
        check_sections,
        brief=brief_tables,
        key_figures=check_key_figures,
        findings=check_findings,
        headline=check_headline,
        over_cases=check_over_cases,
    ),
    ResultView("matrices", 890, matrices_tables, in_section("matrices", "Mean linear system", matrices_tables)),
)
