"""What a model file leaves open: choices that matter, and what a train still lacks for each verb.

Choices are what it says, or leaves to a default, of tilt and of loads along the face.  What a verb lacks is told by the
same checks that the verb makes, made once, without its work.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

from ...errors import ConvergenceError, ModelError
from ...statics.equilibrium import compliance_of, require_balance
from ...statics.record import standing_load
from ...statics.tangent import linear
from ...system.assembly import assemble
from ...system.system import System
from ...system.tooth_pairs import loaded_mesh, mean_force, pair_of, tooth_warnings
from ...train.bodies import Body, Link, Mesh
from ...train.power import require_contact, require_flow
from ...train.stage_bodies import link_row, tilt_groups
from ...train.train import Train
from ...warning_codes import CodedText, coded
from ..modes.eigen import mean_modes
from ..response.spectra import mesh_tones, require_damping

_TILTS = ("rx", "ry")
_NO_LEVER = 1e-12  # [m, or 1 of an angle] rounding of cosines, a lever of no rigid direction


# --- choices ---------------------------------------------------------------------------------------------------------


class Choice(NamedTuple):
    """One choice.  path : its key in the file.  origin : given, default, ...  effect : what it does."""

    path: str
    value: str
    origin: str
    effect: str


def choices(train: Train) -> list[Choice]:
    """Of every member what holds its tilt, and of every pair the slices of its meshes, in the order of the file."""
    origins = {value.path: value.origin for value in train.values}
    group = tilt_groups(train.bodies, train.links)
    members: dict[str, Body] = {}
    for body in train.bodies:
        members.setdefault(body.member, body)
    pairs: dict[str, Mesh] = {}
    for mesh in train.meshes:
        pairs.setdefault(mesh.pair, mesh)
    tilts = [_tilt(train, body, group, origins) for body in members.values()]
    askew = {item.body for item in train.displacements if item.cause == "tilt"}
    apart = tilt_groups(train.bodies, train.links, askew)
    return tilts + [_slices(mesh, apart, origins) for mesh in pairs.values()]


def _tilt(train: Train, body: Body, group: dict[str, str], origins: dict[str, str]) -> Choice:
    """What holds the tilt of one body, the first of its member: links to what carries it, about its own centre."""
    links = [link for link in train.links if body.name in (link.first, link.second)]
    seats = [link for link in links if link.kind in ("support", "bearing") and _holds(link, body)] or links
    path = f"{seats[0].path.rsplit('.bolts', 1)[0]}.tilt" if seats else f"{body.member}.tilt"
    stated = [origins.get(f"{link.path}.{name}", "default") for link in seats for name in _TILTS]
    origin = next((source for source in stated if source not in ("default", "geometry")), "default")
    base = next((link.first if link.first != body.name else link.second for link in seats), None)
    where = base or "its frame"
    if seats and group[body.name] == group[base or ""]:
        return Choice(path, "rigid", origin, f"{body.member} follows {where} in tilt: no degree of freedom")
    about = [sum(_tilt_stiffness(link, body)[i] for link in seats) for i in range(len(_TILTS))]
    value = ", ".join(f"{name} {number:.4g} N m/rad" for name, number in zip(_TILTS, about, strict=True))
    places = [link.name.rsplit("/", 1)[-1] for link in seats]
    if not any(about):
        return Choice(path, "free", origin, f"only its meshes, necks and shafts hold {body.member} in tilt")
    if any(any(link.stiffness[3:5]) for link in seats):
        return Choice(path, value, origin, f"{body.member} tilts against {where} on the stiffness of {_and(places)}")
    effect = f"{body.member} tilts against {where}; {_and(places)} hold it by their distance, sum k z^2"
    return Choice(path, value, origin, effect)


def _holds(link: Link, body: Body) -> bool:
    """Whether a support or bearing is the body's own seat, not that of what it carries."""
    return body.name == (link.second if link.kind == "bearing" and link.second is not None else link.first)


