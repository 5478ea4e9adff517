"""Building blocks of the schema: tables, keys, and numbers with units, read into SI and described for JSON Schema.

Fields of links (supports, bearings, necks, shafts, couplings), bodies that bend, and ripple of torque or motion at a
shaft stand here too; SI, as read, and None where nothing is named.

Where a stiffness may stand, columns of force over deflection of a test rig or an FE run may stand.

    { deflection = "[0, 5, 10] um", force = "[0, 1.2, 3.4] kN" }    or    { file = "columns.csv" }

Of a mesh, either may be a list of lists, one for each of S phases sigma = 0, 1/S, ... of the mesh cycle.  A file is
read into these two keys, so that the document, and every result, holds the numbers.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any, ClassVar, Literal, get_args

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationInfo,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from ..errors import ModelError
from .units import ASKED, KINDS, SMALL, Bounds, Ladder, PerPlanet, Quantity, Reading, read_quantity


@dataclass(frozen=True, slots=True)
class Unit(Bounds):
    """Annotation of a field: which quantities may stand there, and their bounds.

    kinds : names in `units.KINDS`; of a bare number the first. With two kinds the value is a `Quantity`.
    many : a list, one value per planet, is allowed (a tuple then).  lists : only a list is allowed, of `count` entries.
    words : words allowed in place of a number, kept as they are.  table : the schema of a table allowed there.
    reason : why the bounds are as they are, for the error.
    likely : units that a bare number likely means, where they are others than of the kind (`units.LIKELY`).
    """

    kinds: str
    many: bool = False
    lists: bool = False
    count: int | None = None
    words: tuple[str, ...] = ()
    table: type[BaseModel] | None = None
    reason: str = ""
    likely: Ladder | None = None

    def read(self, value: object, info: ValidationInfo[Any] | None = None) -> object:
        """Return the SI value (float, tuple, Quantity, word or table) of what stands in the file.

        info : its context is a `Reading`, or nothing.  Raises ModelError; of these Probe where the place is asked for.
        """
        context: Reading | None = None if info is None else info.context
        if self.table is not None and isinstance(value, dict):
            return self.table.model_validate(value, context=context)
        kinds = tuple(self.kinds.split())
        if context is not None:
            if value is ASKED:
                raise Probe(self)
            context.look(value, kinds, self.likely)
        many, one = self.many or self.lists, not self.lists
        try:
            read = read_quantity(value, kinds, self, many=many, one=one, words=self.words, listed=True)
        except ModelError as error:
            if not self.reason:
                raise
            allowed = f"{error.allowed}; {self.reason}"
            raise ModelError(error.problem, given=error.given, allowed=allowed) from None
        if self.count is not None and isinstance(read, tuple) and len(read) != self.count:
            raise ModelError(f"a list of {len(read)}", given=value, allowed=f"a list of {self.count}")
        return read

    def describe(self) -> str:
        """Return the unit and kind of quantity in words, for the schema."""
        kinds = [KINDS[k] for k in self.kinds.split()]
        text = " or ".join(f"{k.name} [{k.unit}]" if k.unit else f"{k.name} [1]" for k in kinds)
        span = self._span()
        return text + (f", {span}" if span else "") + (", one value or one per planet" if self.many else "")

    def _span(self) -> str:
        """Return the bounds in words, those of angles in degrees; "" without."""
        degrees = self.kinds == "angle"
        low, high = (None if v is None else round(math.degrees(v), 6) if degrees else v for v in (self.low, self.high))
        unit = " deg" if degrees else ""
        if low is not None and high is not None and not (self.above or self.below):
            return f"{low:g} to {high:g}{unit}"
        first = "" if low is None else f"above {low:g}{unit}" if self.above else f"{low:g}{unit} or more"
        last = "" if high is None else f"below {high:g}{unit}" if self.below else f"up to {high:g}{unit}"
        return " and ".join(part for part in (first, last) if part)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        forms = [form for kind in self.kinds.split() for form in self.forms(kind)]
        if self.words:
            forms.append({"enum": list(self.words)})
        if self.table is not None:
            self.table.model_rebuild()
            forms.append(handler(self.table.__pydantic_core_schema__))
            # older versions of pydantic leave it out of a table that stands in one place alone
            handler.resolve_ref_schema(forms[-1]).setdefault("description", self.table.__doc__)
        return {"anyOf": forms, "x-quantity": self.describe(), **({"x-words": list(self.words)} if self.words else {})}

    def forms(self, kind: str) -> list[dict[str, Any]]:
        """Return the schemas of what may stand there as one kind of quantity; texts by reference, see `text_form`."""
        zero = self.low is None or self.low < 0 or (self.low == 0 and not self.above)
        one: list[dict[str, Any]] = [{"enum": [0]}] if zero else []
        if not KINDS[kind].unit:
            one = [{"type": "number"}]
        if self.inf:
            one.append({"type": "number", "minimum": _INFINITY})
        one.append(text_form(kind, inf=self.inf, many=False))
        if not (self.many or self.lists):
            return one
        entries: dict[str, Any] = {"type": "array", "items": {"anyOf": one}, "minItems": self.count or 1}
        if self.count is not None:
            entries["maxItems"] = self.count
        lists = [text_form(kind, inf=self.inf, many=True), entries]
        return lists if self.lists else one + lists


class Probe(ModelError):
    """Answer to the question which quantity stands at a place.

    unit : what may stand there; None of a count.
    """

    def __init__(self, unit: Unit | None) -> None:
        self.unit = unit
        super().__init__("asked for")

    @property
    def kinds(self) -> tuple[str, ...]:
        """Names in `units.KINDS`."""
        return ("ratio",) if self.unit is None else tuple(self.unit.kinds.split())


# what only infinity is not below: JSON itself has no word for it, TOML has
_INFINITY = 1.7976931348623157e308


def text_form(kind: str, *, inf: bool, many: bool) -> dict[str, Any]:
    """Return the reference to the schema of texts of a kind of quantity; `writer.json_schema` puts these beside it."""
    return {"x-texts": f"{kind}{'_or_inf' if inf else ''}{'_list' if many else ''}"}


Length = Annotated[float, Unit("length", low=0, above=True)]  # [m], above 0
Place = Annotated[float, Unit("length")]  # [m], of any sign

Foundation = Annotated[float, Unit("stiffness_per_width", low=0)]  # [N/m^2]
Span = Annotated[float, Unit("length", low=0)]  # [m], 0 or more
Small = Annotated[float, Unit("length", low=0, likely=SMALL)]  # [m], reliefs, plays, fits
Angle = Annotated[float, Unit("angle")]
Angles = Annotated[tuple[float, ...], Unit("angle", lists=True)]
Load = Annotated[float, Unit("force", low=0, above=True)]
Rigidity = Annotated[float, Unit("rigidity", low=0, above=True)]


def key(default: Any, text: str, **more: Any) -> Any:
    """Return a field with a default, ... of one that has to be there, and a description for the schema."""
    return Field(default, description=text, **more)


class SchemaTable(BaseModel):
    """A table of the file: frozen, unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, defer_build=True)


