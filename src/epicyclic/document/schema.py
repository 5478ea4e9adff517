"""The normalised document: every table of a model file as a frozen pydantic model, in SI, references as full paths.

A value that is None was not given. Per-planet values are one number or a tuple. Where a key takes two kinds of
quantity its value is a `Quantity` whose `unit` gives the kind.  Names of stages, members and bodies are checked here,
and references to them written out.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import product
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from ..errors import ModelError
from ..limits import TABLES, WIND
from .deviations import DeviationsTable
from .schema_fields import (
    Angle,
    Angles,
    CouplingTable,
    ElasticTable,
    Length,
    MeshForceTable,
    Place,
    ReducedTable,
    RippleTable,
    SchemaTable,
    SectionTable,
    Small,
    SolidTable,
    Span,
    SupportTable,
    Unit,
    key,
)
from .units import MESH, SMALL, PerPlanet, Quantity

FORMAT = 2  # version of the format of the file
Kind = Literal["sun", "planet", "ring", "carrier", "gear"]
KIND_BY_NAME: dict[str, Kind] = {
    "sun": "sun",
    "planet": "planet",
    "ring": "ring",
    "carrier": "carrier",
    "wheel": "gear",
    "pinion": "gear",
}
LIMIT_ANGLE = 1.0471975511965976  # 60 deg: nothing steeper is cut, and a bare "20" (rad) is caught
Radius = Annotated[float, Unit("length", low=1e-5)]
Slant = Annotated[float, Unit("angle", low=0, high=LIMIT_ANGLE)]
PressureAngle = Annotated[float, Unit("angle", low=0, high=LIMIT_ANGLE, above=True)]
Coefficient = Annotated[float, Unit("ratio", low=0)]
Mass = Annotated[float, Unit("mass", low=0)]
Inertia = Annotated[Quantity, Unit("inertia mass", low=0)]
TiltInertia = Annotated[float, Unit("inertia", low=0)]
Force = Annotated[float, Unit("force")]
Moment = Annotated[float, Unit("torque")]
Lengths = Annotated[tuple[float, ...], Unit("length", lists=True)]
Coefficients = Annotated[tuple[float, ...], Unit("ratio", lists=True)]


_SECTIONS = "sections of its shaft from left to right, by number or name: it bends between its supports; default rigid"


class MaterialTable(SchemaTable):
    """Material of the gears."""

    density: Annotated[float, Unit("density", low=0, above=True)] | None = key(None, "density; default 7850 kg/m^3")
    youngs_modulus: Annotated[float, Unit("pressure", low=0, above=True)] | None = key(
        None, "Young's modulus; default 206 GPa"
    )
    poisson_ratio: Annotated[float, Unit("ratio", low=0, high=0.5)] | None = key(None, "Poisson's ratio; default 0.3")


DampingRatio = Unit(
    "ratio",
    low=0,
    high=1,
    below=True,
    reason='with a ratio of 1 nothing oscillates any more; gear trains have 0.01 to 0.1, "3 %" is 0.03',
)


class DampingTable(SchemaTable):
    """Damping of the whole train: modal, or proportional, or of every mesh."""

    modal: Annotated[float, DampingRatio] | None = key(
        None, "damping ratio of every elastic mode; without any damping there is no steady response"
    )
    mass: Annotated[float, Unit("rate", low=0)] | None = key(None, "proportional damping, factor of the mass matrix")
    stiffness: Annotated[float, Unit("time", low=0)] | None = key(None, "proportional damping, factor of the stiffness")
    mesh: Annotated[float, DampingRatio] | None = key(None, "damping ratio of every mesh")


class ReliefTable(SchemaTable):
    """Material taken off towards an edge of the flank: the tip, the lowest contact, or both ends of the face."""

    amount: Small | None = key(None, "material missing at the edge, along the tooth normal")
    length: Span | None = key(None, "where it fades: height of the tooth (radial); of end relief along the axis")
    shape: Literal["linear", "parabolic"] = key("linear", "shape of the relief over its length: linear or parabolic")


class ProfileTable(SchemaTable):
    """A measured profile: material missing at heights below the tip circle, linear between."""

    below_tip: Lengths = key(..., "heights below the tip circle, rising")
    missing: Annotated[tuple[float, ...], Unit("length", lists=True, likely=SMALL)] = key(
        ..., "material missing there, along the tooth normal, of any sign"
    )


class WaveTable(SchemaTable):
    """A wave along the profile: A cos(2 pi order sigma + phase), sigma from the pitch point in base pitches."""

    amplitude: Small = key(..., "amplitude A, along the tooth normal")
    order: Annotated[int, Field(ge=1, le=1000)] = key(1, "waves per base pitch")
    phase: Angle = key(0.0, "phase of the wave at the pitch point")


class FlankTable(SchemaTable):
    """Micro-geometry of the flanks of a gear; amounts are material missing along the tooth normal."""

    tip_relief: ReliefTable | None = key(None, "tip relief of the flanks; default none")
    root_relief: ReliefTable | None = key(None, "root relief, from the lowest point that the mate touches")
    end_relief: ReliefTable | None = key(None, "relief of both ends of the face")
    crown: Small | None = key(None, "lengthwise crowning: missing at both ends of the face, parabolic")
    slope: Annotated[float, Unit("length", likely=SMALL)] | None = key(
        None, "helix slope: missing at the right end less that at the left"
    )
    profile: ProfileTable | None = key(None, "measured profile deviation")
    wave: WaveTable | None = key(None, "wave along the profile")


class SideTable(SchemaTable):
    """Keys of a left or right side that differ from its member."""

    mass: Mass | None = key(None, "mass of this half")
    inertia: Inertia | None = key(None, "inertia of this half; in kg J/r^2 at the base radius")
    tilt_inertia: TiltInertia | None = key(None, "inertia about x and y of this half")
    support: SupportTable | None = key(None, "support of this half")
    bearing: SupportTable | None = key(None, "bearing of this half")
    face_width: Length | None = key(None, "face width of this helix")
    addendum: Coefficient | None = key(None, "addendum coefficient")
    dedendum: Coefficient | None = key(None, "dedendum coefficient")
    flank: FlankTable | None = key(None, "flank modification")


class GearKeys(SchemaTable):
    """What may be said of one gear, or of all gears of a stage."""

    module: Radius | None = key(None, "normal module; or transverse_module")
    transverse_module: Radius | None = key(None, "transverse module; or module")
    pressure_angle: PressureAngle | None = key(None, "normal pressure angle; default 20 deg")
    helix_angle: Slant | None = key(None, "helix angle at the reference circle, magnitude; default 0")
    herringbone: bool | None = key(None, "whether a gear carries two helices; default false")
    split: bool | None = key(None, "whether halves are bodies of their own, joined by a neck; default false")
    gap: Span | None = key(None, "axial gap between the two helices")
    stagger: Annotated[float, Unit("ratio")] | None = key(None, "turn of the right half of a gear, in tooth pitches")
    face_width: Length | None = key(None, "face width of one helix")
    addendum: Coefficient | None = key(None, "addendum coefficient; default 1")
    dedendum: Coefficient | None = key(None, "dedendum coefficient; default 1.25")
    tip_rounding: Annotated[float, Unit("ratio", low=0, high=1)] | None = key(
        None, "rounding of the tool's tip per module; default 0.38"
    )
    flank: FlankTable | None = key(None, "flank modification")
    material: MaterialTable | None = key(None, "material of the gear")


class MemberTable(GearKeys):
    """A gear or carrier of a stage. `kind` is always set, from the name where the file leaves it out."""

    kind: Kind = key(..., "what it is; by the names sun planet ring carrier wheel pinion")
    # teeth and geometry
    teeth: Annotated[int, Field(ge=3, le=5000)] | None = key(None, "number of teeth, positive also of a ring")
    profile_shift: Annotated[float, Unit("ratio", low=-5, high=5)] | None = key(
        None, "profile shift coefficient x, positive lengthens the addendum; default from the centre distance, else 0"
    )
    hand: Literal["left", "right"] | None = key(None, "hand of the helix; of a herringbone gear of its left helix")
    base_radius: Radius | None = key(None, "base radius; default from teeth")
    tip_diameter: Radius | None = key(None, "tip diameter; default from teeth")
    root_diameter: Radius | None = key(None, "root diameter; default from teeth")
    # mass
    mass: Mass | None = key(
        None, "mass; of a split member of one half; of a carrier without the planets; default of a gear from its solid"
    )
    inertia: Inertia | None = key(
        None,
        "inertia about z; in kg J/r^2 at the base radius (carrier: pin radius); default of a gear from its solid",
    )
    tilt_inertia: TiltInertia | None = key(None, "moment of inertia about x and y; default of a gear from its solid")
    bore: Span | None = key(None, "bore diameter of the solid the mass is taken from")
    rim: Length | None = key(None, "radial thickness of a ring outside its root circle")
    outer_diameter: Radius | None = key(None, "outer diameter of a ring")
    elastic: ElasticTable | None = key(None, "a ring that bends: true, or what is known of its section; default rigid")
    reduced: ReducedTable | None = key(None, "matrices of a finite-element program: a file, or a table; default rigid")
    # shafts, halves
    on: str | None = key(None, "member whose shaft it sits on")
    clocking: Annotated[PerPlanet | str, Unit("angle", many=True, words=("fit",))] | None = key(
        None, "turn against the member it sits on; default fit"
    )
    shaft: SolidTable | None = key(None, "shaft to the member it sits on; default rigid")
    shaft_sections: dict[str, SectionTable] = key({}, _SECTIONS)
    neck: SolidTable | None = key(None, "neck that joins the left and the right half")
    left: SideTable | None = key(None, "keys of the left side that differ")
    right: SideTable | None = key(None, "keys of the right side that differ")
    # place and links
    bearing: SupportTable | None = key(None, "of a planet: link to the carrier, or the housing where there is none")
    support: SupportTable | None = key(None, "of a central member: link to the housing or to `to`")
    pin_radius: Radius | None = key(None, "radius of the planet axes")
    ahead: bool | None = key(
        None, "of a planet that meets another planet: ahead of it in the positive sense; default true"
    )
    direction: Angle | None = key(None, "direction of its centre, seen from its first partner")
    station: Place | None = key(None, "axial place of its centre along z; default 0")


_NO_BACKLASH = "leave it out where the far flank never touches"
VARIATIONS = ("none", "contact-lines", "energy", "ishikawa")


class VariationTable(SchemaTable):
    """Mesh stiffness over one mesh cycle, relative to its mean: a word, a Fourier series or a table.

    In the file `"none"`, `"contact-lines"`, `"energy"`, `"ishikawa"`, `{cosine, sine}` or `{values}`; `form` names it.
    """

    form: Literal["none", "contact-lines", "energy", "ishikawa", "series", "values"] = key(..., "which of the six")
    cosine: Coefficients = key((), "cosine coefficients of orders 1, 2, ...")
    sine: Coefficients = key((), "sine coefficients of orders 1, 2, ...")
    values: Coefficients = key((), "relative stiffness at equal steps of sigma, from 0 to 1")

    @model_validator(mode="before")
    @classmethod
    def _form(cls, data: Any) -> Any:
        """Say which form it has."""
        if isinstance(data, dict):
            if "form" in data:
                return {**{k: v for k, v in data.items() if k != "form"}, "form ": data["form"]}
            return {**data, "form": "values" if "values" in data else "series"}
        if data in VARIATIONS:
            return {"form": data}
        raise ModelError(
            "not a variation", given=data, allowed=f"{', '.join(VARIATIONS)}, {{cosine, sine}} or {{values}}"
        )

    def model_post_init(self, context: Any) -> None:
        """Refuse a series without terms."""
        if self.form == "series" and not self.cosine + self.sine:
            raise ModelError("no coefficients", allowed=f"{', '.join(VARIATIONS)}, {{cosine, sine}} or {{values}}")


class MeshSideTable(SchemaTable):
    """Keys of a mesh, or of one side of it."""

    stiffness: (
        Annotated[
            Quantity | str | MeshForceTable,
            Unit(
                "stiffness stiffness_per_width",
                low=0,
                above=True,
                many=True,
                words=("iso6336", "energy", "ishikawa", "contact"),
                table=MeshForceTable,
                likely=MESH,
            ),
        ]
        | None
    ) = key(None, "mean stiffness of one helix, per planet; or force over deflection; default iso6336")
    direction: Literal["normal", "transverse"] | None = key(
        None, "in which direction the stiffness is given; default normal, along the tooth normal"
    )
    variation: VariationTable | None = key(
        None, "course of the stiffness over one mesh cycle; default that of the method, none for a number"
    )
    phase: Annotated[PerPlanet, Unit("cycles", many=True)] | None = key(
        None, "phase of a mesh: k_i(t) = k_1(t + phase T); default from the teeth"
    )
    pressure_angle: PressureAngle | None = key(
        None, "working transverse pressure angle; default from the centre distance"
    )
    damping: Annotated[float, Unit("damping", low=0)] | None = key(None, "damper along the tooth normal")
    backlash: Annotated[float, Unit("length", low=0, likely=SMALL, reason=_NO_BACKLASH)] | None = key(
        None, "backlash along the tooth normal; without it the far flank never touches"
    )


class MeshTable(MeshSideTable):
    """A mesh `A-B`."""

    centre_distance: Radius | None = key(None, "centre distance of this mesh")
    slices: Annotated[int, Field(ge=1, le=200)] | None = key(
        None, "equal pieces along the face, each a row; default 10 where the gears may tilt, else 1"
    )
    left: MeshSideTable | None = key(None, "keys of the left side that differ")
    right: MeshSideTable | None = key(None, "keys of the right side that differ")


class StageTable(GearKeys):
    """A stage: gears that mesh around one centre. `members` holds the tables that are no keys of the stage."""

    planets: Annotated[int, Field(ge=1, le=100)] | None = key(None, "number of equally spaced branches")
    planet_angles: Angles | None = key(None, "polar angle of each branch")
    centre_distance: Radius | None = key(
        None, "centre distance of the meshes with a central gear; default from shifts, else reference"
    )
    meshes: dict[str, MeshTable] = key({}, "meshes, by `A-B`")
    members: dict[str, MemberTable] = key({}, "gears and carrier, by name")

    @model_validator(mode="before")
    @classmethod
    def _collect(cls, data: Any) -> Any:
        """Collect the member tables and give those with a known name their kind."""
        if not isinstance(data, dict):
            return data
        named = {k: v for k, v in data.items() if k not in STAGE_KEYS and (isinstance(v, dict) or k in KIND_BY_NAME)}
        rest = {k: v for k, v in data.items() if k not in named}
        for name, table in named.items():
            if isinstance(table, dict) and name in KIND_BY_NAME:
                named[name] = {"kind": KIND_BY_NAME[name], **table}
        return {**rest, "members": named}

    @property
    def branches(self) -> int:
        """Number of branches (0 without planets)."""
        return len(self.planet_angles) if self.planet_angles is not None else self.planets or 0


STAGE_KEYS = frozenset(StageTable.model_fields) - {"members"}


class BodyTable(SchemaTable):
    """A body of its own: a sleeve, an output shaft."""

    mass: Mass | None = key(None, "mass; default 0")
    inertia: TiltInertia | None = key(None, "inertia about z; default 0")
    tilt_inertia: TiltInertia | None = key(None, "inertia about x and y; required where it tilts")
    support: SupportTable | None = key(None, "link to the housing")
    shaft_sections: dict[str, SectionTable] = key({}, _SECTIONS)
    frame: str | None = key(None, "stage in whose axes it moves, so that it couples laterally; default the housing")
    reduced: ReducedTable | None = key(None, "matrices of a finite-element program: a file, or a table; default rigid")
    station: Place | None = key(None, "axial place of its centre along z; default 0")


class OperationTable(SchemaTable):
    """What drives, holds and loads the train; keys are full member paths."""

    held: tuple[str, ...] = key((), "members that do not turn, by path", strict=False)
    open: tuple[str, ...] = key(
        (), "couplings that are open, by name: clutches that carry no torque about z", strict=False
    )
    speed: dict[str, Annotated[float, Unit("speed")]] = key(
        {}, "absolute speed by member [rpm, rad/s], positive about +z"
    )
    torque: dict[str, Annotated[float | str, Unit("torque", words=("balance",))]] = key(
        {}, "external torque by member [N m, kN m], or balance: what is left"
    )
    power: dict[str, Annotated[float, Unit("power")]] = key(
        {}, "external power by member [kW], positive into the train"
    )
    rated: dict[str, Annotated[float, Unit("torque", low=0, above=True)]] = key(
        {}, "rated torque by member [N m], its size: what `output` loads a shaft with"
    )
    ripple: dict[str, dict[str, RippleTable]] = key(
        {}, "ripple of torque or motion by member: components by number or name"
    )
    gravity: Annotated[tuple[float, float, float], Unit("acceleration", lists=True, count=3)] | None = key(
        None, "gravity in housing axes; true is 9.81 m/s^2 along -y; default none"
    )


class ForceTable(SchemaTable):
    """A force in x, y, z."""

    x: Force = key(0.0, "force along x")
    y: Force = key(0.0, "force along y")
    z: Force = key(0.0, "force along z")


class MomentTable(SchemaTable):
    """A moment about x, y, z."""

    x: Moment = key(0.0, "moment about x")
    y: Moment = key(0.0, "moment about y")
    z: Moment = key(0.0, "moment about z")


class LoadTable(SchemaTable):
    """An external force and moment on one member or body."""

    on: str = key(..., "member or body that is loaded, by path")
    force: ForceTable = Field(default_factory=ForceTable, description="external force in x, y, z")
    moment: MomentTable = Field(default_factory=MomentTable, description="external moment about x, y, z")
    frame: Literal["housing", "member"] = key("housing", "axes of the load: fixed in space, or turning with the member")
    at: Place = key(0.0, "axial place, from the centre of the member")


SENSOR_KEYS: Mapping[str, tuple[str, ...]] = {
    "strain": ("on", "angle", "radius"),
    "acceleration": ("on", "angle", "radius", "z", "direction"),
    "angle": ("on",),
    "torque": ("on", "link"),
    "force": ("link", "direction"),
}
"""Keys that a sensor of each kind may have."""


class SensorTable(SchemaTable):
    """A sensor: what it measures, on which member, body or link, and where on the material."""

    kind: Literal["strain", "acceleration", "angle", "torque", "force"] = key(
        ..., "hoop strain, absolute acceleration, rotation about z, torque about z, or force of bolts"
    )
    on: str | None = key(None, "member or body that it sits on, by path; of a member of several bodies one on each")
    link: str | None = key(
        None, "of a torque: coupling, shaft, neck, support or bearing that carries it, by its table; of a force: bolts"
    )
    angle: Angle = key(0.0, "polar angle from the x axis of the body, with whose material it turns; default 0")
    radius: Radius | None = key(
        None, "distance from the axis of the body; default the outer radius of a ring, else the reference radius"
    )
    z: Place | None = key(None, "of an acceleration: axial place, from the centre of the member; default 0")
    direction: Literal["radial", "tangential", "axial"] = key(
        "radial", "of an acceleration or force: direction; default radial"
    )

    def model_post_init(self, context: Any) -> None:
        """Refuse keys of another kind of sensor, and a sensor on nothing."""
        allowed = SENSOR_KEYS[self.kind]
        if others := sorted(self.model_fields_set - {"kind", *allowed}):
            raise ModelError(f"{others[0]} is no key of a sensor of {self.kind}", allowed=f"kind, {', '.join(allowed)}")
        if (self.on is None) == (self.link is None):
            places = ", or ".join(
                text for key, text in {"on": "a member or body (on)", "link": "a link (link)"}.items() if key in allowed
            )
            raise ModelError("sits on nothing" if self.on is None else "sits on two", allowed=f"{places}, one of them")


class CaseTable(OperationTable):
    """A load case: an operating point beside the nominal one; what it leaves out is that of `[operation]`."""

    loads: dict[str, LoadTable] = key({}, "external forces and moments by name, beside those of the file or in place")
    duration: Annotated[float, Unit("time")] | None = key(None, "time spent in this case [h]", ge=0)
    share: Annotated[float, Unit("ratio", low=0, high=1)] | None = key(None, "share of the time spent in this case [%]")


class StageLimitsTable(SchemaTable):
    """What numbers of a stage are held against."""

    k_gamma: Annotated[float | str, Unit("ratio", low=1, words=tuple(TABLES))] | None = key(
        None, f"largest load factor K_gamma, or a table of it by the number of planets; default {WIND}"
    )


class LimitsTable(StageLimitsTable):
    """What numbers are held against; those of a stage count before those of the file."""

    stages: dict[str, StageLimitsTable] = key({}, "limits of a stage, by its name")


class ModelFile(SchemaTable):
    """A whole model file. Members are named by full paths (`main.sun`, `main.sun.right`, `g1`)."""

    format: Literal[2] = key(..., "version of the format of the file")
    title: str = key(..., "title of the train, one line")
    doi: str = key("", "DOI of the source")
    notes: str = key("", "notes, free text")
    material: MaterialTable = Field(default_factory=MaterialTable, description="material of all gears")
    damping: DampingTable = Field(default_factory=DampingTable, description="damping of the whole train")
    assumed: dict[str, str] = key({}, "path = why this value, where the source is silent")
    limits: LimitsTable = Field(default_factory=LimitsTable, description="what numbers are held against")
    tolerance: dict[str, Any] = key({}, "path = distribution of the number or vector there")
    stages: dict[str, StageTable] = key({}, "stages by name")
    bodies: dict[str, BodyTable] = key({}, "bodies by name")
    couplings: dict[str, CouplingTable] = key({}, "couplings by name")
    operation: OperationTable = Field(
        default_factory=OperationTable, description="what drives, holds and loads the train"
    )
    loads: dict[str, LoadTable] = key({}, "external forces and moments by name")
    sensors: dict[str, SensorTable] = key({}, "sensors by name")
    case: str = key("", "case that is computed, by name; default the nominal operation")
    cases: dict[str, CaseTable] = key({}, "load cases by name")
    deviations: DeviationsTable = Field(default_factory=DeviationsTable, description="what differs from nominal")

    def operation_path(self, name: str) -> str:
        """Table that states a key of the operation: that of the case, else `operation`."""
        stated = self.cases[self.case].model_fields_set if self.case else set()
        return f"cases.{self.case}" if case_states(name, stated) else "operation"


def case_states(name: str, stated: Iterable[str]) -> bool:
    """Whether a case of these keys states a key of the operation; a torque or power stands in place of both."""
    return not {name, *(LOADING if name in LOADING else ())}.isdisjoint(stated)


# names ----------------------------------------------------------------------------------------------------------------

SIDES = ("left", "right")
LOADING = ("torque", "power")
"""Keys of an operation that load members: one member has one of them."""
BY_MEMBER = ("speed", *LOADING, "rated")
"""Keys of an operation whose tables have a value a member."""
_TAKEN = (*SIDES, "meshes", "members", "bearings")
_NAME = re.compile(r"[A-Za-z0-9_]{1,60}")
_LINK_NAME = re.compile(r"[A-Za-z0-9_-]{1,60}")
_KINDS = tuple(dict.fromkeys(KIND_BY_NAME.values()))
_RANK = {"sun": 0, "planet": 1, "ring": 2}  # order of the two names of a mesh, along the power path


@dataclass(frozen=True, slots=True, kw_only=True)
class Names:
    """The names of a file: kind of each member by stage and member name, and the bodies."""

    stages: Mapping[str, Mapping[str, str]]
    bodies: tuple[str, ...]

    @property
    def members(self) -> tuple[str, ...]:
        """All full member paths, and the bodies."""
        return (*(f"{s}.{m}" for s, members in self.stages.items() for m in members), *self.bodies)


def collect(*layers: Mapping[str, object]) -> Names:
    """Return the names in the layers of a file laid over each other; wrong forms are left to validation."""
    stages: dict[str, dict[str, str]] = {}
    bodies: dict[str, None] = {}
    for layer in layers:
        for stage, table in _tables(layer.get("stages")):
            members = stages.setdefault(stage, {})
            for name, member in _tables(table):
                if name not in STAGE_KEYS:
                    kind = member.get("kind") or members.get(name) or KIND_BY_NAME.get(name, "")
                    members[name] = kind if isinstance(kind, str) else "unknown"
        bodies.update((name, None) for name, _ in _tables(layer.get("bodies")))
    return Names(stages=stages, bodies=tuple(bodies))


def check_names(names: Names, *layers: Mapping[str, object]) -> None:
    """Raise ModelError for a name that is taken, used twice or no name, and for a member of no kind."""
    for stage, members in names.stages.items():
        _check_name(stage, f"stages.{stage}", _NAME, (*_TAKEN, *names.bodies))
        for member, kind in members.items():
            _check_name(member, f"stages.{stage}.{member}", _NAME, _TAKEN)
            if not kind:
                problem = f"no member of a known name, and without kind{nearest(member, (*KIND_BY_NAME, *STAGE_KEYS))}"
                raise ModelError(problem, path=f"stages.{stage}.{member}", allowed=f"kind = {', '.join(_KINDS)}")
    for body in names.bodies:
        _check_name(body, f"bodies.{body}", _NAME, _TAKEN)
    for table, layer in product(("couplings", "loads", "sensors", "cases"), layers):
        for name, _ in _tables(layer.get(table)):
            check_label(name, f"{table}.{name}")


def check_label(name: str, path: str) -> None:
    """Raise ModelError for a name, of the user's own, of a coupling, load or error that is none."""
    _check_name(name, path, _LINK_NAME, ())


