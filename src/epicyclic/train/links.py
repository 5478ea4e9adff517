"""Links of a stage and between stages: supports, bearings, necks, shafts, couplings, bolts.

A shaft or neck has the stiffness of a cylinder, as springs at its middle.  A table of the file becomes one link at its
site; bolts stand on a pitch circle, each a link of its own.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from ..bearings.checks import checked, operating_clearance, with_unit
from ..bearings.rolling_bearing import RollingBearing, contact_set, dynamic_rating, radial_curve, static_rating
from ..document.schema import SIDES, ModelFile
from ..document.schema_fields import (
    PARTS,
    BearingTable,
    BoltsTable,
    ClearanceTable,
    ForceTableOf,
    LinkTable,
    SolidTable,
    SupportTable,
)
from ..document.units import PerPlanet, Quantity
from ..errors import ModelError
from ..teeth.mesh_stiffness import ForceCurve, force_curve
from .centres import StageShape
from .gears import gap_of, width_of
from .stage_bodies import body_name, held_by_distance, member_bodies, member_centre, piece_of
from .stages import Plan, elastic_constants, file_material, gear_below, member_material, overlaid
from .train import DIRECTIONS, Body, ContactSet, Link, ResolutionLog, bodies_named, of_branch


def shaft_stiffness(
    diameter: float, bore: float, length: float, youngs_modulus: float, poisson_ratio: float
) -> dict[str, float]:
    """Stiffness of a hollow cylinder between its two ends, seen at its middle, where all six directions uncouple.

    A beam with shear has the stiffness matrix of six springs at mid-length: axial E A/l, lateral
    12 E I/(l^3 (1 + Phi)), torsional G J/l, bending E I/l; Phi = 12 E I/(kappa G A l^2) with kappa of
    `shear_coefficient`.

    diameter, bore, length [m]; youngs_modulus [Pa]; poisson_ratio [1].  Returns x y z [N/m], rx ry rz [N m/rad].
    """
    shear_modulus = youngs_modulus / (2 * (1 + poisson_ratio))
    area = math.pi / 4 * (diameter**2 - bore**2)
    second_moment = math.pi / 64 * (diameter**4 - bore**4)
    kappa = shear_coefficient(bore / diameter, poisson_ratio)
    shear = 12 * youngs_modulus * second_moment / (kappa * shear_modulus * area * length**2)
    lateral = 12 * youngs_modulus * second_moment / (length**3 * (1 + shear))
    bending = youngs_modulus * second_moment / length
    return {
        "x": lateral,
        "y": lateral,
        "z": youngs_modulus * area / length,
        "rx": bending,
        "ry": bending,
        "rz": shear_modulus * 2 * second_moment / length,
    }


def end_to_end(pieces: Sequence[tuple[float, Mapping[str, float]]]) -> tuple[float, dict[str, float]]:
    """Stiffness of shafts end to end, and the place where its six directions uncouple: their elastic centre.

    Flexibilities add; about a place that is not its middle the bending of a piece also yields laterally.  At the mean
    of the middles, each by its flexibility in bending, a moment does not displace and a force does not turn the ends
    against each other.

    pieces : middle [m] and stiffness (`shaft_stiffness`) of each.  Returns the place [m] and x y z [N/m], rx ry rz
    [N m/rad].
    """
    flexible = {key: sum(1 / stiffness[key] for _, stiffness in pieces) for key in DIRECTIONS}
    centre = sum(middle / stiffness["rx"] for middle, stiffness in pieces) / flexible["rx"]
    levers = sum((middle - centre) ** 2 / stiffness["rx"] for middle, stiffness in pieces)
    return centre, {key: 1 / (value + (levers if key in "xy" else 0.0)) for key, value in flexible.items()}


def shear_coefficient(bore_ratio: float, poisson_ratio: float) -> float:
    """Shear coefficient kappa of a hollow circular section [1], that of a solid one at bore_ratio 0 [cowper1966].

    bore_ratio : inner per outer diameter m, 0 <= m < 1 [1].  poisson_ratio : nu [1].

    kappa = 6 (1 + nu) (1 + m^2)^2 / [(7 + 6 nu) (1 + m^2)^2 + (20 + 12 nu) m^2].
    """
    wide = (1 + bore_ratio**2) ** 2
    return 6 * (1 + poisson_ratio) * wide / ((7 + 6 * poisson_ratio) * wide + (20 + 12 * poisson_ratio) * bore_ratio**2)


def solid_stiffness(table: SolidTable, length: float, material: tuple[float, float], path: str) -> dict[str, float]:
    """Stiffness of a neck, shaft or coupling by its shape, x y z [N/m], rx ry rz [N m/rad]; rz alone from G J_p.

    length [m]; material : Young's modulus [Pa], Poisson's ratio.

    Raises
    ------
    ModelError : a diameter or a torsional rigidity without length.
    """
    stiffness: dict[str, float] = {}
    if (table.diameter is not None or table.torsional_rigidity is not None) and length <= 0:
        raise ModelError("is missing", path=f"{path}.length", allowed="length of the shaft [m]")
    if table.diameter is not None:
        stiffness = shaft_stiffness(table.diameter, table.bore or 0.0, length, *material)
    if table.torsional_rigidity is not None:
        stiffness["rz"] = table.torsional_rigidity / length
    return stiffness


# links at their sites -------------------------------------------------------------------------------------------------

STIFF = math.inf
# Places of a row and laminae of a roller of the law of five rows.
_PLACES, _LAMINAE = 36, 3
_TOUCH = 1e-12  # force per the last one of a curve that is none


@dataclass(frozen=True, slots=True)
class LinkSite:
    """Where a link sits: path in the file, name in results, its bodies.

    station : axial place of the link [m] unless its table states `at`, which counts from `centre` [m].
    radius : at which an rz in N/m acts [m].
    share : of the stiffness of the table that it has [1].
    """

    path: str
    name: str
    kind: str
    first: Body
    second: str | None
    centre: float
    station: float
    radius: float = 1.0
    share: float = 1.0

    @classmethod
    def between(cls, path: str, name: str, kind: str, first: Body, second: Body, radius: float) -> LinkSite:
        """Site of a joint, in the middle between two bodies."""
        at = (first.station + second.station) / 2
        return cls(path, name, kind, first, second.name, at, at, radius)


def link_at(site: LinkSite, name: str, table: LinkTable, rest: Mapping[str, float], log: ResolutionLog) -> Link:
    """Link of one table at its site.

    rest : stiffness of the directions the table does not name [N/m, N m/rad].

    Raises
    ------
    ModelError : an rz in N/m without radius.
    """
    path = f"{site.path}.{name}" if name else site.path
    first, second = site.first.name, site.second
    if site.kind == "bearing" and second is not None:
        first, second = second, first  # of a bearing the carrier stands first
    stiffness, curves = _stiffnesses(site, path, table, rest, log)
    rolling, lubrication, contacts = None, None, None
    if isinstance(table, BearingTable) and table.type is not None:
        rolling = _rolling(site, path, table, log)
        if table.viscosity_ratio is not None and table.contamination is not None:
            lubrication = table.viscosity_ratio, table.contamination
        if held := table.held_by_parts():
            inner_first = second is not None or site.kind == "support"
            radial, contacts, own = _law_of_parts(rolling, held, inner_first=inner_first)
            stiffness = (*(one or rest for one, rest in zip(own, stiffness, strict=False)), *stiffness[len(own) :])
            curves += radial
            for place, key in enumerate(DIRECTIONS):
                if key in held:
                    unit = "N/m" if key in "xyz" else "N m/rad"
                    log.note(f"{path}.{key}", stiffness[place], unit, "the parts, near half of the static rating")
    friction = {} if table.friction is None else table.friction.model_dump(exclude_none=True)
    return Link(
        name=f"{site.name}/{name}" if name else site.name,
        path=path,
        kind=site.kind,
        first=first,
        second=second,
        centre=site.first.centre,
        station=site.station if table.at is None else site.centre + table.at,
        angle=site.first.angle,
        stiffness=stiffness,
        damping=tuple((getattr(table.damping, direction, None) or 0.0) * site.share for direction in DIRECTIONS),
        clearance=of_branch(table.clearance, site.first.branch),
        exponent=table.exponent if table.exponent is not None else 1.0,
        load=(table.load or 0.0) * site.share,
        friction=tuple((key, value * site.share if key == "force" else value) for key, value in friction.items()),
        curves=curves,
        rolling=rolling,
        lubrication=lubrication,
        contacts=contacts,
    )


def _rolling(site: LinkSite, path: str, table: BearingTable, log: ResolutionLog) -> RollingBearing:
    """The rolling bearing of a table that states its parts; missing ratings follow from them.

    Raises
    ------
    ModelError : parts that do not fit, a site in two halves of a carrier.
    """
    stated = {name: getattr(table, name) for name in ("type", *PARTS) if getattr(table, name) is not None}
    given, words = stated.pop("internal_clearance", 0.0), ""
    for name in ("viscosity_ratio", "contamination"):
        stated.pop(name, None)
    if site.share != 1:
        allowed = "named bearings, each at its place `at`"
        raise ModelError("one rolling bearing in two halves of a carrier", path=path, given=table.type, allowed=allowed)
    if stated.get("rows", 1) > 1 and table.element_diameter is not None and table.type != "spherical roller":
        stated.setdefault("row_distance", table.element_length or table.element_diameter)
    bearing, where = RollingBearing(**stated), f"{path}.internal_clearance"
    checked(bearing, path, parts=True)
    _inside_gear(site, path, table, bearing, log)
    if isinstance(given, ClearanceTable):
        given, words = _in_operation(given, bearing, where, log)
    try:
        bearing = checked(replace(bearing, clearance=of_branch(given, site.first.branch)), path)
    except ModelError as error:
        if error.path != f"{path}.clearance":
            raise
        problem = f"{error.problem}, in operation: {words}" if words else error.problem
        raise ModelError(problem, path=where, given=error.given, allowed=error.allowed) from None
    for name, value in (("rating", dynamic_rating(bearing)), ("static_rating", static_rating(bearing))):
        log.note(f"{path}.{name}", value, "N", *([] if name in stated else ["the parts"]))
    return bearing


def _in_operation(table: ClearanceTable, bearing: RollingBearing, path: str, log: ResolutionLog) -> tuple[float, str]:
    """Clearance in operation [m] and its origin; warns where fits and temperature take more than there is.

    Raises
    ------
    ModelError : a table from which none follows.
    """
    races = bearing.pitch_diameter - bearing.element_diameter, bearing.pitch_diameter + bearing.element_diameter
    try:
        left, words = operating_clearance(bearing.type, races, **table.model_dump(exclude_none=True))
    except ModelError as error:
        raise error.at(f"{path}.{error.path}") from None
    log.note(path, left, "m", words)
    if left < min(0.0, table.initial or 0.0):
        log.coded("bearing-preloaded", f"{path}: {with_unit('clearance', left)} in operation ({words})")
    return left, words


def _inside_gear(site: LinkSite, path: str, table: BearingTable, bearing: RollingBearing, log: ResolutionLog) -> None:
    """Refuse the bearing of a planet that reaches beyond the roots of the gear in which it sits.

    Warns of outer rows whose centre is beyond the face, where a hub or another gear of the shaft may be.

    Raises
    ------
    ModelError : it does, at a place within the face of the gear.
    """
    gear, outside = site.first.gear, bearing.pitch_diameter + bearing.element_diameter
    face = math.inf if gear is None or gear.face_width is None else gear.whole_width
    aside = abs((site.station if table.at is None else site.centre + table.at) - site.first.station)
    if site.kind != "bearing" or gear is None or aside >= face / 2:
        return
    if outside > 2 * gear.root_radius:
        problem = f"the bearing reaches {1e3 * outside:.4g} mm, beyond the root circle of its gear"
        allowed = f"with element_diameter less than {2e3 * gear.root_radius:.4g} mm, or a place `at` beside the face"
        given = with_unit("pitch_diameter", bearing.pitch_diameter)
        raise ModelError(problem, path=f"{path}.pitch_diameter", given=given, allowed=allowed)
    apart = (bearing.rows - 1) * bearing.row_distance
    if aside + apart / 2 > face / 2:
        log.coded("rows-beside-gear", f"{path}: rows {1e3 * apart:.4g} mm apart in a gear {1e3 * face:.4g} mm wide")


def _law_of_parts(
    bearing: RollingBearing, held: Collection[str], *, inner_first: bool
) -> tuple[tuple[tuple[int, ForceCurve], ...], ContactSet | None, tuple[float, ...]]:
    """Radial law, along x and y, of one row without contact angle, else the contacts of its law of five rows.

    With them the stiffness of the first directions [N/m, N m/rad].  Contacts keep the nominal contact angle.

    held : directions that follow the law; of the others contacts know nothing.
    inner_first : whether the first body of the link is on the inner race.
    """
    if not bearing.contact_angle and bearing.rows == 1:
        # up to the static rating, beyond which the races are dented
        deflection, force, slope = (tuple(v.tolist()) for v in _radial_curve(bearing, static_rating(bearing) / 4))
        touch = max(sum(value <= _TOUCH * force[-1] for value in force) - 1, 0)
        curve = ForceCurve(deflection=deflection[touch:], force=(0.0, *force[touch + 1 :]), slope=slope[touch:])
        return ((0, curve), (1, curve)), None, (curve.stiffness,) * 2
    contacts = contact_set(bearing, places=_PLACES, laminae=_LAMINAE)
    normals = contacts.normals * [1.0 if key in held else 0.0 for key in DIRECTIONS[:5]] * (1 if inner_first else -1)
    coefficient = contacts.weight * contacts.coefficient
    law = ContactSet(
        normals=tuple(map(tuple, normals.tolist())),
        gap=tuple(contacts.gap.tolist()),
        coefficient=(coefficient,) * len(contacts.gap),
        exponent=contacts.exponent,
        load=static_rating(bearing) / 2,
    )
    return (), law, law.stiffness


_radial_curve = lru_cache(maxsize=64)(radial_curve)  # planets share it


def _stiffnesses(
    site: LinkSite, path: str, table: LinkTable | BoltsTable, rest: Mapping[str, float], log: ResolutionLog
) -> tuple[tuple[float, ...], tuple[tuple[int, ForceCurve], ...]]:
    """Stiffness in x y z [N/m], rx ry rz [N m/rad], and force over deflection of the directions that state a table.

    At a shared site the share of finite stiffnesses and of the force.  Of a direction that follows a table the
    stiffness is the nominal one.

    rest : by key of the table, in the order of the six directions: stiffness where it is not named.
    """
    values: list[float] = []
    curves: list[tuple[int, ForceCurve]] = []
    for number, (key, value) in enumerate(rest.items()):
        stated, unit = getattr(table, key), "N/m" if number < 3 else "N m/rad"
        if isinstance(stated, ForceTableOf):
            radius = 1.0
            if key == "rz" and stated.deflection is not None and stated.deflection.unit == "m":
                radius = _known(site.radius, f"{path}.{key}", "a table in m and N")
            curve = force_curve(*stated.curves[0]).scaled(deflection=1 / radius, force=radius * site.share)
            curves.append((number, curve))
            value = curve.stiffness / site.share
            log.note(f"{path}.{key}.tangent", value, unit, "half of its last force")
        elif stated is None:
            log.note(f"{path}.{key}", value, unit, "default" if math.isinf(value) or not value else "geometry")
        else:
            whole = _torsional(stated, site.radius, f"{path}.{key}") if isinstance(stated, Quantity) else stated
            value = of_branch(whole, site.first.branch)
            log.note(f"{path}.{key}", list(whole) if isinstance(whole, tuple) else whole, unit)
        values.append(value * site.share if math.isfinite(value) else value)
    return tuple(values), tuple(curves)


def _torsional(stated: Quantity, radius: float, path: str) -> PerPlanet:
    """Torsional stiffness [N m/rad]; one in N/m acts at `radius` [m]. Raises ModelError for an unknown radius."""
    if stated.unit == "N m/rad":
        return stated.value
    radius = _known(radius, path, stated.value)
    if isinstance(stated.value, tuple):
        return tuple(value * radius**2 for value in stated.value)
    return stated.value * radius**2


def _known(radius: float, path: str, given: object) -> float:
    """A radius [m]. Raises ModelError for an unknown one."""
    if not math.isfinite(radius):
        raise ModelError("in N/m, but no radius is known", path=path, given=given, allowed="a value in N m/rad")
    return radius


# bolts ----------------------------------------------------------------------------------------------------------------


def links_at(site: LinkSite, name: str, table: LinkTable, rest: Mapping[str, float], log: ResolutionLog) -> list[Link]:
    """Link of one table at its site, see `link_at`, and its bolts; itself only where it holds anything beside them.

    A bolt stands on the circle at its own angle, its x axis radial and its y axis tangential: with stiffness k_r, k_t,
    k_z of one, n >= 3 equal bolts evenly spaced on the radius r hold a member with x and y n (k_r + k_t)/2, rz
    n k_t r^2, z n k_z, rx and ry n k_z r^2/2.  A direction of a bolt that is not named is rigid.
    """
    link, bolts = link_at(site, name, table, rest, log), table.bolts
    if bolts is None:
        return [link]
    holds = any(link.stiffness) or any(link.damping)
    for key in ("clearance", "exponent", "friction"):
        if (given := getattr(table, key)) and not holds:
            allowed = "stiffnesses of the link beside its bolts; or no law"
            raise ModelError(
                "acts on nothing: bolts alone hold here", path=f"{link.path}.{key}", given=given, allowed=allowed
            )
    path = f"{link.path}.bolts"
    log.note(f"{path}.radius", bolts.radius, "m")
    stiffness, curves = _stiffnesses(site, path, bolts, dict.fromkeys(("radial", "tangential", "z"), STIFF), log)
    count = bolts.count or 1
    (x, y), radius = link.centre, bolts.radius
    return [link] * holds + [
        Link(
            name=f"{link.name}/bolts/{number}",
            path=path,
            kind=link.kind,
            first=link.first,
            second=link.second,
            centre=(x + radius * math.cos(angle), y + radius * math.sin(angle)),
            station=link.station,
            angle=angle,
            stiffness=(*stiffness, 0.0, 0.0, 0.0),
            curves=curves,
        )
        for number, angle in enumerate(bolts.angles or [math.tau * i / count for i in range(count)], start=1)
    ]


def links_of_stage(
    shape: StageShape, model: ModelFile, bodies: Mapping[str, Body], log: ResolutionLog
) -> Iterator[Link]:
    """All links of a stage.

    Raises
    ------
    ModelError : halves that nothing holds together, a member that carries nothing it could carry.
    """
    plan = shape.plan
    for name, member in plan.stage.members.items():
        planet = not plan.central(name)
        for number in range(1, plan.branches + 1) if planet else (None,):
            if member.on is None or (member.bearing if planet else member.support) is not None:
                for body in member_bodies(plan, name, number).values():
                    yield from _seat(plan, name, bodies[body], bodies, model, log)
            yield from _joints(plan, name, number, bodies, model, log)
        if not planet and plan.split(name) and member.neck is None:
            _check_halves(plan, name, model)


def links_of_bodies(model: ModelFile, bodies: Mapping[str, Body], log: ResolutionLog) -> Iterator[Link]:
    """Supports of the file's `[bodies]`."""
    for name, body in model.bodies.items():
        path = f"bodies.{name}.support"
        second = _carrying(body.support, bodies, None, path)
        yield from _bearings_of_seat(path, bodies[name], [second], body.support, model, log)