def metadata_of(field: FieldInfo) -> tuple[Any, ...]:
    """Annotations of a field, those of the members of a union among them."""
    return (*field.metadata, *_nested_metadata(field.annotation))


def _nested_metadata(annotation: Any) -> tuple[Any, ...]:
    own = getattr(annotation, "__metadata__", ())
    return (*own, *(entry for part in get_args(annotation) for entry in _nested_metadata(part)))


# force over deflection ------------------------------------------------------------------------------------------------

# Time and memory of every analysis grow with the points; a thousand are finer than any measurement.
_MAX_POINTS, _MAX_PHASES = 1000, 360


@dataclass(frozen=True, slots=True)
class Curves:
    """Lists of numbers, one for each phase, and the SI unit they have in common."""

    rows: tuple[tuple[float, ...], ...]
    unit: str


class ListsUnit(Unit):
    """Annotation of a list of numbers, or of a list of such lists."""

    def rows(self, value: object, info: ValidationInfo[Any] | None) -> list[Any]:
        """Return every list in SI, as of `Unit.read`."""
        several = isinstance(value, (list, tuple)) and bool(value) and all(map(_is_list, value))
        return [Unit.read(self, row, info) for row in (value if several else [value])]  # type: ignore[attr-defined]

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        lists = [form for kind in self.kinds.split() for form in self.forms(kind)]
        several = {"type": "array", "items": {"anyOf": lists}, "minItems": 1}
        return {"anyOf": [*lists, several], "x-quantity": self.describe()}


def _is_list(value: object) -> bool:
    return isinstance(value, (list, tuple)) or (isinstance(value, str) and value.lstrip().startswith("["))


class CurveUnit(ListsUnit):
    """Annotation of the deflections or forces of curves."""

    def read(self, value: object, info: ValidationInfo[Any] | None = None) -> Curves:
        """Return the lists in SI."""
        rows = self.rows(value, info)
        units = {getattr(row, "unit", KINDS[self.kinds.split()[0]].unit) for row in rows}
        if len(units) > 1:
            raise ModelError("mixes kinds of quantity", given=value, allowed=self.describe())
        return Curves(rows=tuple(tuple(getattr(row, "value", row)) for row in rows), unit=units.pop())


