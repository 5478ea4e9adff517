"""Force over deflection as a table: where a stiffness may stand, columns of a test rig or an FE run may stand.

    { deflection = "[0, 5, 10] um", force = "[0, 1.2, 3.4] kN" }    or    { file = "columns.csv" }

Of a mesh, either may be a list of lists, one for each of S phases sigma = 0, 1/S, ... of the mesh cycle.  A file is
read into these two keys, so that the document, and every result, holds the numbers.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema

from ..errors import ModelError
from .schema_fields import SchemaTable, Unit, key
from .tables import PlainTable
from .units import KINDS, Quantity

__all__ = [
    "Curves",
    "DisplacementForceTable",
    "ForceTableOf",
    "MeshForceTable",
    "TiltMomentTable",
    "TurnMomentTable",
    "with_files",
]

_MAX_BYTES = 4_000_000  # as of a model file
# Time and memory of every analysis grow with the points; a thousand are finer than any measurement.
_MAX_POINTS, _MAX_PHASES = 1000, 360
_COLUMNS = ("deflection", "force")
_HEADER = re.compile(r"\s*(?P<name>deflection|force)(?P<label>[^A-Za-z\[\]][^\[\]]*)?\[\s*(?P<unit>[^\[\]]+?)\s*\]\s*")
_HEADING = "deflection [um], force [kN]; of several phases one column each: deflection [um], force 1 [kN], ..."


@dataclass(frozen=True, slots=True)
class Curves:
    """Lists of numbers, one for each phase, and the SI unit they have in common."""

    rows: tuple[tuple[float, ...], ...]
    unit: str


@dataclass(frozen=True, slots=True)
class CurveUnit(Unit):
    """Annotation of a list of numbers, or of a list of such lists."""

    def read(self, value: object) -> Curves:
        """Return the lists in SI."""
        several = isinstance(value, (list, tuple)) and bool(value) and all(_is_list(entry) for entry in value)
        found = [self._row(row) for row in (value if several else [value])]  # type: ignore[attr-defined]
        own = KINDS[self.kinds.split()[0]].unit
        pairs = [(row.value, row.unit) if isinstance(row, Quantity) else (row, own) for row in found]
        if len({unit for _, unit in pairs}) > 1:
            raise ModelError("mixes kinds of quantity", given=value, allowed=self.describe())
        return Curves(rows=tuple(tuple(row) for row, _ in pairs), unit=pairs[0][1])  # type: ignore[arg-type]

    def _row(self, row: object) -> object:
        """Return one list in SI."""
        try:
            return Unit.read(self, row)
        except ModelError as error:
            allowed = error.allowed.replace("; a list gives one value per planet", "")
            raise ModelError(error.problem, given=error.given, allowed=allowed) from None

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        plain = {"type": ["number", "string", "array"]}
        forms = [{"type": "string"}, {"type": "array", "items": plain, "minItems": 1}]
        return {"anyOf": forms, "x-quantity": self.describe()}


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
        for name, value in zip(_COLUMNS, (self.deflection, self.force), strict=True):
            if value is None:
                raise ModelError(f"without {name}", allowed="deflection and force, or file")
        assert self.deflection is not None
        assert self.force is not None
        _check_lengths(self.deflection, self.force, several=self.several)
        for phase, (x, f) in enumerate(self.curves, start=1):
            where = f" of phase {phase}" if len(self.curves) > 1 else ""
            if (found := fault(x, f)) is not None:
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
            raise ModelError(f"another number of points{where}", path="force", given=f"{forces} forces", allowed=allowed)
        if points < 2:
            raise ModelError(f"too few points{where}", path="deflection", given=points, allowed="two or more")
    if (deflection.unit, force.unit) not in (("m", "N"), ("rad", "N m")):
        allowed = "deflections in m with forces in N, or in rad with moments in N m"
        raise ModelError("another kind of quantity than the deflections", path="force", given=force.unit, allowed=allowed)


def fault(deflection: Sequence[float], force: Sequence[float]) -> tuple[str, int, str, str] | None:
    """What is wrong with a curve: key, number of the point from 0, problem, what is allowed; None where it is right."""
    for i, (x, f) in enumerate(zip(deflection, force, strict=True)):
        before, last = (deflection[i - 1], force[i - 1]) if i else (-math.inf, 0.0)
        if x < 0:
            return "deflection", i, "is negative", "deflections from 0 up: their zero is the drawing without load"
        if x <= before:
            return "deflection", i, "does not rise", f"more than {before:g}, the point before"
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

    deflection: Annotated[Curves, CurveUnit("length", lists=True)] | None = key(None, "deflections, rising")
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
    deflection: Annotated[Curves, CurveUnit("length", lists=True)] | None = key(None, _TEXT)
    force: Annotated[Curves, CurveUnit("force", lists=True)] | None = key(None, _FORCE)
    load: Annotated[float, Unit("force", low=0, above=True)] | None = key(
        None, "force at which linear analyses take the tangent; default the mean force of the operation"
    )


# CSV files ------------------------------------------------------------------------------------------------------------


def with_files(data: PlainTable, folder: Path | None) -> PlainTable:
    """Return a document with the numbers of the CSV files that its tables of force name, in place of the names.

    folder : where the files are looked for.  Raises ModelError with path, file and line.
    """
    parts = ("stages", "bodies", "couplings")
    return {name: _embedded(value, name, folder) if name in parts else value for name, value in data.items()}


def _embedded(value: Any, path: str, folder: Path | None) -> Any:
    if not isinstance(value, dict):
        return value
    if isinstance(name := value.get("file"), str):
        if beside := [column for column in _COLUMNS if column in value]:
            raise ModelError(f"stands beside {beside[0]}", path=f"{path}.file", given=name, allowed="one of the two")
        rest = {other: entry for other, entry in value.items() if other != "file"}
        return {**_columns_of(name, f"{path}.file", folder), **rest}
    return {name: _embedded(entry, f"{path}.{name}", folder) for name, entry in value.items()}


def _columns_of(name: str, path: str, folder: Path | None) -> dict[str, object]:
    """Return deflections and forces of a CSV file as a model file states them. Raises ModelError."""
    lines = _lines(name, path, folder)
    number, heading = lines[0]
    separator = ";" if ";" in heading else ","
    columns = _heading(_cells(heading, separator), name, path, number)
    table = [_numbers(_cells(line, separator), len(columns), name, path, at) for at, line in lines[1:]]
    if len(table) < 2:
        raise ModelError(f"{name}: too few rows", path=path, given=len(table), allowed="two or more")
    values = list(zip(*table, strict=True))
    _check_columns(columns, values, [at for at, _ in lines[1:]], name, path)
    found: dict[str, object] = {}
    for key_ in _COLUMNS:
        lists = [f"[{', '.join(column)}] {unit}" for (own, unit), column in zip(columns, values, strict=True) if own == key_]
        found[key_] = lists if len(lists) > 1 else lists[0]
    return found


def _lines(name: str, path: str, folder: Path | None) -> list[tuple[int, str]]:
    """Return the lines of a file with their numbers, empty and # lines left out."""
    file = (folder or Path()) / name
    allowed = f"a CSV file beside the model file: {_HEADING}"
    try:
        if file.stat().st_size > _MAX_BYTES:
            raise ModelError("too large", path=path, given=name, allowed=f"{_MAX_BYTES} bytes")
        text = file.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise ModelError(f"cannot be read: {error.strerror or error}", path=path, given=name, allowed=allowed) from None
    except ValueError:
        raise ModelError("is not a text file (UTF-8)", path=path, given=name, allowed=allowed) from None
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1)]
    kept = [(number, line) for number, line in lines if line.strip() and not line.lstrip().startswith("#")]
    if not kept:
        raise ModelError("holds no line", path=path, given=name, allowed=allowed)
    return kept


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]