# supports and bearings -----------------------------------------------------------------------------------------------


def _seat(
    plan: Plan, name: str, body: Body, bodies: Mapping[str, Body], model: ModelFile, log: ResolutionLog
) -> Iterator[Link]:
    """What a body is carried by, its seat: the support of a central body, the bearing of a planet on its carrier.

    Raises
    ------
    ModelError : a planet borne in the housing that its carrier turns against.
    """
    held, side, carried = model.operation.held, body.side, body.branch is not None
    table, path = overlaid(plan.member_levels(name, side), "bearing" if carried else "support")
    turning = plan.carrier is not None and f"{plan.name}.{plan.carrier}" not in held
    if carried and turning and table is not None and table.to == "housing":
        problem = f"{name} goes round with {plan.carrier}, and the carrier turns in the housing"
        allowed = f"the carrier, which is the default; the housing where {plan.carrier} is held"
        raise ModelError(problem, path=f"{path}.to", given="housing", allowed=allowed)
    seconds: list[str | None] = [_carrying(table, bodies, side, path)]
    if carried and plan.carrier is not None and (table is None or table.to is None):
        # of a split carrier the half of this side, both for a planet in one piece
        halves = member_bodies(plan, plan.carrier, None)
        seconds = [halves[side]] if side in halves else [*halves.values()]
    return _bearings_of_seat(path, body, seconds, table, model, log)