class ForceTableOf(SchemaTable):
    """Force over deflection.  Deflections rise; forces are 0 up to first touch and rise from there on."""

    several: ClassVar[bool] = False
    deflection: Curves | None = None
    force: Curves | None = None
    file: str | None = key(None, "CSV file beside the model file, in place of both")

    @property
    def curves(self) -> tuple[tuple[tuple[float, ...], tuple[float, ...]], ...]:
        """Deflections [m, rad] and forces [N, N m] of every phase."""
        assert self.deflection is not None
        assert self.force is not None
        x, f = self.deflection.rows, self.force.rows
        count = max(len(x), len(f))
        return tuple(zip(x * (count if len(x) == 1 else 1), f * (count if len(f) == 1 else 1), strict=True))

    def model_post_init(self, context: Any) -> None:
        """Refuse what is no table of force over deflection."""
        if self.deflection is None or self.force is None:
            missing = "deflection" if self.deflection is None else "force"
            raise ModelError(f"without {missing}", allowed="deflection and force, or file")
        _check_lengths(self.deflection, self.force, several=self.several)
        for phase, (x, f) in enumerate(self.curves, start=1):
            where = f" of phase {phase}" if len(self.curves) > 1 else ""
            if len(x) != len(f):
                given, allowed = f"{len(f)} forces", f"{len(x)}, one for each deflection"
                raise ModelError(f"another number of points{where}", path="force", given=given, allowed=allowed)
            if len(x) < 2:
                raise ModelError(f"too few points{where}", path="deflection", given=len(x), allowed="two or more")
            if (fault := curve_fault(x, f)) is not None:
                name, point, problem, allowed = fault
                row, unit = (x, self.deflection.unit) if name == "deflection" else (f, self.force.unit)
                given = f"{row[point]:g} {unit}"
                raise ModelError(f"point {point + 1}{where}: {problem}", path=name, given=given, allowed=allowed)


def _check_lengths(deflection: Curves, force: Curves, *, several: bool) -> None:
    """Raise ModelError where the two keys do not fit each other."""
    x, f = deflection.rows, force.rows
    phases = max(len(x), len(f))
    if phases > 1 and not several:
        name = "deflection" if len(x) > 1 else "force"
        raise ModelError("lists of several phases", path=name, given=f"{phases} lists", allowed="one list, of a link")
    if phases > _MAX_PHASES or max(map(len, (*x, *f))) > _MAX_POINTS:
        raise ModelError("too many points", path="force", allowed=f"{_MAX_POINTS} points and {_MAX_PHASES} phases")
    if min(len(x), len(f)) not in (1, phases):
        allowed = f"one list for all phases, or {len(x)}, one for each list of deflections"
        raise ModelError("lists of another number of phases", path="force", given=f"{len(f)} lists", allowed=allowed)
    if (deflection.unit, force.unit) not in (("m", "N"), ("rad", "N m")):
        allowed = "deflections in m with forces in N, or in rad with moments in N m"
        raise ModelError(
            "another kind of quantity than the deflections", path="force", given=force.unit, allowed=allowed
        )


# Least distance of two deflections, per the last one: slopes of more are no longer numbers.
_APART = 1e-9


def curve_fault(deflection: Sequence[float], force: Sequence[float]) -> tuple[str, int, str, str] | None:
    """What is wrong with a curve: key, number of the point from 0, problem, what is allowed; None where it is right."""
    for i, (x, f) in enumerate(zip(deflection, force, strict=True)):
        before, last = (deflection[i - 1], force[i - 1]) if i else (-math.inf, 0.0)
        if x < 0:
            return "deflection", i, "is negative", "deflections from 0 up: their zero is the drawing without load"
        if x <= before:
            return "deflection", i, "does not rise", f"more than {before:g}, the point before"
        if i and x - before < _APART * deflection[-1]:
            return "deflection", i, "hardly rises", f"a billionth of {deflection[-1]:g}, the last point, apart"
        if not i and f != 0:
            return "force", i, "is not 0", "a first point with force 0: state the deflection of first touch"
        if f < last:
            return "force", i, "falls", f"more than {last:g}, the point before"
        if f == last > 0:
            return "force", i, "does not rise", f"more than {last:g}, the point before"
    return None if force[-1] > 0 else ("force", len(force) - 1, "is 0 as all before it", "a force above 0")


