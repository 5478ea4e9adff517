"""Tables of parts that several results have: rolling bearings that are stated by their parts, alike in `check`,
`static` and `life`; rings that bend, section, orders and natural frequencies of `check`, deflection of `static` and
`steady`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from .elements import Table, columns_of, named_columns
from .series import bent_rows, texts

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


_STILL = 1e-3  # a mean of an order below this part of its amplitude has no place
_SECTION = {
    "ring_radius": ("centre line R [mm]", 1e3),
    "ring_bending": ("E I [kN m2]", 1e-3),
    "ring_line_mass": ("mass [kg/m]", 1.0),
    "ring_orders": ("orders up to n", 1.0),
    "ring_left_out": ("left out per mesh [%]", 100.0),
    "ring_first": ("free, n = 2 [Hz]", 1.0),
    "ring_last": ("highest n [Hz]", 1.0),
}
_LEAD = (
    "Left out: compliance of the orders above n, per compliance of the stiffest mesh. Frequencies are those of the "
    "free ring, at standstill."
)


def ring_tables(check: xr.Dataset) -> list[Table]:
    """Section, orders and ends of the frequencies of every ring that bends, and all frequencies; none without one."""
    if "ring_frequency" not in check.variables:
        return []
    of_ring = check["ring_frequency"].transpose("elastic_ring", "ring_order")
    ends = {"ring_first": of_ring.isel(ring_order=0), "ring_last": of_ring.max("ring_order")}
    columns = columns_of(check.assign(ends), "elastic_ring", _SECTION)
    names = columns.pop("elastic_ring")
    free = {f"{name} [Hz]": list(values) for name, values in zip(names, of_ring.values, strict=True)}
    orders = [int(n) for n in check["ring_order"].values]
    return [
        Table(title="Rings that bend", columns={"ring": names, **columns}, lead=_LEAD),
        Table(title="Natural frequencies of free rings", columns={"order n": orders, **free}),
    ]


def deflections(result: xr.Dataset) -> dict[str, dict[str, NDArray[np.float64]]]:
    """Ring that bends -> name a2, b2, .. of each coordinate and its displacement over the record (T,) [m]."""
    if "displacement" not in result.variables:
        return {}
    moved = result["displacement"].transpose("dof", ...).values
    rows = bent_rows(texts(result, "dof"))
    return {body: {name: moved[row] for name, row in own.items()} for body, own in rows.items()}


def deflection_tables(result: xr.Dataset) -> list[Table]:
    """Mean coordinates and largest amplitude of every order of every ring that bends [µm]; none without one."""
    rows = []
    for body, moved in deflections(result).items():
        for n in (int(name[1:]) for name in moved if name[0] == "b"):
            wave = 1e6 * (moved[f"a{n}"] + 1j * moved[f"b{n}"])
            mean, most = complex(wave.mean()), float(np.abs(wave).max())
            outward = np.degrees(np.angle(mean)) / n % (360 / n) if abs(mean) > _STILL * most else np.nan
            rows.append((body, n, mean.real, mean.imag, most, outward))
    if not rows:
        return []
    headings = ("ring", "order n", "mean a [µm]", "mean b [µm]", "largest amplitude [µm]", "outward at [deg]")
    lead = (
        "In order n the radius grows by a cos n psi + b sin n psi, psi from the x axis of the stage, which turns with "
        "the carrier; most of the mean at the angle in the table and every 360/n degrees on."
    )
    return [Table(title="Bending of rings", columns=named_columns(headings, rows), lead=lead, digits=4)]