def _carrying(table: SupportTable | None, bodies: Mapping[str, Body], side: str | None, path: str) -> str | None:
    """Body that `to` names, None = the frame."""
    if table is None or table.to is None or table.to == "housing":
        return None
    return body_of(table.to, bodies, f"{path}.to", side)


def body_of(reference: str, bodies: Mapping[str, Body], path: str, side: str | None = None) -> str:
    """Body of a reference such as ``main.sun.right``; of a split member the half of the same side.

    Raises
    ------
    ModelError : a planet, which there is several of, or a split member without a side.
    """
    named = [body.name for body in bodies_named(reference, bodies.values()) if body.branch is None]
    same_side = [name for name in named if bodies[name].side == side] if len(named) > 1 else named
    if len(same_side) != 1:
        split = len(named) > 1
        raise ModelError(
            "names a split member" if split else "names no single body",
            path=path,
            given=reference,
            allowed=f"{reference}.left or {reference}.right" if split else "a central member or a body",
        )
    return same_side[0]


def _bearings_of_seat(
    path: str,
    body: Body,
    seconds: Sequence[str | None],
    support: SupportTable | None,
    model: ModelFile,
    log: ResolutionLog,
) -> Iterator[Link]:
    """One link for every bearing of a seat; a direction that none names is rigid (rz: where held) in the first one.

    Tilt that none names is rigid too, but where two bearings at a distance hold it by their own stiffness.
    Bolts hold in every direction, so that beside them no other direction is rigid unless named.  Of two carrier plates
    a bearing sits in the one on its side of the planet's centre, in the middle half in each.

    seconds : names of the bodies that carry it, of two plates both; None = the frame.

    Raises
    ------
    ModelError : a body held on itself.
    """
    support = SupportTable() if support is None else support
    if body.name in seconds:
        raise ModelError(
            "holds a body on itself", path=f"{path}.to", given=support.to, allowed="housing, or another body"
        )
    listed: list[tuple[str, LinkTable]] = [("", support)] if not support.bearings or support.directions() else []
    listed += support.bearings.items()
    named = {d for _, link in listed for d in link.directions()}
    if any(link.bolts is not None for _, link in listed):
        named = set(DIRECTIONS)
    named |= held_by_distance([link for _, link in listed], body.branch)
    free: dict[str, float] = dict.fromkeys(DIRECTIONS, 0.0)
    unnamed: dict[str, float] = {d: 0.0 if d in named else STIFF for d in DIRECTIONS}
    if body.member not in model.operation.held:
        unnamed["rz"] = 0.0
    kind = "support" if body.branch is None else "bearing"
    unplaced = body.kind == "carrier" and not model.stages[body.frame].branches  # no planets, and so no radius of pins
    for second in seconds:
        plate = second.rsplit("/", 1)[-1] if second is not None and len(seconds) > 1 else None
        for i, (name, link) in enumerate(listed):
            if plate is not None and link.at and (plate == "left") != (link.at < 0):
                continue
            half = plate is not None and not link.at
            site = LinkSite(
                path=path,
                name=f"{body.name}/{kind}/{plate}" if half else f"{body.name}/{kind}",
                kind=kind,
                first=body,
                second=second,
                centre=member_centre(body, model),
                station=body.station,
                radius=math.nan if unplaced else body.reference_radius,
                share=0.5 if half else 1.0,
            )
            yield from links_at(site, name, link, free if i else unnamed, log)