_TEXT = "deflections, rising; a list, or of a mesh one list for each phase of the mesh cycle, equally spaced from 0"
_FORCE = "forces at them, 0 up to first touch and rising from there; a list, or of a mesh one for each phase"


class DisplacementForceTable(ForceTableOf):
    """Force over displacement of a link in x, y or z."""

    deflection: Annotated[Curves, CurveUnit("length", lists=True, likely=SMALL)] | None = key(
        None, "deflections, rising"
    )
    force: Annotated[Curves, CurveUnit("force", lists=True)] | None = key(None, "forces, 0 up to first touch")


class TiltMomentTable(ForceTableOf):
    """Moment over the angle of a link about x or y."""

    deflection: Annotated[Curves, CurveUnit("angle", lists=True)] | None = key(None, "angles, rising")
    force: Annotated[Curves, CurveUnit("torque", lists=True)] | None = key(None, "moments, 0 up to first touch")


class TurnMomentTable(ForceTableOf):
    """Moment over the angle of a link about z; deflections in m and forces in N act at the base radius."""

    deflection: Annotated[Curves, CurveUnit("angle length", lists=True)] | None = key(None, "angles, rising")
    force: Annotated[Curves, CurveUnit("torque force", lists=True)] | None = key(None, "moments, 0 up to first touch")

    @property
    def unit(self) -> str:
        """Unit of the stiffness, as of a `Quantity`."""
        return "N/m" if self.deflection is not None and self.deflection.unit == "m" else "N m/rad"

    @property
    def value(self) -> float:
        """No single number: nan."""
        return math.nan


class MeshForceTable(ForceTableOf):
    """Force over deflection of a mesh, along the tooth normal of one helix."""

    several: ClassVar[bool] = True
    deflection: Annotated[Curves, CurveUnit("length", lists=True, likely=SMALL)] | None = key(None, _TEXT)
    force: Annotated[Curves, CurveUnit("force", lists=True)] | None = key(None, _FORCE)
    load: Load | None = key(
        None, "force at which linear analyses take the tangent; default the mean force of the operation"
    )


# links ----------------------------------------------------------------------------------------------------------------

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
RollingType = Literal[
    "deep groove ball", "angular contact ball", "cylindrical roller", "tapered roller", "spherical roller"
]
# Keys of a rolling bearing that stand beside its type.
PARTS = (
    *("rows", "elements", "element_diameter", "element_length", "pitch_diameter", "contact_angle", "row_distance"),
    *("arrangement", "internal_clearance", "preload", "rating", "static_rating", "viscosity_ratio", "contamination"),
)
Clearance = Annotated[PerPlanet, Unit("length", low=0, many=True, likely=SMALL)]


class FrictionTable(SchemaTable):
    """Friction in a link: a force, or a coefficient at a radius."""

    force: Annotated[float, Unit("force", low=0)] | None = key(None, "friction force")
    coefficient: Annotated[float, Unit("ratio", low=0)] | None = key(None, "coefficient of friction")
    radius: Length | None = key(None, "radius the friction acts at")
    law: Literal["holonomic", "coulomb"] = key(
        "holonomic", "law of friction: holonomic (no memory) or coulomb (with history)"
    )

    def model_post_init(self, context: Any) -> None:
        """Refuse half a friction law."""
        if self.force is None and (self.coefficient is None or self.radius is None):
            raise ModelError("not a friction law", allowed="force, or coefficient and radius")


class LinkDampingTable(SchemaTable):
    """Dampers of a link; one value in place of the table is x, y and z."""

    x: Damper | None = key(None, "damper along x")
    y: Damper | None = key(None, "damper along y")
    z: Damper | None = key(None, "damper along z")
    rx: TurnDamper | None = key(None, "damper about x")
    ry: TurnDamper | None = key(None, "damper about y")
    rz: TurnDamper | None = key(None, "damper about z")


class BoltsTable(SchemaTable):
    """Bolts or pins on a pitch circle; stiffness of one. A direction that is not named is rigid; 0 floats."""

    count: Annotated[int, Field(ge=1, le=1000)] | None = key(None, "how many, evenly spaced, the first along x")
    angles: Angles | None = key(None, "polar angle of each")
    radius: Length = key(..., "radius of the pitch circle")
    radial: BoltStiffness | None = key(None, "stiffness of one bolt along the radius")
    tangential: BoltStiffness | None = key(None, "stiffness of one bolt along the circle")
    z: BoltStiffness | None = key(None, "axial stiffness of one bolt")

    def model_post_init(self, context: Any) -> None:
        """Refuse bolts of which nobody knows where they are."""
        if self.count is None and not self.angles:
            raise ModelError("no bolts", allowed="count, or angles")


