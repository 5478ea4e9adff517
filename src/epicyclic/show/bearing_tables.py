"""Tables of rolling bearings that are stated by their parts, alike in `check`, `static` and `life`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from .elements import Table
from .series import texts

_LOADS = {
    "bearing_load": ("equivalent load [kN]", 1e-3),
    "bearing_force_peak": ("largest radial force [kN]", 1e-3),
    "race_speed": ("speed [rpm]", 30 / np.pi),
    "turning_race": ("race that turns", None),
    "element_load": ("most loaded element [kN]", 1e-3),
    "element_place": ("at [deg]", 180 / np.pi),
    "element_pressure": ("pressure [MPa]", 1e-6),
    "load_zone_extent": ("loaded share", 1.0),
    "load_zone_angle": ("load zone [deg]", 180 / np.pi),
    "static_safety": ("static safety", 1.0),
    "bearing_stiffness": ("stiffness [N/µm]", 1e-6),
    "bearing_clearance": ("clearance in operation [µm]", 1e6),
    "clearance_origin": ("of", None),
}
_LARGEST = "Load zones are those under the largest force, the stiffness is that at the mean force."
NOMINAL = (
    "Under the nominal torques, shared evenly, without weight. Bearings share as equal springs on rigid shafts; "
    "a shaft that bends shares otherwise, and static has it."
)
_FREQUENCIES = {
    "cage_frequency": ("cage, in the housing [Hz]", 1.0),
    "outer_race_frequency": ("outer race [Hz]", 1.0),
    "inner_race_frequency": ("inner race [Hz]", 1.0),
    "element_frequency": ("element [Hz]", 1.0),
}


def bearing_tables(result: xr.Dataset, forces: str = _LARGEST) -> list[Table]:
    """Loads and frequencies of defects of every bearing, in every case; none without bearings by their parts.

    result : with the variables of `bearing_state`, (bearing, ...) or (bearing, case, ...).  forces : in words.
    """
    if "load_zone_extent" not in result:
        return []
    load = result["element_load"]
    most = (load >= (1 - 1e-9) * load.max("element")).argmax("element")  # of equal ones the first
    zone = 2 * np.arccos(1 - 2 * result["load_zone_extent"].clip(0.0, 1.0))
    place = result["element_angle"].isel(element=most)
    result = result.assign(
        element_load=result["element_load"].max("element"), element_place=place, load_zone_angle=zone
    )
    keys = {"operation.speed": "race_speed", "operation.torque": "bearing_force_peak"}
    missing = [key for key, name in keys.items() if result[name].isnull().all()]
    lead = f"{forces} Angles count from x of the link."
    if missing:
        lead += f" What is empty needs {' and '.join(missing)}."
    return [
        Table(title="Loads of bearings", columns=_rows(result, _LOADS), digits=4, lead=lead),
        Table(title="Frequencies of bearings", columns=_rows(result, _FREQUENCIES)),
    ]


def _rows(result: xr.Dataset, names: Mapping[str, tuple[str, float | None]]) -> dict[str, Any]:
    """Columns of variables (bearing,) or (bearing, case), a row each."""
    bearings, cases = texts(result, "bearing"), texts(result, "case") if "case" in result.dims else [""]
    columns: dict[str, Any] = {"bearing": [name for name in bearings for _ in cases]}
    if len(cases) > 1:
        columns["case"] = cases * len(bearings)
    for name, (heading, scale) in names.items():
        if name in result:
            flat = result[name].broadcast_like(result["race_speed"]).transpose("bearing", ...).values.ravel()
            columns[heading] = list(flat) if scale is None else list(scale * flat.astype(float))
    return columns