def _check_name(name: str, path: str, form: re.Pattern[str], taken: tuple[str, ...]) -> None:
    """Raise ModelError for one bad name."""
    if name in taken:
        raise ModelError("this name is taken", path=path, given=name, allowed="another name")
    if not form.fullmatch(name):
        letters = "letters, digits, _ and -" if form is _LINK_NAME else "letters, digits and _"
        raise ModelError("not a name", path=path, given=name, allowed=f"{letters}, at most 60")


def full_path(segments: tuple[str, ...], names: Names) -> tuple[str, ...]:
    """Return the segments of a reference with the stage put in front where it was left out and there is only one."""
    if not segments or segments[0] in names.bodies or segments[0] in names.stages or len(names.stages) != 1:
        return segments
    return (next(iter(names.stages)), *segments)


def reference(text: object, names: Names, *, path: str, sides: bool = True) -> str:
    """Return the full path of a member (`main.sun`, with `sides` also `main.sun.right`) or body.

    Raises ModelError with the nearest known name.
    """
    allowed = "a member or body" + (", or a side of a member" if sides else "")
    if not isinstance(text, str):
        raise ModelError("not a name", path=path, given=text, allowed=allowed)
    segments = full_path(tuple(text.split(".")), names)
    member = ".".join(segments[:1] if segments[0] in names.bodies else segments[:2])
    rest = segments[len(member.split(".")) :]
    if member not in names.members:
        # as they may be written: without the stage where there is only one
        short = tuple(next(iter(names.stages.values()))) if len(names.stages) == 1 else ()
        near = nearest(text, (*short, *names.members))
        raise ModelError(f"no such member{near}", path=path, given=text, allowed=allowed)
    if rest and (not sides or len(rest) > 1 or rest[0] not in SIDES or member in names.bodies):
        raise ModelError("no such member or side", path=path, given=text, allowed=allowed)
    return ".".join(segments)