class LinkTable(SchemaTable):
    """A link. A direction that is None is not named: rigid in a support or bearing; 0 floats, inf is rigid."""

    x: Stiffness | None = key(None, "stiffness along x (of a bearing: radial); 0 floats, inf is rigid")
    y: Stiffness | None = key(None, "stiffness along y (of a bearing: tangential); 0 floats, inf is rigid")
    z: Stiffness | None = key(None, "axial stiffness; 0 floats, inf is rigid")
    rx: TiltStiffness | None = key(None, "tilting stiffness about x; 0 is free, inf is rigid")
    ry: TiltStiffness | None = key(None, "tilting stiffness about y; 0 is free, inf is rigid")
    rz: TurnStiffness | None = key(None, "torsional stiffness; in N/m at the base radius (carrier: pin radius)")
    at: Place | None = key(None, "axial place, from the centre of the member; default 0")
    damping: LinkDampingTable | None = key(None, "dampers; one value [N s/m] is x, y and z")
    clearance: Clearance | None = key(None, "radial clearance of the bearing")
    exponent: Annotated[float, Unit("ratio", low=1, high=3)] | None = key(
        None, "exponent of the force over deflection; 10/9 of rolling elements; default 1"
    )
    load: Load | None = key(None, "load at which the stiffness holds, with an exponent other than 1")
    friction: FrictionTable | None = key(None, "friction in the link")
    bolts: BoltsTable | None = key(None, "bolts or pins on a pitch circle around the axis of the link")

    def model_post_init(self, context: Any) -> None:
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

    def directions(self) -> set[str]:
        """Return the directions that are named."""
        return {d for d in ("x", "y", "z", "rx", "ry", "rz") if getattr(self, d) is not None}


class ClearanceTable(SchemaTable):
    """Internal clearance of a new bearing, and what its fits and its temperature take of it."""

    group: Literal["C2", "CN", "C3", "C4"] | None = key(None, "group of ISO 5753-1 by the bore, the mean of its range")
    initial: Annotated[float, Unit("length", likely=SMALL)] | None = key(None, "of the new bearing, in place of group")
    bore: Length | None = key(None, "bore of the inner ring")
    outside_diameter: Length | None = key(None, "outside diameter of the outer ring")
    inner_fit: Small | None = key(None, "effective interference of inner ring and shaft; default 0")
    outer_fit: Small | None = key(None, "effective interference of outer ring and housing; default 0")
    temperature_difference: Annotated[float, Unit("temperature")] | None = key(
        None, "inner less outer ring, below 0 where the outer one is warmer; default 0"
    )