def _tilt_stiffness(link: Link, body: Body) -> tuple[float, float]:
    """Stiffness of one link against tilts of the body about the axes rx and ry of its centre [N m/rad]."""
    centre, about = (*body.centre, body.station), [0.0, 0.0]
    cosine, sine = math.cos(body.angle), math.sin(body.angle)
    for direction, stiffness in enumerate(link.stiffness):
        _, _, _, x, y, _ = link_row(link, direction, centre)
        for i, lever in enumerate((cosine * x + sine * y, cosine * y - sine * x)):
            if stiffness and abs(lever) > _NO_LEVER:
                about[i] += stiffness * lever**2
    return about[0], about[1]


def _and(names: Sequence[str]) -> str:
    """Names in a sentence, each once."""
    once = list(dict.fromkeys(names))
    return once[0] if len(once) == 1 else f"{', '.join(once[:-1])} and {once[-1]}"


def _slices(mesh: Mesh, group: dict[str, str], origins: dict[str, str]) -> Choice:
    """Slices of one pair of gears, and what they leave of its tilt stiffness."""
    path, count = f"{mesh.pair}.slices", max(len(mesh.slices), 1)
    origin = origins.get(path, "default")
    if group[mesh.a] == group[mesh.b]:
        effect = "the gears cannot tilt against each other: the load along the face is even"
        return Choice(path, str(count), origin, effect)
    if count == 1:
        return Choice(path, "1", origin, "no stiffness of the mesh against tilt, no load along the face")
    width = count * (mesh.slices[1].station - mesh.slices[0].station)
    tilt = mesh.stiffness * math.cos(mesh.base_helix) ** 2 * width**2 / 12 * (1 - count**-2)
    effect = (
        f"tilt stiffness of the mesh {tilt:.4g} N m/rad in its transverse plane of action, {1e2 / count**2:.2g} % low"
    )
    return Choice(path, str(count), origin, effect)


# --- what a verb lacks -----------------------------------------------------------------------------------------------

_RESPONSE = ("equations", "inertia", "damping", "speed", "balance")
NEEDS: dict[str, tuple[str, ...]] = {
    "allocate": ("equations", "torque", "balance", "tolerances", "prices"),
    "campbell": ("equations", "inertia", "speed"),
    "contact": ("torque", "first_teeth"),
    "efficiency": ("flow", "contact_lines"),
    "matrices": ("equations", "inertia"),
    "modes": ("equations", "inertia"),
    "modulation": (*_RESPONSE, "ring"),
    "relief": ("torque", "any_teeth"),
    "sensitivity": ("equations", "inertia"),
    "sharing": (*_RESPONSE, "torque"),
    "stability": ("equations", "inertia", "speed"),
    "static": ("equations", "balance"),
    "steady": _RESPONSE,
    "stiffness": (),
    "sweep": _RESPONSE,
    "tolerance": ("equations", "torque", "balance", "tolerances"),
    "track": ("equations", "inertia"),
    "train_contact": ("equations", "torque", "teeth", "balance"),
    "transient": ("equations", "inertia", "speed", "balance"),
}
"""Verb -> what it needs, methods of `Readiness`; options may need less (``sharing --method static``) or more."""
# Needs that ask the assembled train: without it they say the same as `equations`.
_ASSEMBLED = ("inertia", "damping", "balance")


