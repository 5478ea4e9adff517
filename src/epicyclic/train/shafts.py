"""Shafts that bend: places of supports away from their body become bodies, and the sections between them links.

Between two neighbouring places the sections are condensed statically and exactly to one link at their elastic centre.
Mass and moments of inertia are lumped at the places by the lever rule: their sum and the centre of mass are right;
tilt has the inertia of slices about their own diameters.  What projects beyond the last place moves with it rigidly.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..document.schema import ModelFile
from ..document.schema_fields import SectionTable
from ..document.validation import MOST_BODIES
from ..errors import ModelError, in_mm
from .links import end_to_end, shaft_stiffness
from .stage_bodies import seated
from .stages import Levels, Plan, density_of, elastic_constants, file_material, member_material
from .train import Body, Link, Load, ResolutionLog, ShaftSpan

# A mode at three times the excitation raises the motion by 1/(1 - 1/9): condensation misses 12 %, at twice 33 %.
_APART = 3.0
_ELEMENTS = 12  # of a span, for its lowest mode
_SAME, _DIGITS = 1e-9, 9  # [m] places that are one, and their digits


class Shafts(NamedTuple):
    """Bodies and links of a train, those of shafts that bend among them, and the spans of these shafts."""

    bodies: list[Body]
    links: list[Link]
    spans: list[ShaftSpan]


class _Piece(NamedTuple):
    """A cylinder from start to end, its diameters [m], density [kg/m^3], Young's modulus [Pa] and Poisson's ratio."""

    start: float
    end: float
    diameter: float
    bore: float
    density: float
    elastic: tuple[float, float]

    @property
    def middle(self) -> float:
        return (self.start + self.end) / 2

    def stiffness(self) -> tuple[float, dict[str, float]]:
        """Its middle, and `shaft_stiffness` there."""
        return self.middle, shaft_stiffness(self.diameter, self.bore, self.end - self.start, *self.elastic)

    def inertia(self) -> NDArray[np.float64]:
        """Mass [kg], moment of inertia about z, and that of its slices about their diameters [kg m^2]."""
        mass = self.density * math.pi / 4 * (self.diameter**2 - self.bore**2) * (self.end - self.start)
        polar = mass * (self.diameter**2 + self.bore**2) / 8
        return np.array([mass, polar, polar / 2])


def bent_shafts(
    bodies: Sequence[Body], links: Sequence[Link], plans: Sequence[Plan], model: ModelFile, log: ResolutionLog
) -> Shafts:
    """The train with shafts that bend, as `shaft_sections` state them.

    Supports, bearings and what else sits on a shaft away from its body move to bodies of their own there.

    Raises
    ------
    ModelError : sections that overlap, leave a gap or do not reach a place; a member that has no such shaft; more
        bodies than matrices have room for.
    """
    found = Shafts(list(bodies), list(links), [])
    by_name = {body.name: body for body in bodies}
    for i, body in enumerate(bodies):
        path, sections, material = _stated(body, plans, model)
        if not sections:
            continue
        _check_member(path, body, links)
        pieces = _pieces(path, sections, body.station, material, log)
        seats = {j: seat for j, link in enumerate(links) if (seat := _seat(link, body, by_name, pieces)) is not None}
        names = {round(body.station, _DIGITS): ""}
        for place, name in (*seats.values(), *_loaded(body, model)):
            names.setdefault(place, name)
        places = sorted(names)
        _check_reach(path, pieces, [places[0], places[-1]], names, body)
        stations = dict(zip(places, _stations(body, names, places, pieces), strict=True))
        found.bodies[i] = next(one for one in stations.values() if one.shaft_of is None)
        found.bodies.extend(one for one in stations.values() if one.shaft_of is not None)
        for j, (place, _) in seats.items():
            link, there = found.links[j], stations[place].name
            found.links[j] = replace(link, first=there) if link.first == body.name else replace(link, second=there)
        for left, right in pairwise(stations.values()):
            link, span = _span(path, body, left, right, _between(pieces, left.station, right.station))
            found.links.append(link)
            found.spans.append(span)
    if found.spans and len(found.bodies) > MOST_BODIES:
        problem, allowed = f"{len(found.bodies)} bodies with the places on shafts", f"at most {MOST_BODIES} bodies"
        raise ModelError(problem, path="stages", allowed=allowed)
    return found


def moved_loads(loads: Iterable[Load], bodies: Sequence[Body]) -> list[Load]:
    """External loads, those on a shaft that bends at the body of their place."""
    there = {(body.shaft_of, body.station): body.name for body in bodies if body.shaft_of is not None}
    return [replace(one, body=there.get((one.body, round(one.station, _DIGITS)), one.body)) for one in loads]


def warn_of_spans(spans: Sequence[ShaftSpan], mesh_frequencies: Sequence[float], log: ResolutionLog) -> None:
    """Warn of the spans whose own modes are not far above the highest mesh frequency [Hz]."""
    highest = max(mesh_frequencies, default=0.0)
    near = [f"{span.name} at {span.frequency:.4g} Hz" for span in spans if span.frequency < _APART * highest]
    if near:
        text = f"bending modes of spans with clamped ends below {_APART:g} times the highest mesh frequency, "
        text += f"{highest:.4g} Hz: {', '.join(near)}; condensed by statics, they are missing"
        log.coded("shaft-span-resonates", text)


def _stated(body: Body, plans: Sequence[Plan], model: ModelFile) -> tuple[str, Mapping[str, SectionTable], Levels]:
    """Path, sections and material of the shaft of a body."""
    if body.member in model.bodies:
        return f"bodies.{body.member}.shaft_sections", model.bodies[body.member].shaft_sections, file_material(model)
    stage, name = body.member.split(".")
    plan = next(plan for plan in plans if plan.name == stage)
    sections = plan.stage.members[name].shaft_sections
    return f"{plan.member_path(name)}.shaft_sections", sections, member_material(plan, name, model)


def _check_member(path: str, body: Body, links: Sequence[Link]) -> None:
    """Refuse halves, and a planet that turns on rolling bearings: they sit on a pin that stands."""
    if body.side is not None:
        allowed = "a member in one piece; of halves a neck"
        raise ModelError("of a member in two halves", path=path, given="split", allowed=allowed)
    for link in links:
        if body.branch is not None and link.rolling is not None and seated(link) == body.name:
            allowed = "stiffnesses of the bearings of a planet whose shaft turns in the carrier"
            problem = "of a planet on rolling bearings, whose inner races sit on a pin of the carrier"
            raise ModelError(problem, path=path, given=link.name, allowed=allowed)


def _pieces(
    path: str, sections: Mapping[str, SectionTable], centre: float, material: Levels, log: ResolutionLog
) -> list[_Piece]:
    """Sections in a row, each from where the one before it ends; centre of the member [m]. Raises ModelError."""
    pieces: list[_Piece] = []
    for name, section in sections.items():
        before = pieces[-1].end - centre if pieces else None
        start = section.from_ if section.from_ is not None else before
        if start is None:
            raise ModelError("is missing", path=f"{path}.{name}.from", allowed="where the first section begins")
        if before is not None and abs(start - before) > _SAME:
            problem = "overlaps the section before it" if start < before else "leaves a gap to the section before it"
            allowed = f"{in_mm(before)}, or nothing"
            raise ModelError(problem, path=f"{path}.{name}.from", given=in_mm(start), allowed=allowed)
        if section.to - start <= _SAME:
            allowed = f"more than {in_mm(start)}, where it begins"
            raise ModelError("has no length", path=f"{path}.{name}.to", given=in_mm(section.to), allowed=allowed)
        bore = section.bore or 0.0
        for key, value in {"from": start, "to": section.to, "diameter": section.diameter, "bore": bore}.items():
            log.note(f"{path}.{name}.{key}", value, "m")
        elastic = density_of(material), elastic_constants(material)
        pieces.append(_Piece(centre + start, centre + section.to, section.diameter, bore, *elastic))
    return pieces


def _seat(link: Link, body: Body, bodies: Mapping[str, Body], pieces: Sequence[_Piece]) -> tuple[float, str] | None:
    """Place [m] and name of what a link seats on the shaft of a body, away from its centre; None of other links.

    Of a gear on the shaft, or another body that a rigid coupling joins, the place is its own station.
    """
    place, name = body.station, ""
    if link.kind in ("support", "bearing") and seated(link) == body.name:
        of_kind = link.name.removeprefix(f"{body.name}/{link.kind}").strip("/")
        place, name = link.station, of_kind.split("/")[0] or link.kind
    elif link.second is not None and all(map(math.isinf, link.stiffness)):
        other = bodies[link.second if link.first == body.name else link.first]
        sits = link.kind == "shaft" and link.first == body.name
        joined = link.kind == "coupling" and pieces[0].start <= other.station <= pieces[-1].end
        if sits or (joined and body.name in (link.first, link.second)):
            place, name = other.station, other.member.replace(".", "/")
    return None if abs(place - body.station) < _SAME else (round(place, _DIGITS), name)


def _loaded(body: Body, model: ModelFile) -> Iterator[tuple[float, str]]:
    """Places [m] and names of external loads along the shaft, those of all cases so that all have the same bodies."""
    for loads in (model.loads, *(case.loads for case in model.cases.values())):
        for name, table in loads.items():
            if table.on == body.member and table.at:
                yield round(body.station + table.at, _DIGITS), f"load/{name}"


def _check_reach(
    path: str, pieces: Sequence[_Piece], ends: Sequence[float], names: Mapping[float, str], body: Body
) -> None:
    """Refuse sections that end before the first or the last place on the shaft."""
    for place in ends:
        if not pieces[0].start - _SAME <= place <= pieces[-1].end + _SAME:
            given = f"{in_mm(pieces[0].start - body.station)} to {in_mm(pieces[-1].end - body.station)}"
            allowed = f"sections that reach {names[place] or 'the centre'} at {in_mm(place - body.station)}"
            raise ModelError("does not reach what sits on the shaft", path=path, given=given, allowed=allowed)


def _between(pieces: Sequence[_Piece], low: float, high: float) -> list[_Piece]:
    """What lies between two places."""
    cut = [piece._replace(start=max(piece.start, low), end=min(piece.end, high)) for piece in pieces]
    return [piece for piece in cut if piece.end - piece.start > 0]


def _lumps(pieces: Sequence[_Piece], places: Sequence[float]) -> NDArray[np.float64]:
    """Mass [kg], moments of inertia about z and about a diameter [kg m^2] at the places, (places, 3)."""
    lumps = np.zeros((len(places), 3))
    for i, (low, high) in enumerate(pairwise(places)):
        for piece in _between(pieces, low, high):
            share = (piece.middle - low) / (high - low)
            lumps[i : i + 2] += np.outer([1 - share, share], piece.inertia())
    for end, low, high in ((0, -math.inf, places[0]), (-1, places[-1], math.inf)):
        for piece in _between(pieces, low, high):
            lumps[end] += piece.inertia()
            lever = (piece.end - piece.start) ** 2 / 12 + (piece.middle - places[end]) ** 2
            lumps[end, 2] += piece.inertia()[0] * lever
    return lumps


def _stations(
    body: Body, names: Mapping[float, str], places: Sequence[float], pieces: Sequence[_Piece]
) -> Iterator[Body]:
    """The body with its share of the shaft, and a body for every other place, in the order of the places."""
    for place, (mass, inertia, tilt) in zip(places, _lumps(pieces, places).tolist(), strict=True):
        own = body if not names[place] else replace(
            body, name=f"{body.name}/shaft/{names[place]}", shaft_of=body.name, station=place,
            mass=0.0, inertia=0.0, tilt_inertia=0.0, gear=None, outer_radius=None,
        )  # fmt: skip
        yield replace(own, mass=own.mass + mass, inertia=own.inertia + inertia, tilt_inertia=own.tilt_inertia + tilt)


def _span(path: str, body: Body, left: Body, right: Body, pieces: Sequence[_Piece]) -> tuple[Link, ShaftSpan]:
    """The link between two places, and its span; it has the name of the place that is farther from the body."""
    near, far = (left, right) if right.station > body.station else (right, left)
    centre, stiffness = end_to_end([piece.stiffness() for piece in pieces])
    link = Link(
        name=f"{far.name}/span",
        path=path,
        kind="shaft",
        first=near.name,
        second=far.name,
        centre=body.centre,
        station=centre,
        angle=body.angle,
        stiffness=tuple(stiffness.values()),
    )
    mass = sum(float(piece.inertia()[0]) for piece in pieces)
    ends = left.station, right.station
    return link, ShaftSpan(name=link.name, start=ends[0], end=ends[1], mass=mass, frequency=_clamped_mode(pieces))


def _clamped_mode(pieces: Sequence[_Piece]) -> float:
    """Lowest bending mode of a shaft with clamped ends [Hz], by short elements in one plane."""
    places = np.linspace(pieces[0].start, pieces[-1].end, _ELEMENTS + 1)
    K = np.zeros((2 * len(places), 2 * len(places)))
    for i, (low, high) in enumerate(pairwise(places)):
        centre, stiffness = end_to_end([piece.stiffness() for piece in _between(pieces, low, high)])
        # deflection and slope of both ends, as they are at the elastic centre
        rows = np.array([[1, centre - low, -1, high - centre], [0, 1, 0, -1]])
        K[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += rows.T @ np.diag([stiffness["x"], stiffness["rx"]]) @ rows
    root = 1 / np.sqrt(_lumps(pieces, places.tolist())[1:-1, [0, 2]].ravel())
    lowest = np.linalg.eigvalsh(root[:, None] * K[2:-2, 2:-2] * root)[0]
    return math.sqrt(max(float(lowest), 0.0)) / (2 * math.pi)  # of a thread rounding is all there is