class BearingTable(LinkTable):
    """A support or a bearing: directions, or a rolling bearing by its parts, which make its radial force."""

    type: RollingType | None = key(None, "a rolling bearing, by its parts")
    rows: Annotated[int, Field(ge=1, le=8)] | None = key(None, "rows of elements; default 1")
    elements: Annotated[int, Field(ge=4, le=1000)] | None = key(None, "rolling elements of a row")
    element_diameter: Length | None = key(None, "diameter of an element, of a tapered roller at its middle")
    element_length: Length | None = key(None, "effective length of a roller, without its chamfers")
    pitch_diameter: Length | None = key(None, "diameter of the circle through the centres of the elements")
    contact_angle: Angle | None = key(
        None,
        "nominal contact angle, of one row above 0 where it carries an inner race that is pushed along z; default 0",
    )
    row_distance: Length | None = key(None, "between the centres of the rows; default as wide as their elements")
    arrangement: Literal["O", "X"] | None = key(None, "of two rows with a contact angle; default O")
    internal_clearance: (
        Annotated[PerPlanet | ClearanceTable, Unit("length", many=True, likely=SMALL, table=ClearanceTable)] | None
    ) = key(None, "radial internal clearance when running, the whole movement, below 0 of a preloaded one; default 0")
    preload: Small | None = key(None, "axial approach of the races when mounted; default 0")
    rating: Load | None = key(None, "dynamic rating C of the catalogue; default that of the parts")
    static_rating: Load | None = key(None, "static rating C_0 of the catalogue; default that of the parts")
    viscosity_ratio: Annotated[float, Unit("ratio", low=0.1, high=10)] | None = key(
        None, "viscosity ratio kappa of the oil, for the modified life"
    )
    contamination: Annotated[float, Unit("ratio", low=0, high=1, above=True)] | None = key(
        None, "contamination factor e_C, 1 of clean oil, for the modified life"
    )

    def held_by_parts(self) -> set[str]:
        """Return the directions that follow the law of the parts; none where x or y is stated, and none that is."""
        if self.type is None or self.x is not None or self.y is not None:
            return set()
        tilt = {"rx", "ry"} if self.contact_angle or (self.rows or 1) > 1 else set()
        return ({"x", "y"} | tilt | ({"z"} if self.contact_angle else set())) - super().directions()

    def directions(self) -> set[str]:
        """Return the directions that are named, or that the parts of a rolling bearing hold."""
        return super().directions() | self.held_by_parts()

    def model_post_init(self, context: Any) -> None:
        """Refuse half a rolling bearing, parts without a type, and a law by hand beside them."""
        super().model_post_init(context)
        stated = [name for name in PARTS if getattr(self, name) is not None]
        if self.type is None and stated:
            raise ModelError(f"{stated[0]} without type", allowed=f"type: one of {', '.join(get_args(RollingType))}")
        needed = ["elements", "element_diameter", "pitch_diameter"]
        needed += ["element_length"] if self.type is not None and self.type.endswith("roller") else []
        if self.type is not None and (missing := [name for name in needed if getattr(self, name) is None]):
            raise ModelError(f"a {self.type} bearing without {missing[0]}", allowed=f"all of {', '.join(needed)}")
        if (self.viscosity_ratio is None) is not (self.contamination is None):
            raise ModelError("half of the oil", allowed="viscosity_ratio and contamination together")
        if self.element_length is not None and (self.type or "").endswith("ball"):
            raise ModelError("of a ball", path="element_length", allowed="no such key, or a roller bearing")
        turned = self.rows == 2 and self.contact_angle and self.type != "spherical roller"
        if self.arrangement is not None and not turned:
            allowed = "no such key, or an angular contact or tapered bearing of two rows with a contact_angle"
            raise ModelError("no effect", path="arrangement", given=self.arrangement, allowed=allowed)
        if self.type is not None and (self.x is None) is not (self.y is None):
            problem = "only one of x and y beside a rolling bearing, whose parts are then for the life alone"
            raise ModelError(problem, allowed="radial, or both x and y")
        beside = [name for name in ("clearance", "exponent", "friction") if getattr(self, name) is not None]
        if beside and self.held_by_parts():
            allowed = "internal_clearance, twice the radial play; the force over deflection follows from the parts"
            raise ModelError(f"{beside[0]} beside a rolling bearing", allowed=allowed)
        if self.type is not None and self.bolts is not None:  # rigid beside it, they would take its force
            raise ModelError("bolts beside a rolling bearing", path="bolts", allowed="one of them")


class SupportTable(BearingTable):
    """A support or a planet bearing: a link, or several named ones."""

    to: str | None = key(None, "who carries it (a member or body); default the housing, of a planet its carrier")
    bearings: dict[str, BearingTable] = key({}, "several bearings, by name")

    @model_validator(mode="before")
    @classmethod
    def _collect(cls, data: Any) -> Any:
        """Collect the named sub-tables."""
        if not isinstance(data, dict):
            return data
        named = {k: v for k, v in data.items() if k not in LINK_KEYS and isinstance(v, dict)}
        rest = {k: v for k, v in data.items() if k not in named}
        return {**rest, "bearings": named} if named else rest

    def model_post_init(self, context: Any) -> None:
        """Refuse keys of one link beside several named ones."""
        super().model_post_init(context)
        own = self.model_fields_set - {"to", "bearings"}
        if self.bearings and own:
            raise ModelError(f"{', '.join(sorted(own))} beside named bearings", allowed="each key in a named bearing")
        taken: dict[float, str] = {}
        for name, table in self.bearings.items():
            if table.type is not None and (first := taken.setdefault(table.at or 0.0, name)) != name:
                problem = f"two rolling bearings at one place, {first} and {name}"
                raise ModelError(problem, path=f"{name}.at", allowed="another place than the other bearings")


class SolidTable(LinkTable):
    """A neck or shaft: stiffness from its shape, each direction settable."""

    diameter: Length | None = key(None, "outer diameter of the shaft")
    bore: Span | None = key(None, "inner diameter of the shaft")
    length: Length | None = key(None, "length of the shaft; of a neck default face_width + gap")
    torsional_rigidity: Rigidity | None = key(None, "torsional rigidity G J_p, in place of the diameters")

    def model_post_init(self, context: Any) -> None:
        """Refuse a bore without or above its diameter."""
        super().model_post_init(context)
        if self.bore is not None and self.bore >= (self.diameter or 0.0):
            raise ModelError("bore not below diameter", allowed="bore < diameter")