class Readiness:
    """What one train lacks; every check is made once.

    train : resolved.
    """

    def __init__(self, train: Train) -> None:
        self.train = train
        self._problems: dict[str, str] = {}

    def lacking(self) -> dict[str, list[str]]:
        """Verb -> what it still needs, messages with their paths; none where it is ready."""
        lacking: dict[str, list[str]] = {}
        for verb, needs in NEEDS.items():
            asked = needs if not self.problem("equations") else [need for need in needs if need not in _ASSEMBLED]
            lacking[verb] = list(dict.fromkeys(text for need in asked if (text := self.problem(need))))
        return lacking

    def problem(self, need: str) -> str:
        """Message of one need that is not met, else ""."""
        if need not in self._problems:
            check: Callable[[], object] = getattr(self, need)
            self._problems[need] = ""
            try:
                check()
            except (ModelError, ConvergenceError) as error:
                self._problems[need] = str(error)
        return self._problems[need]

    @cached_property
    def system(self) -> System:
        """The assembled train.  Raises ModelError where its equations cannot be written."""
        return assemble(self.train)

    @cached_property
    def teeth_said(self) -> tuple[CodedText, ...]:
        """Warnings of tooth contact of the first mesh of every pair that has teeth, and why a pair has no contact."""
        said: list[CodedText] = []
        for pair in dict.fromkeys(mesh.pair for mesh in self.train.meshes):
            mesh = next(mesh for mesh in self.train.meshes if mesh.pair == pair)
            if mesh.teeth is None:
                continue
            try:
                said += tooth_warnings(pair_of(self.train, mesh), mesh)
            except ModelError as error:
                said.append(coded("no-tooth-contact", str(error)))
        return tuple(dict.fromkeys(said))

    def equations(self) -> object:
        """Check that the train can be assembled."""
        return self.system

    def inertia(self) -> object:
        """Check that every free coordinate has mass, and that the mean system has modes."""
        self.system.require_inertia()
        return mean_modes(linear(self.system))

    def damping(self) -> None:
        """Check that something damps."""
        require_damping(self.system)

    def speed(self) -> object:
        """Check that the meshes have a frequency."""
        if self.train.kinematics.speed is None:
            raise ModelError("the speed of one member is missing", path="operation.speed", allowed="e.g. 1500 rpm")
        return None if self.problem("equations") else mesh_tones(self.system)

    def torque(self) -> None:
        """Check that torque passes a mesh."""
        if not mean_force(self.train, loaded_mesh(self.train)) > 0:
            raise ModelError("no torque loads the teeth", path="operation.torque", allowed="a torque of a member")

    def tolerances(self) -> None:
        """Check that a number of the file has a tolerance."""
        if not self.train.document.get("tolerance"):
            raise ModelError("no tolerance is given", path="tolerance", allowed='"PATH" = "normal(mean, deviation)"')

    def prices(self) -> None:
        """Check that a tolerance has grades with prices."""
        table = self.train.document.get("tolerance")
        if not (isinstance(table, Mapping) and table.get("cost")):
            raise ModelError("no grade has a price", path="tolerance.cost", allowed='"GRADE or distribution" = PRICE')

    def flow(self) -> None:
        """Check that power flows."""
        require_flow(self.train.kinematics)

    def contact_lines(self) -> None:
        """Check that the contact lines of every pair are known and touch."""
        for mesh in self.train.meshes:
            require_contact(mesh)

    def balance(self) -> None:
        """Check that the mean load works on no motion without stiffness."""
        require_balance(compliance_of(self.system).free, standing_load(self.system)[None], self.system)

    def ring(self) -> None:
        """Check that a stage has a ring for a sensor."""
        if not any(mesh.internal for mesh in self.train.meshes):
            raise ModelError("no stage has a ring for its planets to pass along", path="stages", allowed="a ring")

    def first_teeth(self) -> object:
        """Check that the first mesh that torque passes has teeth that can bear."""
        return pair_of(self.train, loaded_mesh(self.train))

    def any_teeth(self) -> object:
        """Check that some mesh has teeth that can bear."""
        return pair_of(self.train, next((m for m in self.train.meshes if m.teeth is not None), self.train.meshes[0]))

    def teeth(self) -> None:
        """Check that every pair has teeth that can bear."""
        for mesh in {mesh.pair: mesh for mesh in reversed(self.train.meshes)}.values():
            pair_of(self.train, mesh)