def _heading(cells: list[str], name: str, path: str, number: int) -> list[tuple[str, str]]:
    """Return key and unit of every column."""
    columns = []
    for cell in cells:
        match = _HEADER.fullmatch(cell)
        if match is None:
            raise ModelError(f"{name}, line {number}: no heading of a column", path=path, given=cell, allowed=_HEADING)
        columns.append((match["name"], match["unit"]))
    count = {key_: sum(own == key_ for own, _ in columns) for key_ in _COLUMNS}
    if not all(count.values()) or (min(count.values()) > 1 and len(set(count.values())) > 1):
        problem = f"{name}, line {number}: {count['deflection']} columns of deflections and {count['force']} of forces"
        raise ModelError(problem, path=path, given=", ".join(cells), allowed=_HEADING)
    return columns


def _numbers(cells: list[str], count: int, name: str, path: str, number: int) -> tuple[str, ...]:
    """Return the cells of one row, each a finite number."""
    where = f"{name}, line {number}"
    if len(cells) != count:
        raise ModelError(f"{where}: another number of columns than the heading", path=path, given=len(cells), allowed=str(count))
    for cell in cells:
        try:
            finite = math.isfinite(float(cell))
        except ValueError:
            finite = False
        if not finite or "_" in cell:
            raise ModelError(f"{where}: not a finite number", path=path, given=cell, allowed="a number in every column")
    return tuple(repr(float(cell)) for cell in cells)


def _check_columns(
    columns: Sequence[tuple[str, str]], values: Sequence[Sequence[str]], lines: Sequence[int], name: str, path: str
) -> None:
    """Raise ModelError with the line of a point that no curve may have."""
    rows: Mapping[str, list[list[float]]] = {
        key_: [[float(cell) for cell in column] for (own, _), column in zip(columns, values, strict=True) if own == key_]
        for key_ in _COLUMNS
    }
    x, f = rows["deflection"], rows["force"]
    for phase in range(max(len(x), len(f))):
        found = fault(x[phase if len(x) > 1 else 0], f[phase if len(f) > 1 else 0])
        if found is not None:
            key_, point, problem, allowed = found
            column = [i for i, (own, _) in enumerate(columns) if own == key_][phase if len(rows[key_]) > 1 else 0]
            where = f"{name}, line {lines[point]}, column {column + 1}: {key_} {problem}"
            raise ModelError(where, path=path, given=f"{values[column][point]} {columns[column][1]}", allowed=allowed)