class SectionTable(SchemaTable):
    """A cylindrical section of a shaft that bends; places along the axis from the centre of the member."""

    from_: Place | None = key(None, "where it begins; default where the one before it ends", alias="from")
    to: Place = key(..., "where it ends")
    diameter: Length = key(..., "outer diameter")
    bore: Span | None = key(None, "inner diameter; default 0")

    def model_post_init(self, context: Any) -> None:
        """Refuse a bore above its diameter."""
        if self.bore is not None and self.bore >= self.diameter:
            raise ModelError("bore not below diameter", path="bore", given=self.bore, allowed="bore < diameter")


# bodies that bend -----------------------------------------------------------------------------------------------------


class FoundationTable(SchemaTable):
    """A uniform foundation in the housing all round a ring, per length of its centre line."""

    radial: Foundation | None = key(None, "radial stiffness per length; default 0")
    tangential: Foundation | None = key(None, "tangential stiffness per length; default 0")


class ElasticTable(SchemaTable):
    """A thin ring that bends in its plane: `true`, from its rim, or what is known of its section."""

    radius: Length | None = key(None, "radius of the centre line; default the middle of the rim")
    area: Annotated[float, Unit("area", low=0, above=True)] | None = key(
        None, "area of the section, for shear and stretch; default rim times width"
    )
    bending: Rigidity | None = key(None, "bending stiffness E I in the plane of the ring; default of the rim")
    axial: Annotated[float | str, Unit("force", low=0, above=True, words=("area",))] | None = key(
        None, "stiffness E A against stretch, or true, of the area; without it the ring is inextensible"
    )
    modes: Annotated[int, Field(ge=2, le=60)] | None = key(
        None, "highest order n of cos and sin n psi; default as many as it takes, at most 12"
    )
    foundation: FoundationTable | None = key(None, "uniform foundation in the housing")

    @model_validator(mode="before")
    @classmethod
    def _whole(cls, data: Any) -> Any:
        """Read `true` as all that the rim gives, stretch too."""
        if data is True:
            return {"axial": "area"}
        if isinstance(data, dict):
            return {**data, "axial": "area"} if data.get("axial") is True else data
        raise ModelError("no elastic ring", given=data, allowed="true, or a table; a ring without the key is rigid")


MATRIX_FILES = ("file", "stiffness", "mass", "damping", "nodes")
"""Keys of a reduced body that name a file."""


class InterfaceTable(SchemaTable):
    """Nodes of a reduced body that share the force of what joins it there."""

    nodes: tuple[Annotated[int, Field(ge=1)], ...] = key(..., "numbers of the nodes", strict=False)
    spider: Literal["average", "rigid", "nodes"] = key(
        "average", "mean motion of the nodes; nodes stiff against each other; or nodes as they are, linear between them"
    )


class ReducedTable(SchemaTable):
    """A body by the matrices of a finite-element program: the name of one file, or a table."""

    file: str | None = key(None, "file that holds all: .npz, .mat, a NASTRAN punch with GRID cards, a .sti of CalculiX")
    stiffness: str | None = key(None, "file of the stiffness: .mtx or DMIG; beside mass and nodes")
    mass: str | None = key(None, "file of the mass")
    damping: str | None = key(None, "file of the damping")
    nodes: str | None = key(None, "file of the places of the nodes: .inp, GRID cards, or lines of number, x, y, z")
    units: Literal["kg m s", "t mm s"] | None = key(None, "units of text files; native files state their own")
    modes: Annotated[int, Field(ge=0, le=500)] | None = key(
        None, "reduce to the interfaces and so many modes with these held; of an axisymmetric body its free modes"
    )
    sectors: Annotated[int, Field(ge=3, le=10000)] | None = key(
        None, "equal sectors of the mesh of an axisymmetric body, which may turn against its frame"
    )
    interfaces: dict[str, InterfaceTable] = key({}, "where other parts join it; default every node with coordinates")

    @model_validator(mode="before")
    @classmethod
    def _whole(cls, data: Any) -> Any:
        """Read a name as a table of that file."""
        return {"file": data} if isinstance(data, str) else data

    def model_post_init(self, context: Any) -> None:
        """Refuse no file, or files of two kinds."""
        texts = [name for name in MATRIX_FILES[1:] if getattr(self, name) is not None]
        if (self.file is None) == (not texts):
            raise ModelError("one way to name the files", allowed="file; or stiffness, mass and nodes")


