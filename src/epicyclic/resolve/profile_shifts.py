"""Centre distances that are given, and the profile shifts that follow from them."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ..errors import ModelError
from ..teeth import geometry
from ..warning_codes import coded
from .gears import Teeth
from .plan import GearPair, Plan
from .resolution_log import ResolutionLog, same

__all__ = ["distance_from_shifts", "given_distances", "given_radius", "profile_shifts"]

LARGEST_SHIFT = 5.0  # as in the file format; far beyond any tooth


def given_distances(plan: Plan, log: ResolutionLog) -> dict[str, float]:
    """Given centre distance of every pair that has one [m]; two that differ are a warning, the nearest one counts."""
    radii = {axis: given_radius(plan, axis, log) for axis in set(plan.axis.values())}
    found: dict[str, float] = {}
    for p in plan.pairs:
        stated = [(f"{p.path}.centre_distance", p.keys.centre_distance)]
        planets = [name for name in (p.a, p.b) if not plan.central(name)]
        if len(planets) == 1:
            stated.append(("the pin radius", radii[plan.axis[planets[0]]]))
        elif not planets:
            stated.append((f"{plan.path}.centre_distance", plan.stage.centre_distance))
        value = _first(stated, log)
        if value is not None:
            found[p.name] = value
    return found


def given_radius(plan: Plan, axis: str, log: ResolutionLog) -> float | None:
    """Given radius of one planet axis [m]."""
    if plan.central(axis):
        return None
    on_axis = [name for name in plan.gears if plan.axis[name] == axis]
    stated = [(f"{plan.member_path(name)}.pin_radius", plan.gears[name].pin_radius) for name in on_axis]
    axes = list(dict.fromkeys(plan.axis[name] for name in plan.gears if not plan.central(name)))
    if plan.carrier is not None and axis == axes[0]:
        member = plan.stage.members[plan.carrier]
        stated.append((f"{plan.member_path(plan.carrier)}.pin_radius", member.pin_radius))
    meets = {q for p in plan.pairs for q in (p.a, p.b) if plan.central(p.a) or plan.central(p.b)}
    if any(name in meets for name in on_axis):
        stated.append((f"{plan.path}.centre_distance", plan.stage.centre_distance))
    return _first(stated, log)


def _first(stated: list[tuple[str, float | None]], log: ResolutionLog) -> float | None:
    """First stated centre distance [m], with a warning for each one that differs."""
    given = [(path, value) for path, value in stated if value is not None]
    for path, value in given[1:]:
        if not same(value, given[0][1], 1e-6):
            log.warn(
                coded(
                    "centre-distances-differ",
                    f"centre distances differ: {given[0][0]} {given[0][1] * 1e3:.6g} mm, {path} {value * 1e3:.6g} mm; "
                    "the first one counts",
                )
            )
    return given[0][1] if given else None


def profile_shifts(plan: Plan, teeth: Mapping[str, Teeth], given: dict[str, float]) -> dict[str, tuple[float, str]]:
    """Profile shift of every gear and where it comes from; what a centre distance fixes follows, the rest is 0.

    Raises
    ------
    ModelError : a centre distance that no shift of a tooth can serve.
    """
    known = {n: (float(x), "given") for n, m in plan.gears.items() if (x := m.profile_shift) is not None}
    distance = given | _distances_from_shifts(plan, teeth, known, given)
    for p in plan.pairs:
        if p.name not in distance or (p.a in known and p.b in known):
            continue
        total = _shift_sum(p, teeth, distance[p.name])
        if total is None:
            continue
        known.setdefault(p.a if p.b not in known else p.b, (0.0, "default"))
        if p.a not in known:
            known[p.a] = (total - known[p.b][0], "geometry")
        elif p.b not in known:
            known[p.b] = (total - known[p.a][0], "geometry")
    for name, (shift, _) in known.items():
        if abs(shift) > LARGEST_SHIFT:
            raise ModelError(
                f"the centre distance asks for a profile shift of {shift:.3g}, no tooth is left",
                path=f"{plan.member_path(name)}.profile_shift",
                given="(from the centre distance)",
                allowed=f"a centre distance nearer to that of teeth and module, shifts within +-{LARGEST_SHIFT:g}",
            )
    return {name: known.get(name, (0.0, "default")) for name in plan.gears}


def _distances_from_shifts(
    plan: Plan, teeth: Mapping[str, Teeth], known: Mapping[str, tuple[float, str]], given: Mapping[str, float]
) -> dict[str, float]:
    """Centre distance [m] of pairs on an axis that has a central mesh with two stated shifts."""
    found: dict[str, float] = {}
    for p in plan.pairs:
        planet = next((n for n in (p.a, p.b) if not plan.central(n)), None)
        if planet is None or plan.central(p.a) == plan.central(p.b) or not (p.a in known and p.b in known):
            continue
        for q in plan.pairs:
            on_axis = any(plan.axis[n] == plan.axis[planet] for n in (q.a, q.b) if not plan.central(n))
            if on_axis and plan.central(q.a) != plan.central(q.b) and q.name not in given:
                found.setdefault(q.name, distance_from_shifts(p, teeth, known[p.a][0], known[p.b][0])[1])
    return found


def _shift_sum(p: GearPair, teeth: Mapping[str, Teeth], distance: float) -> float | None:
    """Sum of shifts with which a pair works at a distance; None where its base circles do not allow it."""
    a, b = teeth[p.a], teeth[p.b]
    if not (same(a.base_radius, a.nominal_base) and same(b.base_radius, b.nominal_base)):
        return None
    angle = geometry.working_pressure_angle_at(distance, a.base_radius, b.base_radius, internal=p.internal)
    if math.isnan(angle):
        return None
    total = geometry.shift_sum(
        a.teeth, b.teeth, a.pressure_angle, a.helix_angle, working_pressure_angle=angle, internal=p.internal
    )
    return 0.0 if abs(total) < 1e-9 else total


def distance_from_shifts(
    p: GearPair, teeth: Mapping[str, Teeth], shift_a: float, shift_b: float
) -> tuple[float, float]:
    """Working angle [rad] and centre distance [m] of a pair by its teeth and shifts."""
    a, b = teeth[p.a], teeth[p.b]
    angle = geometry.working_pressure_angle(
        a.teeth, b.teeth, a.pressure_angle, a.helix_angle, shift_a=shift_a, shift_b=shift_b, internal=p.internal
    )
    distance = geometry.centre_distance(
        a.teeth,
        b.teeth,
        a.module,
        a.helix_angle,
        pressure_angle=a.pressure_angle,
        working_pressure_angle=angle,
        internal=p.internal,
    )
    return angle, distance