# necks, shafts, couplings --------------------------------------------------------------------------------------------


def _joints(
    plan: Plan, name: str, number: int | None, bodies: Mapping[str, Body], model: ModelFile, log: ResolutionLog
) -> Iterator[Link]:
    """Neck between the halves of a member, and shaft to the member it sits on; directions that the shape of a solid
    does not give are rigid.

    number : of its branch (1 ..), None of a central member.

    Raises
    ------
    ModelError : a diameter or a torsional rigidity without length.
    """
    member = plan.stage.members[name]
    pieces = member_bodies(plan, name, number)
    material = elastic_constants(member_material(plan, name, model))
    # kind, name in results, the two bodies, table, and the length it has unless stated [m]
    joints: list[tuple[str, str, Body, Body, SolidTable, float]] = []
    if member.neck is not None:
        left, right = bodies[pieces["left"]], bodies[pieces["right"]]
        between = (width_of(plan, name) or 0.0) + gap_of(plan, name)
        joints.append(("neck", body_name(plan.name, name, number), left, right, member.neck, between))
    if (below := gear_below(member)) is not None:
        for side, body in pieces.items():
            first, second = bodies[piece_of(plan, below, number, side)], bodies[body]
            apart = abs(second.station - first.station)
            joints.append(("shaft", body, first, second, member.shaft or SolidTable(), apart))
    for kind, whose, first, second, table, default in joints:
        path = f"{plan.member_path(name)}.{kind}"
        rest: dict[str, float] = dict.fromkeys(DIRECTIONS, STIFF)
        rest |= solid_stiffness(table, table.length or default, material, path)
        site = LinkSite.between(path, f"{whose}/{kind}", kind, first, second, first.reference_radius)
        yield link_at(site, "", table, rest, log)