def mesh_name(name: str, stage: str, names: Names, *, path: str) -> str:
    """Return the name of a mesh with its gears in the order sun, planet, ring; as written where both are of one kind.

    Raises ModelError where it does not join two gears of the stage.
    """
    members = names.stages.get(stage, {})
    gears = tuple(m for m, kind in members.items() if kind != "carrier")
    parts = name.split("-")
    if len(parts) != 2 or parts[0] == parts[1]:
        allowed = "two gears of the stage joined by -; a key of a mesh stands in its table, meshes.A-B.KEY"
        raise ModelError("not a mesh", path=path, given=name, allowed=allowed)
    for part in parts:
        if part not in gears:
            word = nearest(part, gears)
            raise ModelError(
                f"no gear '{part}' in this stage{word}", path=path, given=name, allowed=f"two of {', '.join(gears)}"
            )
    a, b = parts
    return f"{b}-{a}" if _RANK.get(members[a], 0) > _RANK.get(members[b], 0) else name


def implied_pairs(kinds: Mapping[str, str]) -> list[tuple[str, str]]:
    """Pairs of gears that need no naming: the meshes of a single planet gear, and of two gears on fixed axes."""
    planets = [name for name, kind in kinds.items() if kind == "planet"]
    if len(planets) == 1:
        inner = [(name, planets[0]) for name, kind in kinds.items() if kind == "sun"]
        return inner + [(planets[0], name) for name, kind in kinds.items() if kind == "ring"]
    if planets or len(kinds) != 2 or not ("ring" in kinds.values() or set(kinds.values()) == {"gear"}):
        return []
    a, b = sorted(kinds, key=lambda name: kinds[name] == "ring")
    return [(a, b)]


def nearest(word: object, known: Iterable[str]) -> str:
    """Return `; did you mean 'teeth'?`, or nothing where no known word is near."""
    found = get_close_matches(str(word)[:80], list(known), n=1, cutoff=0.6)
    return f"; did you mean '{found[0]}'?" if found else ""


def _tables(value: object) -> list[tuple[str, Mapping[str, object]]]:
    """Return the sub-tables of a table, nothing where it is none."""
    return [(str(k), v) for k, v in value.items() if isinstance(v, Mapping)] if isinstance(value, Mapping) else []
