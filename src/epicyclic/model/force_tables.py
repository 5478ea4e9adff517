"""Force over deflection as a table: where a stiffness may stand, columns of a test rig or an FE run may stand.

    { deflection = "[0, 5, 10] um", force = "[0, 1.2, 3.4] kN" }    or    { file = "columns.csv" }

Of a mesh, either may be a list of lists, one for each of S phases sigma = 0, 1/S, ... of the mesh cycle.  A file is
read into these two keys, so that the document, and every result, holds the numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Self

from pydantic import GetJsonSchemaHandler, ValidationInfo, model_validator
from pydantic_core import CoreSchema

from ..errors import ModelError
from .bare_numbers import SMALL, BareNumber, Probe
from .schema_fields import SchemaTable, Unit, key
from .units import KINDS, Quantity

__all__ = [
    "Curves",
    "DisplacementForceTable",
    "ForceTableOf",
    "MeshForceTable",
    "TiltMomentTable",
    "TurnMomentTable",
    "curve_fault",
]

# Time and memory of every analysis grow with the points; a thousand are finer than any measurement.
_MAX_POINTS, _MAX_PHASES = 1000, 360


@dataclass(frozen=True, slots=True)
class Curves:
    """Lists of numbers, one for each phase, and the SI unit they have in common."""

    rows: tuple[tuple[float, ...], ...]
    unit: str


@dataclass(frozen=True, slots=True)
class CurveUnit(Unit):
    """Annotation of a list of numbers, or of a list of such lists."""

    def read(self, value: object, info: ValidationInfo[Any] | None = None) -> Curves:
        """Return the lists in SI."""
        several = isinstance(value, (list, tuple)) and bool(value) and all(_is_list(entry) for entry in value)
        found = [self._row(row, info) for row in (value if several else [value])]  # type: ignore[attr-defined]
        own = KINDS[self.kinds.split()[0]].unit
        pairs = [(row.value, row.unit) if isinstance(row, Quantity) else (row, own) for row in found]
        if len({unit for _, unit in pairs}) > 1:
            raise ModelError("mixes kinds of quantity", given=value, allowed=self.describe())
        return Curves(rows=tuple(tuple(row) for row, _ in pairs), unit=pairs[0][1])  # type: ignore[arg-type]

    def _row(self, row: object, info: ValidationInfo[Any] | None) -> object:
        """Return one list in SI."""
        try:
            return Unit.read(self, row, info)
        except (BareNumber, Probe):
            raise
        except ModelError as error:
            allowed = error.allowed.replace("; a list gives one value per planet", "")
            raise ModelError(error.problem, given=error.given, allowed=allowed) from None

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        lists = [form for kind in self.kinds.split() for form in self.forms(kind)]
        several = {"type": "array", "items": {"anyOf": lists}, "minItems": 1}
        return {"anyOf": [*lists, several], "x-quantity": self.describe()}


def _is_list(value: object) -> bool:
    return isinstance(value, (list, tuple)) or (isinstance(value, str) and value.lstrip().startswith("["))


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

    @model_validator(mode="after")
    def _complete(self) -> Self:
        """Refuse what is no table of force over deflection."""
        for name, value in (("deflection", self.deflection), ("force", self.force)):
            if value is None:
                raise ModelError(f"without {name}", allowed="deflection and force, or file")
        assert self.deflection is not None
        assert self.force is not None
        _check_lengths(self.deflection, self.force, several=self.several)
        for phase, (x, f) in enumerate(self.curves, start=1):
            where = f" of phase {phase}" if len(self.curves) > 1 else ""
            if (found := curve_fault(x, f)) is not None:
                name, point, problem, allowed = found
                row, unit = (x, self.deflection.unit) if name == "deflection" else (f, self.force.unit)
                given = f"{row[point]:g} {unit}"
                raise ModelError(f"point {point + 1}{where}: {problem}", path=name, given=given, allowed=allowed)
        return self


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
    for phase in range(phases):
        points, forces = len(x[phase if len(x) > 1 else 0]), len(f[phase if len(f) > 1 else 0])
        where = f" of phase {phase + 1}" if phases > 1 else ""
        if points != forces:
            allowed = f"{points}, one for each deflection"
            raise ModelError(
                f"another number of points{where}", path="force", given=f"{forces} forces", allowed=allowed
            )
        if points < 2:
            raise ModelError(f"too few points{where}", path="deflection", given=points, allowed="two or more")
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
    load: Annotated[float, Unit("force", low=0, above=True)] | None = key(
        None, "force at which linear analyses take the tangent; default the mean force of the operation"
    )
