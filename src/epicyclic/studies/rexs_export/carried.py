"""Keys of a model that a REXS file carries; every other one of a document is named, with the reason."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from ...document.tables import leaves
from .draft import Dropped

__all__ = ["left_out"]

_LINK = r"(?:\.[\w-]+)?\.(?:radial|x|y|z|tilt|rx|ry|rz|at|to)"
_CARRIED = re.compile(
    r"format|title|material\.\w+"
    r"|stages\.[\w-]+\.(?:planets|planet_angles|centre_distance|module|helix_angle|pressure_angle|face_width"
    r"|herringbone|gap|split)"
    r"|stages\.[\w-]+\.(?!meshes)[\w-]+\.(?:teeth|module|helix_angle|pressure_angle|face_width|profile_shift|addendum"
    r"|dedendum|tip_diameter|root_diameter|base_radius|mass|inertia|tilt_inertia|hand|kind|on|station|pin_radius|gap"
    r"|split|herringbone|rim|outer_diameter)"
    r"|stages\.[\w-]+\.(?:[\w-]+\.)?material\.\w+"
    rf"|stages\.[\w-]+\.[\w-]+\.(?:support|bearing){_LINK}"
    r"|stages\.[\w-]+\.(?:[\w-]+\.)?flank\.(?:tip_relief\.(?:amount|length|shape)|crown)"
    r"|stages\.[\w-]+\.(?:[\w-]+\.)?flank\.(?:root_relief|end_relief|slope|profile|waves|pitch)(?:\..*)?"
    r"|stages\.[\w-]+\.meshes\.[\w-]+\.(?:stiffness|direction|backlash)(?:\..*)?"
    rf"|bodies\.[\w-]+\.(?:mass|inertia|tilt_inertia|station|support{_LINK})"
    r"|couplings\.[\w-]+\.(?:between|radial|x|y|z|tilt|rx|ry|rz|radius)"
    r"|operation\.(?:held|gravity|(?:speed|torque|power)\..+)"
)
_FOLLOWS = re.compile(r".*\.(?:clearance|exponent|friction|damping|table|load|law)(?:\..*)?")
_REASONS = (
    (r"assumed\..*", "what is assumed is written like what is given"),
    (r"(?:doi|notes)$", "a text of the model file"),
    (r"damping\..*", "the format has no damping of a whole train"),
    (r"tolerance\..*", "distributions of deviations have no place"),
    (r"deviations\..*", "deviations have no place; what they do to the mean load is in K_gamma"),
    (r"loads\..*|operation\.loads.*", "forces on members are not written"),
    (r".*\.bore$", "only the mass that follows from it is written"),
    (r".*\.meshes\.[^.]+\.variation.*", "the file has the mean stiffness"),
    (r".*\.meshes\.[^.]+\.(?:phase|pressure_angle)", "follows from the geometry in the file"),
    (r".*\.(?:neck|shaft)(?:\..*)?$", "one rigid shaft in the file"),
    (r".*\.clocking", "the phase of the second gear of a planet has no place"),
    (r".*\.tip_rounding", "of a tool that the file does not have"),
)


def left_out(document: Mapping[str, object]) -> Iterator[Dropped]:
    """What stands in a document and is not carried, each value with its path; tables of reasons as one entry."""
    seen: dict[str, None] = {}
    for path, _ in leaves({key: value for key, value in document.items()}):
        if _CARRIED.fullmatch(path):
            continue
        short = _short(path)
        if short not in seen:
            seen[short] = None
            yield Dropped(short, _reason(path))


def _short(path: str) -> str:
    """The path; of assumptions, costs and deviations the entry they belong to."""
    if path.startswith("assumed."):
        return "assumed"
    if path.startswith("tolerance.cost."):
        return "tolerance.cost"
    if path.startswith("deviations."):
        return re.sub(r"\.(?:amplitude|phase|order|seed|value|frequency)$", "", path)
    return path


def _reason(path: str) -> str:
    """Why a path is not carried."""
    found = next((text for pattern, text in _REASONS if re.fullmatch(pattern, path)), None)
    if found is not None:
        return found
    return "laws of links have no place" if _FOLLOWS.fullmatch(path) else "no place in the format"
