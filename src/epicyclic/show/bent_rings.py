"""Tables of rings that bend: section, orders and natural frequencies of `check`, deflection of `static`, `steady`."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from .elements import Table, columns_of, named_columns
from .series import bent_rows, texts

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