def couplings(model: ModelFile, bodies: Mapping[str, Body], log: ResolutionLog) -> Iterator[Link]:
    """All couplings.

    Raises
    ------
    ModelError : an end that is no single body, an rz in N/m without radius, a fixed shaft without its shape.
    """
    material = elastic_constants(file_material(model))
    for name, table in model.couplings.items():
        path = f"couplings.{name}"
        first, second = (bodies[body_of(end, bodies, f"{path}.between")] for end in table.between)
        shape = solid_stiffness(table, table.length or 0.0, material, path)
        if table.ends == "fixed" and not {"x", "rz"} <= {*shape, *table.directions()}:
            raise ModelError(
                "is missing", path=f"{path}.diameter", allowed="diameter and length of a shaft with fixed ends"
            )
        rest: dict[str, float] = dict.fromkeys(DIRECTIONS, 0.0)
        rest["rz"] = shape.get("rz", STIFF if table.bolts is None else 0.0)
        if table.ends == "fixed":
            rest |= shape
        site = LinkSite.between(path, name, "coupling", first, second, table.radius or 1.0)
        yield from links_at(site, "", table, rest, log)


def _check_halves(plan: Plan, name: str, model: ModelFile) -> None:
    """Halves without a neck need something else that keeps each of them from turning away."""
    key = f"{plan.name}.{name}"
    ends = {end for table in model.couplings.values() for end in table.between}
    for side in SIDES if key not in model.operation.held else ():
        table, _ = overlaid(plan.member_levels(name, side), "support")
        links = [] if table is None else [table, *table.bearings.values()]
        sprung = any(link.rz is not None and link.rz.value != 0.0 for link in links)
        bolted_on = any(link.bolts is not None and link.bolts.tangential != 0.0 for link in links)
        if not sprung and not bolted_on and f"{key}.{side}" not in ends:
            problem = f"nothing holds the {side} half: neither neck nor hold"
            allowed = "a neck, a held member, support.rz, bolts, or a coupling at each half"
            raise ModelError(problem, path=plan.member_path(name), given="split = true", allowed=allowed)
