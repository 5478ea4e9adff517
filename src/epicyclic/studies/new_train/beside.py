"""What a running model needs beside teeth and load: bodies, supports, damping, deviations, tolerances, each by a rule.

Nothing here is known of the train that is to be built, so every number goes under `[assumed]` with its rule.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...document.writer import quantity_text
from ...teeth import geometry
from ...teeth.grades import in_flank_range, run_out_width
from .tooth_counts import Held, ToothCounts

__all__ = ["Blank", "beside", "shifts_of"]

_STEEL = 7850.0  # [kg/m^3] as in the model file
_RIM = 4  # modules of ring beyond its roots: from 3.5 on it carries nearly like a solid body
_PLANET_RIM = 3  # modules of planet under its roots, beside the bore
_LARGEST_BORE = 0.6  # of a planet, per reference diameter
_CHEEK = 0.3  # thickness of a carrier's cheek per face width
_DAMPING = 0.03  # of every mode; gear trains have 0.01 to 0.1
_ADDENDUM = 0.9  # of the ring: its tips stay on the involute of the planets
_GRADE = 6  # ISO 1328-1 class of ground planetary gears
_PIN = 20e-6  # [m] what the pin of planet 1 is off, tangentially
_PIN_ZONE = 40e-6  # [m] diameter of the tolerance zone of the pins: the pin above lies on its edge
# Stiffness per face width [N/m^2].  A mesh of steel gears has about 20 N/(mm um) [iso6336].
_MESH = 20e9
_BEARING = 0.5  # per mesh: bearings of planets, carriers and rings that turn
_FLOATING = 0.01  # per mesh: a sun that floats on a toothed coupling
_BOLTED = 2.5  # per mesh: what is held by the housing


@dataclass(frozen=True, slots=True, kw_only=True)
class Blank:
    """The gears as far as they are decided: normal module [m], face width [m], angles [rad]."""

    counts: ToothCounts
    planets: int
    module: float
    face_width: float
    helix_angle: float
    pressure_angle: float
    held: Held | None

    def diameter(self, teeth: int) -> float:
        """Reference diameter of a gear [m]."""
        return 2 * geometry.reference_radius(teeth, self.module, self.helix_angle)


def beside(blank: Blank) -> tuple[dict[str, Any], dict[str, str]]:
    """Tables of a document beside teeth, size and operation, and the reason of every value by path."""
    stage: dict[str, Any] = {"sun": {}, "planet": {}, "ring": {}, "carrier": {}}
    reasons: dict[str, str] = {}

    def put(member: str, key: str, value: object, reason: str) -> None:
        table, *rest = key.split(".")
        stage[member][table] = {rest[0]: value} if rest else value
        reasons[f"stages.main.{member}.{key}"] = reason

    for member, shift in shifts_of(blank).items():
        put(member, "profile_shift", shift, "against undercut; sun, planet and ring keep the centre distance")
    bore = _planet_bore(blank)
    rule = f"{_PLANET_RIM} modules of rim under the roots, at most {_LARGEST_BORE} of the reference diameter"
    put("planet", "bore", quantity_text(bore, "length"), rule)
    put("ring", "rim", quantity_text(_RIM * blank.module, "length"), f"{_RIM} modules beyond the roots")
    put("ring", "addendum", _ADDENDUM, "its tips stay on the involute of the planets")
    for member, key, share, reason in _supports(blank.held):
        put(member, key, _stiffness(share, blank.face_width), reason)
    mass, inertia = _cheeks(blank, bore)
    put("carrier", "mass", quantity_text(mass, "mass"), "two steel cheeks, 0.3 face widths thick, without the pins")
    put("carrier", "inertia", quantity_text(inertia, "inertia"), "of these cheeks")
    stage["carrier"] = {k: stage["carrier"][k] for k in ("mass", "inertia", "support")}
    deviations, tolerance, more = _deviations(blank)
    reasons |= {"damping.modal": "a usual value; a response needs damping, 0.01 to 0.1"} | more
    return {
        "damping": {"modal": _DAMPING},
        "stages": {"main": stage},
        "deviations": deviations,
        "tolerance": tolerance,
    }, reasons


def shifts_of(blank: Blank) -> dict[str, float]:
    """Profile shifts [1] that keep sun or planet from undercut at the same centre distance; nothing where none has.

    x = 1 - z sin^2 alpha_t/(2 cos beta), rounded up to hundredths; the mate has -x, and the ring that of the sun.
    """
    transverse = geometry.transverse_pressure_angle(blank.pressure_angle, blank.helix_angle)

    def least(teeth: int) -> float:
        return 1 - teeth * math.sin(transverse) ** 2 / (2 * math.cos(blank.helix_angle))

    # what theory asks for below 0.02 no cutter shows: 17 teeth count as free of undercut
    sun, planet = (x if (x := least(z)) > 0.02 else min(x, 0.0) for z in (blank.counts.sun, blank.counts.planet))
    shift = sun if sun > 0 else -planet if planet > 0 else 0.0
    if shift == 0.0 or (sun > 0 and planet > 0):
        return {}
    rounded = math.copysign(math.ceil(abs(shift) * 100) / 100, shift)
    return {"sun": rounded, "planet": -rounded, "ring": rounded}


def _planet_bore(blank: Blank) -> float:
    """Bore of the planets [m], a whole number of mm, of 5 mm from 50 mm on."""
    root = 2 * geometry.root_radius(blank.counts.planet, blank.module, blank.helix_angle)
    largest = min(_LARGEST_BORE * blank.diameter(blank.counts.planet), root - 2 * _PLANET_RIM * blank.module)
    step = 5e-3 if largest > 50e-3 else 1e-3 if largest > 5e-3 else 1e-4
    return round(math.floor(largest / step + 1e-9) * step, 6)


def _supports(held: Held | None) -> list[tuple[str, str, float, str]]:
    """Member, key, stiffness per mesh, and its rule."""
    bearing, bolted = (
        "half a mesh of this face width, 20 N/(mm um)",
        "2.5 meshes of this face width: bolted to the housing",
    )
    return [
        ("sun", "support.radial", _FLOATING, "a hundredth of a mesh: the sun floats on a toothed coupling"),
        ("planet", "bearing.radial", _BEARING, f"pin and bearing in series, {bearing}"),
        ("ring", "support.radial", _BOLTED if held == "ring" else _BEARING, bolted if held == "ring" else bearing),
        (
            *("carrier", "support.radial"),
            _BOLTED if held == "carrier" else _BEARING,
            bolted if held == "carrier" else f"its bearings, {bearing}",
        ),
    ]


def _stiffness(share: float, face_width: float) -> str:
    """Stiffness of a share of a mesh, to two digits, as a text."""
    return quantity_text(float(f"{share * _MESH * face_width:.2g}"), "stiffness")


def _cheeks(blank: Blank, bore: float) -> tuple[float, float]:
    """Mass [kg] and inertia [kg m^2] of the two cheeks of a carrier, to three digits.

    Discs from the tips of the sun to one module beyond the bores of the planets.
    """
    axes = (blank.diameter(blank.counts.sun) + blank.diameter(blank.counts.planet)) / 2
    outer, inner = axes + bore / 2 + blank.module, blank.diameter(blank.counts.sun) / 2 + 2 * blank.module
    mass = 2 * _STEEL * math.pi * (outer**2 - inner**2) * _CHEEK * blank.face_width
    return float(f"{mass:.3g}"), float(f"{mass * (outer**2 + inner**2) / 2:.3g}")


def _deviations(blank: Blank) -> tuple[dict[str, Any], dict[str, Any], dict[str, str]]:
    """Tables of deviations and tolerances, and their reasons."""
    teeth: Mapping[str, int] = {"sun": blank.counts.sun, "planet": blank.counts.planet, "ring": blank.counts.ring}
    deviations: dict[str, Any] = {}
    tolerance: dict[str, Any] = {"deviations.planet.position": f"disc({quantity_text(_PIN_ZONE, 'length')})"}
    reasons: dict[str, str] = {}
    for member, count in teeth.items():
        diameter = blank.diameter(count)
        covered = in_flank_range(diameter, blank.module)
        width = run_out_width(max(diameter, 5e-3), max(blank.module, 0.5e-3), _GRADE)
        deviations[member] = {"run_out": quantity_text(round(width / 2, 7), "length")}
        reasons[f"deviations.{member}.run_out"] = f"half of the run-out F_rT of class {_GRADE} of ISO 1328-1:2013"
        if covered:
            tolerance[f"deviations.{member}.run_out"] = f"grade(ISO 1328-1:2013 {_GRADE}, 3 sigma)"
    zeros = ", 0" * (blank.planets - 1)
    deviations["planet"]["position"] = {"y": f"[{_PIN * 1e6:g}{zeros}] um"}
    reasons["deviations.planet.position"] = "one pin, that of planet 1, stands 20 um off along the circle of pins"
    reasons["tolerance"] = "grades and zones as usual, to be replaced by those of the drawing"
    return deviations, tolerance, reasons
