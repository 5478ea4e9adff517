"""A resolved train back as a model file: every value written out; resolving that gives the same train."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from typing import Any

from ..train.bodies import DIRECTIONS
from ..train.train import Derived, Train

__all__ = ["resolved_document"]

_GEAR = (
    *("teeth", "base_radius", "module", "pressure_angle", "helix_angle", "hand", "profile_shift", "herringbone"),
    *("split", "gap", "face_width", "tip_diameter", "root_diameter", "mass", "inertia", "tilt_inertia", "pin_radius"),
)
_MESH = ("pressure_angle", "centre_distance", "stiffness", "phase", "variation", "slices")
_BODY = ("mass", "inertia", "tilt_inertia", "station")


def resolved_document(train: Train) -> dict[str, Any]:
    """Model file with every resolved value in it, as nested tables of plain values in SI.

    Resolving it again gives the same train; `model.toml_writer.to_toml` writes it as text.
    """
    data: dict[str, Any] = copy.deepcopy(dict(train.document))
    for value in train.values:
        if _is_key(value, train, data):
            _put(data, value.path.split("."), _plain(value.value))
    _set_directions(data)
    _keep_contact(data)
    return data


def _is_key(value: Derived, train: Train, data: Mapping[str, Any]) -> bool:
    """Whether a value may stand in a file, beside what the file states already."""
    parts = value.path.split(".")
    if isinstance(value.value, float) and math.isnan(value.value):
        return False
    if parts[0] == "bodies" and len(parts) == 3:
        return parts[-1] in _BODY
    if parts[0] in ("bodies", "couplings"):
        return parts[-1] in DIRECTIONS
    if parts[0] != "stages" or len(parts) < 4:
        return False
    if parts[2] == "meshes":
        if parts[-2:] == ["stiffness", "load"]:  # of a table of force
            return True
        return parts[-1] in _MESH and (parts[-1] != "centre_distance" or _free_distance(parts, train))
    if parts[-1] == "module":
        table = data["stages"][parts[1]].get(parts[2], {})
        return value.origin != "base radii" and "transverse_module" not in table
    return parts[-1] in DIRECTIONS or parts[-1] in _GEAR


def _free_distance(parts: list[str], train: Train) -> bool:
    """Whether the distance of a pair follows from no pin radius: two planet gears, or two gears on fixed axes."""
    kinds = {b.member.split(".")[-1]: b.kind for b in train.bodies if b.member.startswith(f"{parts[1]}.")}
    return len({kinds[name] == "planet" for name in parts[3].split("-")}) == 1


def _put(data: dict[str, Any], path: list[str], value: object) -> None:
    """Set the value at a path of nested tables, which are made where they are missing."""
    here = data
    for name in path[:-1]:
        here = here.setdefault(name, {})
    here[path[-1]] = value


def _plain(value: object) -> object:
    """A value as a file states it: infinity as a word, a list of one as its entry."""
    if isinstance(value, (list, tuple)):
        entries = [_plain(entry) for entry in value]
        return entries[0] if len(entries) == 1 else entries
    return "inf" if value == math.inf else value


def _keep_contact(data: Mapping[str, Any]) -> None:
    """Meshes of loaded contact stay so: their tangent alone would be another law."""
    for stage in data["stages"].values():
        for mesh in stage.get("meshes", {}).values():
            for table in (mesh, mesh.get("left", {}), mesh.get("right", {})):
                if table.get("variation", mesh.get("variation")) == "contact" and "stiffness" in table:
                    table["stiffness"] = "contact"
            for table in (mesh, mesh.get("left", {}), mesh.get("right", {})):
                if table.get("variation") == "contact":
                    del table["variation"]


def _set_directions(data: Mapping[str, Any]) -> None:
    """Stiffnesses are written along the tooth normal, tables of force as they are given."""
    for stage in data["stages"].values():
        for mesh in stage.get("meshes", {}).values():
            own = mesh.get("direction")
            for table in (mesh, mesh.get("left", {}), mesh.get("right", {})):
                stated = table.get("direction", own)
                if stated is not None and (table is mesh or "stiffness" in table or "direction" in table):
                    tabulated = isinstance(table.get("stiffness", mesh.get("stiffness")), dict)
                    table["direction"] = stated if tabulated else "normal"
