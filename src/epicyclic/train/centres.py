"""Where the axes of a stage stand: shifts, working angles, centre distances, pin radii, contact ratios."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ..errors import ModelError, in_mm
from ..teeth import geometry
from ..teeth.geometry import Angle, Phase
from .gears import (
    GivenLength,
    distance_from_shifts,
    finish_gear,
    given_distances,
    given_radius,
    half_station,
    profile_shifts,
    teeth_of_stage,
    width_of,
)
from .kinematics import spread
from .stages import GearPair, Plan
from .train import NAN, GearData, ResolutionLog, Teeth, same, turns_of

Place = tuple[float, float]
STEEPEST = math.radians(60)  # working pressure angle, as in the file format
_TOUCHING = 1e-9  # [m] faces that share less have their ends at one place, by rounding


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshShape:
    """One pair at its working place: angle [rad], contact and overlap ratio.

    tooth_angle : angle at which the teeth themselves touch [rad]; the working angle unless base radii are stated.
    limits : where a tooth pair touches, (sigma_min, sigma_max).
    station, width : axial place of the middle of the common face, and its width [m], by side.
    """

    working_angle: float
    tooth_angle: float
    limits: tuple[float, float]
    contact_ratio: float
    overlap_ratio: float
    station: Mapping[str | None, float]
    width: Mapping[str | None, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class StageShape:
    """The geometry of a stage.

    gears : member -> side -> toothed part.  pin : planet gear -> radius of its axes [m].
    ahead : planet gear -> polar angle of its axis from the branch line [rad].  centre : central gear -> (x, y) [m].
    pin_radius : of the planet gear that meets the sun [m], nan without planets.
    directions : pair -> polar angle of e, one per branch [turns].
    """

    plan: Plan
    gears: Mapping[str, Mapping[str | None, GearData]]
    meshes: Mapping[str, MeshShape]
    pin: Mapping[str, float]
    ahead: Mapping[str, float]
    centre: Mapping[str, Place]
    pin_radius: float
    directions: Mapping[str, tuple[Angle, ...]]

    def gear(self, member: str) -> GearData:
        """A gear, of halves the left one."""
        return next(iter(self.gears[member].values()))

    def place(self, member: str, branch: int) -> Place:
        """Centre of a gear of one branch (0 ..) [m]."""
        if member in self.centre:
            return self.centre[member]
        angle = self.polar(member, branch)
        return self.pin[member] * math.cos(angle), self.pin[member] * math.sin(angle)

    def polar(self, member: str, branch: int) -> float:
        """Polar angle of the own axes of a gear [rad]: 0 for a central one."""
        if member in self.centre:
            return 0.0
        return math.tau * float(self.plan.angles[branch]) + self.ahead[member]


def shape_stage(plan: Plan, log: ResolutionLog) -> StageShape:
    """Geometry of one stage.

    Raises
    ------
    ModelError : contradicting teeth, a centre distance below the base circles, axes that cannot be placed.
    """
    teeth = teeth_of_stage(plan, log)
    given = dict(given_distances(plan, log))
    shifts = profile_shifts(plan, teeth, given)
    gears = {name: finish_gear(plan, name, teeth[name], shifts[name], log) for name in plan.gears}
    worked = {p.name: _working(plan, p, teeth, given.get(p.name), shifts) for p in plan.pairs}
    distance = {name: between for name, (_, between) in worked.items()}
    pin = dict(_pin_radii(plan, distance, log))
    meshes = {p.name: _mesh_shape(plan, p, gears, worked[p.name], log) for p in plan.pairs}
    ahead = _ahead(plan, pin, distance)
    centre = _centres(plan, distance)
    meeting = [p.b for p in plan.pairs if plan.gears[p.a].kind == "sun" and p.b in pin] or list(pin)
    return StageShape(
        plan=plan,
        gears=gears,
        meshes=meshes,
        pin=pin,
        ahead=ahead,
        centre=centre,
        pin_radius=pin[meeting[0]] if meeting else NAN,
        directions={p.name: _directions(plan, p, pin, ahead, centre) for p in plan.pairs},
    )


# the pair at work ----------------------------------------------------------------------------------------------------


def _working(
    plan: Plan,
    p: GearPair,
    teeth: Mapping[str, Teeth],
    given: GivenLength | None,
    shifts: Mapping[str, tuple[float, str]],
) -> tuple[float, float]:
    """Working transverse pressure angle [rad] of a pair and the distance of its axes [m].

    Stated base radii, rounded as print is, work at the angle that fits the distance, so that a stage that
    turns as a whole stresses no tooth.
    """
    a, b = teeth[p.a], teeth[p.b]
    least = b.base_radius - a.base_radius if p.internal else b.base_radius + a.base_radius
    if least <= 0:
        problem, path = f"the ring is smaller than {p.a}, which turns in it", f"{plan.member_path(p.b)}.teeth"
        raise ModelError(problem, path=path, given=b.teeth, allowed=f"more teeth than {a.teeth}")
    if p.keys.pressure_angle is not None:
        by_angle = least / math.cos(p.keys.pressure_angle)
        return p.keys.pressure_angle, by_angle if given is None else given.value
    angle, distance = distance_from_shifts(p, teeth, shifts[p.a][0], shifts[p.b][0])
    if given is None or same(given.value, distance, 1e-12):
        if math.isnan(angle):
            raise ModelError("no working angle: these shifts close the teeth", path=f"{p.path}.pressure_angle")
        fitting = angle if a.nominal and b.nominal else _angle_at(p, distance, teeth)
        return angle if math.isnan(fitting) else fitting, distance
    angle = _angle_at(p, given.value, teeth)
    if angle > STEEPEST:
        problem = f"the centre distance is too large, the working pressure angle would be {math.degrees(angle):.3g} deg"
        allowed = f"about {in_mm(distance)}, the distance of teeth and module"
        raise ModelError(problem, path=given.path, given=in_mm(given.value), allowed=allowed)
    if math.isnan(angle):
        problem = "the centre distance is below the base circles"
        allowed = f"at least {in_mm(least)}, or {p.path}.pressure_angle"
        raise ModelError(problem, path=given.path, given=in_mm(given.value), allowed=allowed)
    return angle, given.value


def _angle_at(p: GearPair, distance: float, teeth: Mapping[str, Teeth]) -> float:
    """Working angle of a pair at a distance [rad]; nan below the base circles."""
    radii = teeth[p.a].base_radius, teeth[p.b].base_radius
    return geometry.working_pressure_angle_at(distance, *radii, internal=p.internal)


def _mesh_shape(
    plan: Plan,
    p: GearPair,
    gears: Mapping[str, Mapping[str | None, GearData]],
    worked: tuple[float, float],
    log: ResolutionLog,
) -> MeshShape:
    """Working geometry of one pair: contact limits, contact ratio and overlap ratio [iso21771].

    worked : working transverse pressure angle [rad] and centre distance [m].
    """
    a, b = (next(iter(gears[name].values())) for name in (p.a, p.b))
    angle, distance = worked
    # Stated base radii are levers of the forces; the contact limits follow from the teeth themselves.
    by_teeth = distance_from_shifts(p, {p.a: a, p.b: b}, a.profile_shift, b.profile_shift)[0]
    tooth_angle = angle if (a.nominal and b.nominal) or math.isnan(by_teeth) else by_teeth
    limits = geometry.contact_limits(
        a.nominal_base,
        a.tip_radius,
        b.nominal_base,
        b.tip_radius,
        working_pressure_angle=tooth_angle,
        base_pitch=geometry.base_pitch(a.module, a.pressure_angle, a.helix_angle),
        internal=p.internal,
    )
    ratio = geometry.transverse_contact_ratio(limits)
    faces = dict(_common_faces(plan, p))
    width = next(iter(faces.values()))[1]
    overlap = geometry.overlap_ratio(width, a.helix_angle, a.module) if a.helix_angle else 0.0
    log.note(f"{p.path}.pressure_angle", angle, "rad", "given" if p.keys.pressure_angle is not None else "geometry")
    log.note(f"{p.path}.centre_distance", distance, "m", "geometry" if p.keys.centre_distance is None else "given")
    log.note(f"{p.path}.contact_ratio", ratio, "", "geometry")
    log.note(f"{p.path}.overlap_ratio", overlap, "", "geometry")
    if ratio < 1.0:
        log.coded("contact-ratio-below-one", f"{p.path}: contact ratio {ratio:.3f} < 1, the teeth do not keep contact")
    return MeshShape(
        working_angle=angle,
        tooth_angle=tooth_angle,
        limits=limits,
        contact_ratio=ratio,
        overlap_ratio=overlap,
        station={side: station for side, (station, _) in faces.items()},
        width={side: width for side, (_, width) in faces.items()},
    )


def _common_faces(plan: Plan, p: GearPair) -> Iterator[tuple[str | None, tuple[float, float]]]:
    """Middle and width of what the faces of a pair have in common [m], by side.

    A face of no stated width covers the other one; where neither has a width, it is nan.

    Raises
    ------
    ModelError : halves that mesh with one piece, faces without overlap.
    """
    if plan.two_sided(p.a) != plan.two_sided(p.b):
        single, double = (p.a, p.b) if plan.two_sided(p.b) else (p.b, p.a)
        problem = f"meshes with {double}, which has a left and a right half"
        path = f"{plan.member_path(single)}.herringbone"
        raise ModelError(problem, path=path, given=False, allowed="herringbone or split gears mesh with such gears")
    sides: tuple[str | None, ...] = ("left", "right") if plan.two_sided(p.a) else (None,)
    for side in sides:
        places = {name: half_station(plan, name, side) for name in (p.a, p.b)}
        middle = (places[p.a] + places[p.b]) / 2
        widths = {name: width for name in places if (width := width_of(plan, name, side)) is not None}
        if not widths:
            yield side, (middle, NAN)
            continue
        left = max(places[name] - middle - width / 2 for name, width in widths.items())
        right = min(places[name] - middle + width / 2 for name, width in widths.items())
        if right - left < _TOUCHING:
            ends = (
                f"{name} {(places[name] - width / 2) * 1e3:.6g} .. {(places[name] + width / 2) * 1e3:.6g} mm"
                for name, width in widths.items()
            )
            problem = f"the {f'{side} ' if side else ''}faces do not overlap along the axis"
            allowed = "station, gap and face_width with which both gears share a piece of the face"
            raise ModelError(problem, path=p.path, given=", ".join(ends), allowed=allowed)
        yield side, (middle + (left + right) / 2, right - left)


# places --------------------------------------------------------------------------------------------------------------


def _pin_radii(plan: Plan, distance: Mapping[str, float], log: ResolutionLog) -> Iterator[tuple[str, float]]:
    """Radius of the axes of every planet gear [m]: given, else the distance of its mesh nearest the sun."""
    radii: dict[str, float] = {}
    for p in plan.pairs:
        planets = [name for name in (p.a, p.b) if not plan.central(name)]
        if len(planets) == 1:
            radii.setdefault(plan.axis[planets[0]], distance[p.name])
    for name, member in plan.gears.items():
        if plan.central(name):
            continue
        given = given_radius(plan, plan.axis[name], log)
        radius = given.value if given is not None else radii.get(plan.axis[name])
        if radius is None:
            problem = "is missing: no mesh with a central gear says it"
            raise ModelError(problem, path=f"{plan.member_path(name)}.pin_radius", allowed="radius of its axes [m]")
        origin = "given" if member.pin_radius is not None else "geometry"
        log.note(f"{plan.member_path(name)}.pin_radius", radius, "m", origin)
        yield name, radius


def _ahead(plan: Plan, pin: Mapping[str, float], distance: Mapping[str, float]) -> dict[str, float]:
    """Polar angle of every planet gear from the branch line [rad]: 0 for the first one and what shares its axis."""
    if not pin:
        return {}

    def beyond(angle: float, mesh: tuple[GearPair, str, str]) -> float:
        p, known, new = mesh
        turn = _turn(plan, p, pin[known], pin[new], distance[p.name])
        return angle + (-turn if plan.gears[new].ahead is False else turn)

    joints = [joint for joint in _axes_joined(plan) if joint[2][1] in pin and joint[2][2] in pin]
    angle = spread({plan.axis[next(iter(pin))]: 0.0}, joints, beyond)
    return {name: angle.get(plan.axis[name], 0.0) for name in pin}


def _axes_joined(plan: Plan) -> list[tuple[str, str, tuple[GearPair, str, str]]]:
    """Axes of both gears of every pair, either way, with the pair and the gears there."""
    meshes = [(p, *ends) for p in plan.pairs for ends in ((p.a, p.b), (p.b, p.a))]
    return [(plan.axis[a], plan.axis[b], (p, a, b)) for p, a, b in meshes]


def _turn(plan: Plan, p: GearPair, known: float, new: float, between: float) -> float:
    """Angle at the centre of the stage between two axes that mesh, from the three centre distances [rad]."""
    cosine = (known**2 + new**2 - between**2) / (2 * known * new)
    if not -1.0 <= cosine < 1.0:
        problem = f"the centre distances {known * 1e3:.6g}, {new * 1e3:.6g} and {between * 1e3:.6g} mm make no triangle"
        allowed = f"between {abs(known - new) * 1e3:.6g} and {(known + new) * 1e3:.6g} mm"
        raise ModelError(problem, path=f"{p.path}.centre_distance", given=in_mm(between), allowed=allowed)
    return math.acos(cosine)


def _centres(plan: Plan, distance: Mapping[str, float]) -> dict[str, Place]:
    """Centre of every central gear [m]: the stage's, or for gears on fixed axes seen from their first partner."""
    fixed = [name for name, member in plan.gears.items() if member.kind == "gear"]
    # of every axis, by the gear at its root: whichever gear of a shaft has a partner in place puts all of them there
    place = {plan.axis[name]: (0.0, 0.0) for name in plan.gears if plan.central(name) and name not in fixed}
    if fixed and not place and len(fixed) == len(plan.gears):
        place[plan.axis[fixed[0]]] = (0.0, 0.0)

    def beside(at: Place, mesh: tuple[GearPair, str, str]) -> Place:
        angle, between = plan.gears[mesh[2]].direction or 0.0, distance[mesh[0].name]
        return at[0] + between * math.cos(angle), at[1] + between * math.sin(angle)

    place = spread(place, [joint for joint in _axes_joined(plan) if joint[2][2] in fixed], beside)
    for name in fixed:
        if plan.axis[name] not in place:
            raise ModelError("cannot be placed: it meshes with no central gear", path=plan.member_path(name))
    return {name: place[plan.axis[name]] for name in plan.gears if plan.central(name)}


