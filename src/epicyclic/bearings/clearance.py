"""Radial internal clearance of a bearing in operation: of a new one, less what fits and temperature take.

    operating = initial - I_i d/F - I_o E/D - alpha dT (E + F)/2

with the raceway diameters F = D_pw - D_w of the inner and E = D_pw + D_w of the outer ring, bore d and outside diameter
D.  By Lamé's thick rings an inner ring on a solid shaft of the same steel grows at its raceway by d/F of the effective
interference I_i, an outer ring in a thick housing shrinks by E/D of I_o (derived here; catalogues have the same for
rings of constant section; a hollow shaft or thin housing takes less).  The inner ring is warmer by dT; alpha is that of
steel.
"""

from __future__ import annotations

import tomllib
from functools import cache
from importlib import resources
from typing import Any

from ..errors import ModelError
from .checks import with_unit

GROUPS = ("C2", "CN", "C3", "C4")
_EXPANSION = 12e-6  # of steel [1/K]


@cache
def _groups() -> dict[str, Any]:
    return tomllib.loads(resources.files("epicyclic.bearings").joinpath("clearance_groups.toml").read_text("utf-8"))


def group_range(bearing: str, group: str, bore: float) -> tuple[float, float]:
    """Least and largest clearance of a new bearing of a type [m]; sources stand in clearance_groups.toml.

    group : one of `GROUPS`.  bore [m].

    Raises
    ------
    ModelError : at `group` or `bore`, a type or a bore outside of the table.
    """
    if bearing not in _groups():
        allowed = f"initial, or a {' or '.join(_groups())} bearing"
        raise ModelError(f"no range is known of a {bearing} bearing", path="group", given=group, allowed=allowed)
    rows, column = _groups()[bearing], 2 + 2 * GROUPS.index(group)
    found = [row[column : column + 2] for row in rows if row[0] < round(1e3 * bore, 6) <= row[1]]
    if not found:
        allowed = f"above {rows[0][0]} and up to {rows[-1][1]} mm, or initial in place of group"
        raise ModelError("outside of the table of groups", path="bore", given=with_unit("bore", bore), allowed=allowed)
    return 1e-6 * found[0][0], 1e-6 * found[0][1]


def operating_clearance(
    bearing: str,
    races: tuple[float, float],
    *,
    group: str | None = None,
    initial: float | None = None,
    bore: float | None = None,
    outside_diameter: float | None = None,
    inner_fit: float = 0.0,
    outer_fit: float = 0.0,
    temperature_difference: float = 0.0,
) -> tuple[float, str]:
    """Clearance in operation [m], and what it is made of in words.

    bearing : its type.  races : diameters F, E on which the elements run [m].  group : of which the mean counts, or
    initial [m].  bore, outside_diameter [m].  inner_fit, outer_fit : effective interferences [m].
    temperature_difference : inner less outer ring [K].

    Raises
    ------
    ModelError : at the keyword that is missing, leaves no ring, or is outside of the table of groups.
    """
    if (group is None) is (initial is None):
        raise ModelError("not a clearance before mounting", path="initial", allowed="initial, or group")
    if not (0 < bore <= races[0] if bore is not None else not (group or inner_fit)):
        allowed = f"up to {1e3 * races[0]:g} mm"
        raise ModelError("no bore of an inner ring", path="bore", given=with_unit("bore", bore or 0), allowed=allowed)
    if not (outside_diameter >= races[1] if outside_diameter is not None else not outer_fit):
        allowed, path = f"{1e3 * races[1]:g} mm or more", "outside_diameter"
        raise ModelError("no outer ring", path=path, given=with_unit(path, outside_diameter or 0), allowed=allowed)
    new, words = initial or 0.0, "as stated"
    if group is not None:
        low, high = group_range(bearing, group, bore or 0.0)
        new, words = (low + high) / 2, f"{group}: {1e6 * low:.4g} to {1e6 * high:.4g} um"
    by_fits = inner_fit * (bore or 0.0) / races[0] + outer_fit * races[1] / (outside_diameter or races[1])
    by_heat = _EXPANSION * temperature_difference * sum(races) / 2
    words += f", {1e6 * new:.4g} um taken, less {1e6 * by_fits:.4g} um by fits and {1e6 * by_heat:.4g} um by heat"
    return new - by_fits - by_heat, words
