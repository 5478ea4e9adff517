"""Whether the numbers of a bearing fit together, and its clearance in operation.

The table of the model file bounds each number by itself; what is checked here is what they are to each other.

The radial internal clearance in operation is that of a new bearing, less what fits and temperature take.

    operating = initial - I_i d/F - I_o E/D - alpha dT (E + F)/2

with the raceway diameters F = D_pw - D_w of the inner and E = D_pw + D_w of the outer ring, bore d and outside diameter
D.  By Lamé's thick rings an inner ring on a solid shaft of the same steel grows at its raceway by d/F of the effective
interference I_i, an outer ring in a thick housing shrinks by E/D of I_o (derived here; catalogues have the same for
rings of constant section; a hollow shaft or thin housing takes less).  The inner ring is warmer by dT; alpha is that of
steel.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator
from functools import cache
from importlib import resources
from typing import Any

from ..errors import ModelError
from .rolling_bearing import (
    ANGLES,
    RollingBearing,
    element_law,
    geometric_rating,
    geometric_static_rating,
    rated_element_load,
)

_ROUNDING = 1e-3  # of dimensions as catalogues print them
_LENGTH = (0.2, 12.0)  # of a roller, in diameters
_OFF = 3.0  # a rating of the catalogue over that of the geometry
_LOOSE = 0.02  # clearance of rollers, in diameters

# key -> unit of a message, per SI; of other lengths mm
_UNITS = {
    **dict.fromkeys(("clearance", "preload"), ("um", 1e6)),
    **dict.fromkeys(("rating", "static_rating"), ("N", 1.0)),
    "contact_angle": ("deg", 180 / math.pi),
}
_LENGTHS = ("diameter", "length", "distance", "bore")

Problem = tuple[bool, str, str, str]  # whether it is wrong, key, problem, allowed


def with_unit(key: str, value: object) -> object:
    """A number of a bearing as messages have it, with its unit."""
    unit, factor = _UNITS.get(key, ("mm", 1e3) if key.endswith(_LENGTHS) else ("", 1.0))
    return f"{factor * value:.6g} {unit}" if unit and isinstance(value, (int, float)) else value


def checked(bearing: RollingBearing, path: str, *, parts: bool = False) -> RollingBearing:
    """Return a bearing whose numbers fit together.

    Elements may not be pressed, by preload and negative clearance, harder than the most loaded one at the static
    rating: that is the limit of the preload.

    parts : check these alone, whatever the clearance.

    Raises
    ------
    ModelError : at `path`.key, of the first number that does not fit.
    """
    for problems in (_shapes,) if parts else (_shapes, _fits, _ratings):
        for wrong, key, problem, allowed in problems(bearing):
            if wrong:
                given = with_unit(key, getattr(bearing, key))
                raise ModelError(problem, path=f"{path}.{key}", given=given, allowed=allowed)
    return bearing


def _shapes(bearing: RollingBearing) -> Iterator[Problem]:
    """Elements in their rows."""
    low, high = ANGLES[bearing.type]
    degrees, size = abs(math.degrees(bearing.contact_angle)), bearing.element_diameter
    outside = not low - 1e-9 <= degrees <= high + 1e-9
    span = f"{low:g} to {high:g} deg" if high else "0"
    yield outside, "contact_angle", f"does not go with the type {bearing.type}", span
    room = bearing.pitch_diameter * math.sin(math.pi / bearing.elements)
    most = f"up to {1e3 * room:g} mm"
    yield size > room * (1 + _ROUNDING), "element_diameter", "elements overlap on the pitch circle", most
    if not bearing.is_ball:
        least, longest = (share * size for share in _LENGTH)
        fits = least <= bearing.element_length <= longest
        span = f"{1e3 * least:g} to {1e3 * longest:g} mm"
        yield not fits, "element_length", "does not fit the diameter of the roller", span
    backward = bearing.rows == 2 and bearing.contact_angle < 0
    yield backward, "contact_angle", "two rows carry both senses", f"{degrees:g} deg, and arrangement"
    yield bearing.rows > 2 and degrees > 0, "rows", "more than two rows with a contact angle", "1 or 2"
    if bearing.rows == 1 or (bearing.type == "spherical roller" and degrees > 0):
        yield bearing.row_distance != 0, "row_distance", "given though it follows", "0"
    else:
        wide = size if bearing.is_ball else bearing.element_length * math.cos(bearing.contact_angle)
        size_of = "element_diameter" if bearing.is_ball else "element_length"
        overlap = f"rows overlap, with {size_of} = {with_unit(size_of, getattr(bearing, size_of))}"
        yield bearing.row_distance < wide, "row_distance", overlap, f"{1e3 * wide:g} mm or more"


def _fits(bearing: RollingBearing) -> Iterator[Problem]:
    """Play and preload."""
    slope = abs(math.sin(bearing.contact_angle))
    yield bearing.preload > 0 and slope == 0, "preload", "needs a contact angle", "0"
    # a free contact angle of 60 deg, and what no roller bearing has
    most = bearing.groove_distance if bearing.is_ball else _LOOSE * bearing.element_diameter
    yield bearing.clearance > most, "clearance", "too large for the elements", f"up to {1e6 * most:g} um"
    stiffness, exponent = element_law(bearing)
    limit = (rated_element_load(bearing) / stiffness) ** (1 / exponent)
    tight = -bearing.clearance / 2 * math.cos(bearing.contact_angle)
    allowed = "less: elements would bear more than the most loaded one at the static rating"
    yield tight > limit, "clearance", "presses the elements too hard", f"{-2e6 * limit:.4g} um or more"
    yield tight + bearing.preload * slope > limit, "preload", "larger than the limit", allowed


def _ratings(bearing: RollingBearing) -> Iterator[Problem]:
    """Ratings of the catalogue against those of the geometry."""
    for key, own in (("rating", geometric_rating(bearing)), ("static_rating", geometric_static_rating(bearing))):
        off = (getattr(bearing, key) or own) / own
        yield not 1 / _OFF <= off <= _OFF, key, "rating of the wrong size", f"near {own:.3g} N of the geometry"


# clearance in operation -----------------------------------------------------------------------------------------------

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