def _directions(
    plan: Plan, p: GearPair, pin: Mapping[str, float], ahead: Mapping[str, float], centre: Mapping[str, Place]
) -> tuple[Angle, ...]:
    """Polar angle of e, from the centre of a to the pitch point, one per branch [turns].

    Raises
    ------
    ModelError : two gears on fixed axes that have one centre.
    """
    if p.a in centre and p.b in centre:
        # two gears on fixed axes
        (xa, ya), (xb, yb) = centre[p.a], centre[p.b]
        if xa == xb and ya == yb:
            raise ModelError("two gears that mesh have one centre", path=p.path, given=f"{p.a}, {p.b}")
        sign = -1.0 if p.internal else 1.0
        return (turns_of(math.atan2(sign * (yb - ya), sign * (xb - xa))),) * len(plan.angles)
    if p.a in pin and p.b in pin:
        a, b = (pin[n] * complex(math.cos(ahead[n]), math.sin(ahead[n])) for n in (p.a, p.b))
        offset = Phase(rest=math.atan2((b - a).imag, (b - a).real) / math.tau)
    else:
        planet = p.a if p.a in pin else p.b
        inward = p.a in pin and not p.internal
        offset = Phase(rest=ahead[planet] / math.tau) + (Phase.of(turns_of(math.pi)) if inward else Phase())
    return tuple(
        (Phase.of(angle) + offset).value if offset.rest == 0.0 else Phase.of(angle) + offset for angle in plan.angles
    )
