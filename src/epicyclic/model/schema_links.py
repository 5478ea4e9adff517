"""The tables of links: supports, bearings, necks, shafts, couplings. SI, as read; what is not named is None."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from ..errors import ModelError
from .bare_numbers import SMALL
from .force_tables import DisplacementForceTable, ForceTableOf, TiltMomentTable, TurnMomentTable
from .schema_fields import Length, PerPlanet, Place, SchemaTable, Unit, key
from .units import Quantity

__all__ = [
    "LINK_KEYS",
    "BoltsTable",
    "CouplingTable",
    "FrictionTable",
    "LinkDampingTable",
    "LinkTable",
    "SolidTable",
    "SupportTable",
]

Stiffness = Annotated[
    PerPlanet | DisplacementForceTable,
    Unit("stiffness", low=0, inf=True, many=True, table=DisplacementForceTable),
]
TiltStiffness = Annotated[
    PerPlanet | TiltMomentTable, Unit("torsional_stiffness", low=0, inf=True, many=True, table=TiltMomentTable)
]
TurnStiffness = Annotated[
    Quantity | TurnMomentTable,
    Unit("torsional_stiffness stiffness", low=0, inf=True, many=True, table=TurnMomentTable),
]
BoltStiffness = Annotated[
    float | DisplacementForceTable, Unit("stiffness", low=0, inf=True, table=DisplacementForceTable)
]
Damper = Annotated[float, Unit("damping", low=0)]
TurnDamper = Annotated[float, Unit("torsional_damping", low=0)]
Clearance = Annotated[PerPlanet, Unit("length", low=0, many=True, likely=SMALL)]


class FrictionTable(SchemaTable):
    """Friction in a link: a force, or a coefficient at a radius."""

    force: Annotated[float, Unit("force", low=0)] | None = key(None, "friction force")
    coefficient: Annotated[float, Unit("ratio", low=0)] | None = key(None, "coefficient of friction")
    radius: Length | None = key(None, "radius the friction acts at")
    law: Literal["holonomic", "coulomb"] = key(
        "holonomic", "law of friction: holonomic (no memory) or coulomb (with history)"
    )

    @model_validator(mode="after")
    def _complete(self) -> Self:
        """Refuse half a friction law."""
        if self.force is None and (self.coefficient is None or self.radius is None):
            raise ModelError("not a friction law", allowed="force, or coefficient and radius")
        return self


class LinkDampingTable(SchemaTable):
    """Dampers of a link; a bare number in the file is x, y and z."""

    x: Damper | None = key(None, "damper along x")
    y: Damper | None = key(None, "damper along y")
    z: Damper | None = key(None, "damper along z")
    rx: TurnDamper | None = key(None, "damper about x")
    ry: TurnDamper | None = key(None, "damper about y")
    rz: TurnDamper | None = key(None, "damper about z")


class BoltsTable(SchemaTable):
    """Bolts or pins on a pitch circle; stiffness of one. A direction that is not named is rigid; 0 floats."""

    count: Annotated[int, Field(ge=1, le=1000)] | None = key(None, "how many, evenly spaced, the first along x")
    angles: Annotated[tuple[float, ...], Unit("angle", lists=True)] | None = key(None, "polar angle of each")
    radius: Length = Field(description="radius of the pitch circle")
    radial: BoltStiffness | None = key(None, "stiffness of one bolt along the radius")
    tangential: BoltStiffness | None = key(None, "stiffness of one bolt along the circle")
    z: BoltStiffness | None = key(None, "axial stiffness of one bolt")

    @model_validator(mode="after")
    def _some(self) -> Self:
        """Refuse bolts of which nobody knows where they are."""
        if self.count is None and not self.angles:
            raise ModelError("no bolts", allowed="count, or angles")
        return self


class LinkTable(SchemaTable):
    """One bearing. A direction that is None is not named: rigid in a support or bearing; 0 floats, inf is rigid."""

    x: Stiffness | None = key(None, "stiffness along x (of a bearing: radial); 0 floats, inf is rigid")
    y: Stiffness | None = key(None, "stiffness along y (of a bearing: tangential); 0 floats, inf is rigid")
    z: Stiffness | None = key(None, "axial stiffness; 0 floats, inf is rigid")
    rx: TiltStiffness | None = key(None, "tilting stiffness about x; 0 is free, inf is rigid")
    ry: TiltStiffness | None = key(None, "tilting stiffness about y; 0 is free, inf is rigid")
    rz: TurnStiffness | None = key(None, "torsional stiffness; in N/m at the base radius (carrier: pin radius)")
    at: Place | None = key(None, "axial place, from the centre of the member; default 0")
    damping: LinkDampingTable | None = key(None, "dampers; a bare number [N s/m] is x, y and z")
    clearance: Clearance | None = key(None, "radial clearance of the bearing")
    exponent: Annotated[float, Unit("ratio", low=1, high=3)] | None = key(
        None, "exponent of the force over deflection; 10/9 of rolling elements; default 1"
    )
    load: Annotated[float, Unit("force", low=0, above=True)] | None = key(
        None, "load at which the stiffness holds, with an exponent other than 1"
    )
    friction: FrictionTable | None = key(None, "friction in the link")
    bolts: BoltsTable | None = key(None, "bolts or pins on a pitch circle around the axis of the link")

    @model_validator(mode="after")
    def _law(self) -> Self:
        """Refuse an exponent without the load its stiffness holds at, a load without exponent, friction with one."""
        if self.exponent is None and self.load is not None:
            raise ModelError("load without exponent", allowed="exponent, e.g. 10/9 = 1.1111")
        if self.exponent not in (None, 1.0) and self.load is None:
            raise ModelError("exponent without load", allowed="load: the force at which the stiffness holds")
        if self.exponent not in (None, 1.0) and self.friction is not None:
            raise ModelError("friction with an exponent", allowed="one of the two")
        tables = [d for d in ("x", "y", "z") if isinstance(getattr(self, d), ForceTableOf)]
        beside = [k for k in ("clearance", "exponent", "friction") if getattr(self, k) is not None]
        if tables and beside:
            problem = f"{beside[0]} beside a table of force in {tables[0]}"
            raise ModelError(problem, allowed="one of the two: play is a table that begins with forces of 0")
        return self

    def directions(self) -> dict[str, PerPlanet | Quantity | ForceTableOf]:
        """Return the stiffnesses that are named, by direction."""
        pairs = {d: getattr(self, d) for d in ("x", "y", "z", "rx", "ry", "rz")}
        return {d: v for d, v in pairs.items() if v is not None}


class SupportTable(LinkTable):
    """A support or a planet bearing: a link, or several named ones."""

    to: str | None = key(None, "who carries it (a member or body); default the housing, of a planet its carrier")
    bearings: dict[str, LinkTable] = Field(default_factory=dict, description="several bearings, by name")

    @model_validator(mode="before")
    @classmethod
    def _collect(cls, data: Any) -> Any:
        """Collect the named sub-tables."""
        if not isinstance(data, dict):
            return data
        named = {k: v for k, v in data.items() if k not in LINK_KEYS and isinstance(v, dict)}
        rest = {k: v for k, v in data.items() if k not in named}
        return {**rest, "bearings": named} if named else rest

    @model_validator(mode="after")
    def _either(self) -> Self:
        """Refuse keys of one link beside several named ones."""
        own = self.model_fields_set - {"to", "bearings"}
        if self.bearings and own:
            raise ModelError(f"{', '.join(sorted(own))} beside named bearings", allowed="each key in a named bearing")
        return self


class SolidTable(LinkTable):
    """A neck or shaft: stiffness from its shape, each direction settable."""

    diameter: Length | None = key(None, "outer diameter of the shaft")
    bore: Annotated[float, Unit("length", low=0)] | None = key(None, "inner diameter of the shaft")
    length: Length | None = key(None, "length of the shaft; of a neck default face_width + gap")
    torsional_rigidity: Annotated[float, Unit("rigidity", low=0, above=True)] | None = key(
        None, "torsional rigidity G J_p, in place of the diameters"
    )

    @model_validator(mode="after")
    def _hollow(self) -> Self:
        """Refuse a bore without or above its diameter."""
        if self.bore is not None and self.bore >= (self.diameter or 0.0):
            raise ModelError("bore not below diameter", allowed="bore < diameter")
        return self


class CouplingTable(SolidTable):
    """A coupling or shaft between two members or bodies; rz rigid, the rest 0, unless named."""

    between: tuple[str, str] = Field(description="the two members or bodies it joins")
    radius: Length | None = key(None, "radius at which an rz in N/m acts")
    ends: Literal["splined", "fixed"] = key(
        "splined", "ends of a shaft: splined passes torque alone; fixed also forces and bending"
    )


LINK_KEYS = frozenset(CouplingTable.model_fields) | {"to", "bearings", "radial", "tilt"}
