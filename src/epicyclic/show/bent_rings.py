"""Tables of rings that bend: section, orders and natural frequencies of `check`, deflection of `static`, `steady`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .elements import Table, columns_of, named_columns
from .series import bent_rows, texts

if TYPE_CHECKING:
    import xarray as xr

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


def section_tables(check: xr.Dataset) -> list[Table]:
    """Section, orders and first frequencies of every ring that bends; none without one."""
    if "ring_frequency" not in check.variables:
        return []
    of_ring = check["ring_frequency"].transpose("elastic_ring", "ring_order")
    ends = {"ring_first": of_ring.isel(ring_order=0), "ring_last": of_ring.max("ring_order")}
    columns = columns_of(check.assign(ends), "elastic_ring", _SECTION)
    columns = {"ring" if name == "elastic_ring" else name: values for name, values in columns.items()}
    return [Table(title="Rings that bend", columns=columns, lead=_LEAD)]


def frequency_tables(check: xr.Dataset) -> list[Table]:
    """Natural frequency of every order of every ring that bends, free [Hz]; none without one."""
    if "ring_frequency" not in check.variables:
        return []
    columns: dict[str, Any] = {"order n": [int(n) for n in check["ring_order"].values]}
    for name in texts(check, "elastic_ring"):
        columns[f"{name} [Hz]"] = list(check["ring_frequency"].sel(elastic_ring=name).values)
    return [Table(title="Natural frequencies of free rings", columns=columns)]


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
        for name, a in moved.items():
            n = int(name[1:])
            if name[0] != "a" or not n:
                continue
            b = moved[f"b{n}"]
            mean = complex(a.mean(), b.mean())
            most = float(np.hypot(a, b).max())
            outward = np.degrees(np.angle(mean)) / n % (360 / n) if abs(mean) > _STILL * most else np.nan
            rows.append((body, n, mean.real * 1e6, mean.imag * 1e6, 1e6 * most, outward))
    if not rows:
        return []
    headings = ("ring", "order n", "mean a [µm]", "mean b [µm]", "largest amplitude [µm]", "outward at [deg]")
    lead = (
        "In order n the radius grows by a cos n psi + b sin n psi, psi from the x axis of the stage, which turns with "
        "the carrier; most of the mean at the angle in the table and every 360/n degrees on."
    )
    return [Table(title="Bending of rings", columns=named_columns(headings, rows), lead=lead, digits=4)]