class CouplingTable(SolidTable):
    """A coupling or shaft between two members or bodies; rz rigid, the rest 0, unless named."""

    between: tuple[str, str] = key(..., "the two members or bodies it joins", strict=False)
    radius: Length | None = key(None, "radius at which an rz in N/m acts")
    ends: Literal["splined", "fixed"] = key(
        "splined", "ends of a shaft: splined passes torque alone; fixed also forces and bending"
    )


LINK_KEYS = frozenset({**CouplingTable.model_fields, **SupportTable.model_fields}) | {"radial", "tilt"}


# ripple ---------------------------------------------------------------------------------------------------------------

_MOST_ORDER, _MOST_DENOMINATOR, MOST_POINTS, _LONGEST = 1000, 1000, 1000, 40
_PATTERN = r"^\s*[0-9.]+(\s*/\s*[0-9]+)?\s*$"
_ORDER = f'above 0 up to {_MOST_ORDER}, exact with a denominator up to {_MOST_DENOMINATOR}: 2, 0.5, "1/3"'


class OrderUnit(Unit):
    """Annotation of an order: cycles in one turn of a shaft, an exact fraction."""

    def read(self, value: object, info: ValidationInfo[Any] | None = None) -> Fraction:
        """Return the order as it is written."""
        try:
            if isinstance(value, bool) or not isinstance(value, int | float | str):
                raise ValueError
            if isinstance(value, str) and (len(value) > _LONGEST or re.match(_PATTERN, value) is None):
                raise ValueError
            order = Fraction("".join(str(value).split()))
        except (ValueError, ZeroDivisionError):
            raise ModelError("not an order", given=value, allowed=_ORDER) from None
        if not 0 < order <= _MOST_ORDER or order.denominator > _MOST_DENOMINATOR:
            raise ModelError("out of range", given=value, allowed=_ORDER)
        return order

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        text = {"type": "string", "pattern": _PATTERN}
        return {"anyOf": [{"type": "number", "minimum": 1 / _MOST_DENOMINATOR, "maximum": _MOST_ORDER}, text]}


class RippleTable(SchemaTable):
    """A component of a ripple, A cos(order theta + phase) with the angle theta of a shaft, or a table."""

    order: Annotated[Fraction, OrderUnit("ratio")] | None = key(None, 'cycles in one turn, 2 or "1/2"')
    of: str | None = key(None, "member whose turn counts; default the shaft itself")
    frequency: Annotated[float, Unit("frequency", low=1e-3)] | None = key(
        None, "frequency that does not follow the speed, in place of an order"
    )
    torque: Annotated[float, Unit("torque", low=0)] | None = key(None, "amplitude of an external torque")
    angle: Annotated[float, Unit("angle", low=0)] | None = key(None, "amplitude of an imposed angle")
    speed: Annotated[float, Unit("speed", low=0)] | None = key(
        None, "amplitude of an imposed speed, at the operating speed; it follows the speed"
    )
    phase: Angle | None = key(None, "phase of the cosine; default 0")
    angles: Angles | None = key(None, "equally spaced angles of whole turns of the shaft, from 0")
    torques: Annotated[tuple[float, ...], Unit("torque", lists=True)] | None = key(
        None, "torques at the angles; their mean is that of the operation"
    )
    file: str | None = key(None, "CSV file beside the model file, in place of angles and torques")

    def model_post_init(self, context: Any) -> None:
        """Refuse what is not one wave or one table."""
        amplitudes, waves = ("torque", "angle", "speed", "torques"), ("order", "frequency", "angles")
        for names, what in ((amplitudes, "an amplitude"), (waves, "an order")):
            given = [name for name in names if getattr(self, name) is not None]
            if len(given) != 1:
                problem = f"{' and '.join(given)} together" if given else f"without {what}"
                raise ModelError(problem, allowed=f"one of {', '.join(names)}")
        if (self.angles is None) != (self.torques is None):
            raise ModelError("half a table", allowed="angles and torques, or an order and an amplitude")
        if self.frequency is not None and self.of is not None:
            raise ModelError("of a shaft, beside frequency", path="of", given=self.of, allowed="order")
        if self.angles is not None:
            self._check_table(self.angles, self.torques or ())

    def _check_table(self, angles: tuple[float, ...], torques: tuple[float, ...]) -> None:
        if self.phase is not None:
            raise ModelError("beside a table", path="phase", given=self.phase, allowed="angles that count from 0")
        if len(angles) != len(torques):
            raise ModelError(f"{len(torques)} torques", path="torques", allowed=f"{len(angles)}, one for each angle")
        if not 3 <= len(angles) <= MOST_POINTS:
            raise ModelError(f"{len(angles)} points", path="angles", allowed=f"3 to {MOST_POINTS}")
