"""Dataset -> HTML table: what a figure cannot say to three digits."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape

import numpy as np
import xarray as xr

from .energy import gathered
from .members import members_of
from .series import engineering, numbers, short_names, texts
from .sharing import readable

__all__ = [
    "gear_table",
    "member_table",
    "mesh_table",
    "mode_table",
    "record_table",
    "sharing_table",
    "stage_table",
    "table",
    "value_table",
]


def table(head: Sequence[str], rows: Sequence[Sequence[str]], *, caption: str, words: int = 1) -> str:
    """An HTML table whose first `words` columns are text and whose others are numbers.

    Columns that are empty in every row are left out.
    """
    kept = [place for place in range(len(head)) if place < words or any(row[place] for row in rows)]
    titles = "".join(f'<th scope="col"{_numeric(place, words)}>{escape(head[place])}</th>' for place in kept)
    body = "".join(
        "<tr>" + "".join(f"<td{_numeric(place, words)}>{escape(row[place])}</td>" for place in kept) + "</tr>"
        for row in rows
    )
    title = f"<caption>{escape(caption)}</caption>" if caption else ""
    return f'<div class="table"><table>{title}<thead><tr>{titles}</tr></thead><tbody>{body}</tbody></table></div>'


def _numeric(place: int, words: int) -> str:
    return "" if place < words else ' class="number"'


def _short(value: float, factor: float = 1.0, digits: int = 5) -> str:
    return engineering(factor * float(value), digits)


def member_table(check: xr.Dataset) -> str:
    """Speed, torque, power, mass and inertia of every member."""
    rows = [
        [
            one.name,
            one.kind,
            str(one.count),
            _short(one.speed),
            _short(one.torque, 1e-3),
            _short(one.power, 1e-3),
            _short(one.mass),
            _short(one.inertia),
        ]
        for one in members_of(check)
    ]
    head = ["member", "kind", "bodies", "speed [rpm]", "external torque [kN m]", "power [kW]", "mass [kg]"]
    return table(
        [*head, "inertia [kg m²]"],
        rows,
        caption="Members (mass of one body)",
        words=2,
    )


def gear_table(check: xr.Dataset) -> str:
    """Geometry of every gear, one row a member."""
    member = dict(zip(texts(check, "body"), texts(check, "member", "body"), strict=True))
    seen: dict[str, int] = {}
    for place, name in enumerate(texts(check, "gear")):
        seen.setdefault(member.get(name, name), place)
    columns = [
        ("module [mm]", "module", 1e3),
        ("helix [deg]", "helix_angle", 180 / np.pi),
        ("shift [-]", "profile_shift", 1.0),
        ("face width [mm]", "face_width", 1e3),
        ("base radius [mm]", "base_radius", 1e3),
        ("reference [mm]", "reference_radius", 1e3),
        ("tip [mm]", "tip_radius", 1e3),
        ("root [mm]", "root_radius", 1e3),
    ]
    teeth, hand = numbers(check, "teeth", "gear"), numbers(check, "hand", "gear")
    values = [[_short(value, factor) for value in numbers(check, name, "gear")] for _, name, factor in columns]
    rows = [
        [name, {1: "right", -1: "left"}.get(int(np.nan_to_num(hand[at])), "spur"), f"{teeth[at]:.0f}"]
        + [column[at] for column in values]
        for name, at in seen.items()
    ]
    head = ["gear", "hand", "teeth", *[title for title, _, _ in columns]]
    return table(head, rows, caption="Gears; hand of the left helix, width of one helix", words=2)


def mesh_table(check: xr.Dataset, stiffness: xr.Dataset | None = None) -> str:
    """Phase, contact ratios and mean stiffness of every mesh."""
    names = texts(check, "mesh")
    mean = numbers(check, "mean_mesh_stiffness", "mesh")
    if stiffness is not None and "mean_mesh_stiffness" in stiffness.variables:
        given = dict(zip(texts(stiffness, "mesh"), numbers(stiffness, "mean_mesh_stiffness"), strict=True))
        mean = np.array([given.get(name, value) for name, value in zip(names, mean, strict=True)])
    columns = [
        (numbers(check, "phase_lead", "mesh"), 1.0),
        (numbers(check, "working_pressure_angle", "mesh"), 180 / np.pi),
        (numbers(check, "contact_ratio", "mesh"), 1.0),
        (numbers(check, "overlap_ratio", "mesh"), 1.0),
        (mean, 1e-6),
    ]
    rows = [
        [label, *[_short(values[at], factor) for values, factor in columns]]
        for at, label in enumerate(short_names(names))
    ]
    head = ["mesh", "phase lead [cycles]", "working angle [deg]", "contact ratio [-]", "overlap ratio [-]"]
    return table([*head, "mean stiffness [N/µm]"], rows, caption="Meshes; stiffness along the tooth normal")


def stage_table(check: xr.Dataset) -> str:
    """Mesh frequency, centre distance and hunting period of every stage."""
    columns = [("planets", 1.0), ("mesh_frequency", 1.0), ("centre_distance", 1e3), ("hunting_period", 1.0)]
    values = [(numbers(check, name, "stage"), factor) for name, factor in columns]
    rows = [
        [name, *[_short(column[at], factor, 7) for column, factor in values]]
        for at, name in enumerate(texts(check, "stage"))
    ]
    head = ["stage", "branches", "mesh frequency [Hz]", "centre distance [mm]", "hunting period [mesh cycles]"]
    return table(head, rows, caption="Stages")


def mode_table(modes: xr.Dataset) -> str:
    """Every mode: frequency, kind, multiplicity, damping, and what holds most of its energies."""
    hertz, count = numbers(modes, "frequency"), numbers(modes, "multiplicity", "mode")
    damping, kinds = numbers(modes, "damping_ratio", "mode"), texts(modes, "mode_kind", "mode")
    strain, kinetic = (
        gathered(texts(modes, dim), modes[name].transpose(dim, "mode").values)
        if name in modes.variables
        else ([], None)
        for name, dim in (("strain_energy_share", "connection"), ("kinetic_energy_share", "body"))
    )
    rows = []
    for at in range(len(hertz)):
        words = [str(at + 1), kinds[at], _main(strain, at), _main(kinetic, at)]
        rows.append([*words, _short(hertz[at]), _short(count[at]), _short(damping[at])])
    head = ["mode", "kind", "most strain energy", "most kinetic energy"]
    head += ["frequency [Hz]", "multiplicity", "damping [-]"]
    return table(head, rows, caption="Modes", words=4)


def _main(shares: tuple[list[str], np.ndarray[tuple[int, ...], np.dtype[np.float64]] | None], mode: int) -> str:
    names, values = shares
    if values is None or not np.isfinite(values[:, mode]).all() or not values[:, mode].any():
        return ""
    most = int(np.argmax(values[:, mode]))
    return f"{names[most]} {100 * values[most, mode]:.0f} %"


def sharing_table(sharing: xr.Dataset) -> str:
    """Load-sharing coefficients of every mesh by every definition, the train's in the last row."""
    values = sharing["load_sharing"].transpose("mesh", "definition").values
    lost = numbers(sharing, "contact_lost", "mesh")
    rows = [
        [label, *[f"{value:.4f}" if np.isfinite(value) else "" for value in row], "lost" if gone > 0 else ""]
        for label, row, gone in zip(short_names(texts(sharing, "mesh")), values, lost, strict=True)
    ]
    whole = numbers(sharing, "system_load_sharing", "definition")
    rows.append(["whole train", *[f"{value:.4f}" if np.isfinite(value) else "" for value in whole], ""])
    head = ["mesh", *[readable(name) for name in texts(sharing, "definition")], "contact"]
    return table(head, rows, caption="Load-sharing coefficients by definition")


def value_table(text: str) -> str:
    """Every resolved value of the model, its unit and its origin, from the JSON list of `check`."""
    rows = [[str(cell) if cell is not None else "" for cell in row] for row in json.loads(text)]
    shown = [[path, _number(value), unit, origin] for path, value, unit, origin in rows]
    return table(["value", "", "unit", "origin"], shown, caption="", words=4)


def _number(text: str) -> str:
    try:
        return engineering(float(text), 7)
    except ValueError:
        return text


def record_table(text: str, head: Sequence[str]) -> str:
    """A JSON object as a table of two columns of words."""
    return table(head, [[str(key), str(value)] for key, value in json.loads(text).items()], caption="", words=2)
