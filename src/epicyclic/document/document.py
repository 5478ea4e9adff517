"""Model file -> validated, normalised document in SI, with overrides laid over it; and the ready drives.

Paths of `[assumed]` must exist.  What a person wrote without a unit is refused by its path.

CSV files of the user are all of one form, those that a document names and histories of torques: one heading line with
the unit of a column in brackets, then rows of as many cells; commas between, or semicolons where the heading has one;
decimal points.  Empty lines and those that begin with # are passed over.

Nothing here imports NumPy: `epicyclic systems` lists titles and texts of the ready drives at once.
"""

from __future__ import annotations

import csv
import math
import os
import re
import tomllib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from importlib import resources
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

from ..errors import ModelError
from ..rexs.file import is_rexs_name
from ..user_input import read_bytes, read_text
from ..warning_codes import CodedText, coded
from .cases import of_case
from .overrides import check_alternatives, follow_teeth, layer_of, replace_alternatives, settings_of, stepwise
from .schema import FORMAT, ModelFile, Names, check_names, collect, nearest
from .schema_fields import MATRIX_FILES, Unit, curve_fault
from .tables import PlainTable, as_written, clean, dotted_line, expand, expand_path, leaves, merge, value_at
from .tolerances import check_tolerance, still_toleranced
from .units import KINDS, BareNumber, finite_float, to_si
from .validation import bare_numbers, validate

_NAME_AND_UNIT = re.compile(r"([^\[\]]*)(?:\[([^\[\]]*)\])?")
MAX_BYTES = 4_000_000  # of a model file, and of each file that one names


@dataclass(frozen=True, slots=True, kw_only=True)
class CsvTable:
    """Cells of a CSV file.

    name : of the file.  path : of the key that names it, for errors; "" of a file that no key names.
    heading : cells of the first line.  rows : cells of the others, each of as many.
    lines : numbers of the lines in the file, that of the heading first.
    """

    name: str
    path: str
    heading: Sequence[str]
    rows: Sequence[Sequence[str]]
    lines: Sequence[int]

    @property
    def columns(self) -> list[tuple[str, str]]:
        """Name and unit of every column, "" where the heading states none."""
        matches = [_NAME_AND_UNIT.fullmatch(cell) for cell in self.heading]
        return [(match[1].strip(), (match[2] or "").strip()) if match else ("", "") for match in matches]

    def numbers(self, column: int) -> list[float]:
        """Return the numbers of a column. Raises ModelError for a cell that is no finite number."""
        name = self.columns[column][0] or f"column {column + 1}"
        values = []
        for line, row in zip(self.lines[1:], self.rows, strict=True):
            cell = row[column]
            if not cell:
                raise self.error(line, f"no value of {name}", given="(nothing)", allowed="a number in every column")
            try:
                value = float(cell)
            except ValueError:
                value = math.nan
            if not math.isfinite(value) or "_" in cell:
                allowed = "a number with a decimal point"
                raise self.error(line, f"{name} is not a finite number", given=cell, allowed=allowed)
            values.append(value)
        return values

    def scale(self, column: int, kind: str, *, allowed: str) -> float:
        """Return the factor to SI of a column of a kind of quantity. Raises ModelError for no name, no such unit."""
        name, unit = self.columns[column]
        given, target = self.heading[column], KINDS[kind].unit
        if not name or not unit:
            raise self.error(self.lines[0], "a column needs a name and a unit", given=given, allowed=allowed)
        if (scale := to_si(unit, target)) is None:
            raise self.error(self.lines[0], f"not a unit of {kind}", given=given, allowed=KINDS[kind].spellings)
        return scale

    def quantities(self, column: int, kind: str, *, allowed: str) -> list[float]:
        """Return a column of a kind of quantity in SI. Raises ModelError with the line, beyond its limit too."""
        scale, limit = self.scale(column, kind, allowed=allowed), KINDS[kind]
        values = [number * scale for number in self.numbers(column)]
        if max(map(abs, values), default=0.0) > limit.limit:
            at = next(at for at, value in enumerate(values) if abs(value) > limit.limit)
            problem, most = f"{self.columns[column][0]} is out of range", f"<= {limit.limit:g} {limit.unit}"
            raise self.error(self.lines[at + 1], problem, given=self.rows[at][column], allowed=most)
        return values

    def check_rising(self, time: Sequence[float]) -> None:
        """Raise ModelError with the line of the first row whose time [s] is not above that of the one before."""
        for line, before, now in zip(self.lines[2:], time[:-1], time[1:], strict=True):
            if not now > before:
                raise self.error(line, "times must rise", given=now, allowed=f"more than {before:g} s")

    def error(self, line: int, problem: str, *, given: object, allowed: str = "") -> ModelError:
        """Return the error of a line of the file."""
        if self.path:  # the key comes first
            return ModelError(f"{self.name}, line {line}: {problem}", path=self.path, given=given, allowed=allowed)
        return ModelError(problem, path=f"{self.name}, line {line}", given=given, allowed=allowed)


def read_table(file: str | Path, *, most: int, allowed: str, path: str = "", given: str = "") -> CsvTable:
    """Return the cells of a CSV file.

    most : bytes it may have.  allowed : what it should hold.  path, given : the key that names the file, and how.
    Raises ModelError for a file that cannot be read, an empty one, and a row longer or shorter than its heading.
    """
    text, name = read_text(file, most=most, path=path, given=given, allowed=allowed), given or str(file)
    numbered = ((number, line.strip()) for number, line in enumerate(text.splitlines(), start=1))
    kept = [(number, line) for number, line in numbered if line and not line.startswith("#")]
    if not kept:
        raise ModelError("holds no line", path=f"{path}, {name}" if path else name, allowed=allowed)
    separator = ";" if ";" in kept[0][1] else ","
    table = CsvTable(name=name, path=path, heading=(), rows=(), lines=())
    longest = csv.field_size_limit()

    def cells() -> Iterator[tuple[int, list[str]]]:
        for number, line in kept:
            try:
                plain = '"' not in line and len(line) <= longest  # four times as quick
                row = line.split(separator) if plain else next(csv.reader([line], delimiter=separator))
                yield number, list(map(str.strip, row))
            except csv.Error as error:  # a cell of more than 131072 characters
                raise table.error(number, f"no row of a table: {error}", given=line, allowed=allowed) from None

    return _filled(table, cells())


def read_sheet(file: str | Path, *, most: int, allowed: str) -> CsvTable:
    """Return the cells of the first sheet of an Excel table (.xlsx), in the form of a CSV file.

    Formulas count as the values that were saved with them.  Raises ModelError as of `read_table`.
    """
    from openpyxl import load_workbook

    raw = read_bytes(file, most=most, allowed=allowed)
    try:
        sheet = load_workbook(BytesIO(raw), read_only=True, data_only=True).worksheets[0]
        texts = [
            ["" if cell is None else str(cell).strip() for cell in row] for row in sheet.iter_rows(values_only=True)
        ]
    except Exception as error:  # whatever openpyxl meets in a file that is no workbook
        raise ModelError(f"no Excel table: {error}", path=str(file), allowed=allowed) from None
    kept = [(line, row) for line, row in enumerate(texts, start=1) if any(row) and not row[0].startswith("#")]
    if not kept:
        raise ModelError("holds no line", path=str(file), allowed=allowed)
    width = max(len(row) for _, row in kept)
    filled = ((line, [*row, *[""] * (width - len(row))]) for line, row in kept)
    return _filled(CsvTable(name=str(file), path="", heading=(), rows=(), lines=()), filled)


def _filled(table: CsvTable, cells: Iterable[tuple[int, list[str]]]) -> CsvTable:
    """Return a table with line numbers and cells, the heading first. Raises ModelError for a row of another length."""
    lines, rows = list[int](), list[list[str]]()
    for line, row in cells:
        if rows and len(row) != len(rows[0]):
            problem, count = "another number of columns than the heading", str(len(rows[0]))
            raise table.error(line, problem, given=len(row), allowed=count)
        lines.append(line)
        rows.append(row)
    return replace(table, heading=rows[0], rows=rows[1:], lines=lines)


# files that a document names ------------------------------------------------------------------------------------------

_COLUMNS = ("deflection", "force")
# paths of what may name a file; of an operation the ripple alone, as a member may be called file
_REDUCED = re.compile(r"(stages\.[^.]+\.[^.]+|bodies\.[^.]+)\.reduced")
_PITCH = re.compile(r"deviations\.(?:.+\.)?pitch")
_JOINED = re.compile(r"(?:stages|bodies|couplings)(?:\.|$)")
_RIPPLE = re.compile(r"(?:operation|cases\.[^.]+)\.ripple(?:\.|$)")
# a word of another spelling is no label: "forces [N]" is refused
_FORCE_NAME = re.compile(r"(deflection|force)(?:[^A-Za-z].*)?")
_LENGTH = re.compile(r"\s*[+-]?[0-9.]+(?:[eE][+-]?[0-9]+)?\s*(?:[kcdmnuµμ]?m|in|inch)\s*$")
_FORCE_HEADING = "deflection [um], force [kN]; of several phases one column each: deflection [um], force 1 [kN], ..."

FileTable = Callable[[PlainTable, str], PlainTable]
"""Table that names a file, and its path -> what stands in its place."""
FileName = Callable[[str, str], str]
"""Name of a file and its path -> what stands in its place."""


def with_files(data: PlainTable, folder: Path | None) -> PlainTable:
    """Return a document with the numbers of the CSV files that it names, of force and of pitch, in place of the names.

    folder : where the files are looked for.  Raises ModelError with path, file and line.
    """

    def columns(table: PlainTable, path: str, *, read: Callable[..., PlainTable], names: Sequence[str]) -> PlainTable:
        path, name = f"{path}.file", table["file"]
        if beside := [column for column in names if column in table]:
            raise ModelError(f"stands beside {beside[0]}", path=path, given=name, allowed="one of the two")
        return {**read(name, path, folder), **{other: entry for other, entry in table.items() if other != "file"}}

    return at_files(
        data,
        forces=partial(columns, read=_force_table, names=_COLUMNS),
        torques=partial(columns, read=_torque_table, names=("angles", "torques")),
        pitches=partial(_pitch_list, folder=folder),
        bodies=lambda name, path: str(((folder or Path()) / name).absolute()),
    )


def at_files(
    data: PlainTable, *, forces: FileTable, torques: FileTable, pitches: FileName, bodies: FileName
) -> PlainTable:
    """Return a document with something else in place of the names of files, wherever it may name one.

    forces, torques : of a curve and of a ripple.  pitches : of deviations of pitch.  bodies : of matrices.
    """

    def read(value: Any, path: str) -> Any:
        if _REDUCED.fullmatch(path):
            return _with_names(value, path, bodies)
        if _PITCH.fullmatch(path):
            return _with_pitches(value, path, pitches)
        if isinstance(value, list):
            return [read(entry, f"{path}.{number}") for number, entry in enumerate(value, start=1)]
        if not isinstance(value, dict):
            return value
        table = forces if _JOINED.match(path) else torques if _RIPPLE.match(path) else None
        if table is not None and isinstance(value.get("file"), str):
            return table(value, path)
        return {key: read(entry, f"{path}.{key}") for key, entry in value.items()}

    return {name: read(value, name) for name, value in data.items()}


def _with_names(value: Any, path: str, read: FileName) -> Any:
    """Return what states a reduced body with the names of its files read."""
    if isinstance(value, str):
        return read(value, path)
    named = [key for key in MATRIX_FILES if isinstance(value, dict) and isinstance(value.get(key), str)]
    return {**value, **{key: read(value[key], f"{path}.{key}") for key in named}} if named else value


def _with_pitches(value: Any, path: str, read: FileName) -> Any:
    """Return lists in place of the files that a `pitch` names, one or one for each planet."""
    if isinstance(value, list) and all(isinstance(row, (list, str)) for row in value):
        return [read(row, path) if _is_file_name(row) else row for row in value]
    return read(value, path) if _is_file_name(value) else value


def _torque_table(name: str, path: str, folder: Path | None) -> PlainTable:
    """Return angles and torques of a file that a ripple names."""
    heading = "angle [deg], torque [N m]"
    allowed = f"a CSV file beside the model file: {heading}"
    table = read_table((folder or Path()) / name, most=MAX_BYTES, allowed=allowed, path=path, given=name)
    if [column for column, _ in table.columns] != ["angle", "torque"] or not table.rows:
        given = ", ".join(table.heading)
        raise table.error(table.lines[0], "no table of torques over a turn", given=given, allowed=heading)
    lists = {}
    for column, kind in enumerate(("angle", "torque")):
        table.scale(column, kind, allowed=heading)
        lists[f"{kind}s"] = f"[{', '.join(map(repr, table.numbers(column)))}] {table.columns[column][1]}"
    return lists


def _force_table(name: str, path: str, folder: Path | None) -> dict[str, object]:
    """Return deflections and forces of a CSV file as a model file states them. Raises ModelError."""
    allowed = f"a CSV file beside the model file: {_FORCE_HEADING}"
    table = read_table((folder or Path()) / name, most=MAX_BYTES, allowed=allowed, path=path, given=name)
    columns: dict[str, list[int]] = {key: [] for key in _COLUMNS}
    for column, (heading, unit) in enumerate(table.columns):
        match = _FORCE_NAME.fullmatch(heading)
        if match is None or not unit:
            given = table.heading[column]
            raise table.error(table.lines[0], "no heading of a column", given=given, allowed=_FORCE_HEADING)
        columns[match[1]].append(column)
    counts = {key: len(places) for key, places in columns.items()}
    if not all(counts.values()) or (min(counts.values()) > 1 and len(set(counts.values())) > 1):
        problem = f"{counts['deflection']} columns of deflections and {counts['force']} of forces"
        raise table.error(table.lines[0], problem, given=", ".join(table.heading), allowed=_FORCE_HEADING)
    if len(table.rows) < 2:
        raise ModelError(f"{name}: too few rows", path=path, given=len(table.rows), allowed="two or more")
    values = [table.numbers(column) for column in range(len(table.heading))]
    _check_curves(table, columns, values)
    found: dict[str, object] = {}
    for key, places in columns.items():
        lists = [f"[{', '.join(map(repr, values[at]))}] {table.columns[at][1]}" for at in places]
        found[key] = lists if len(lists) > 1 else lists[0]
    return found


def _check_curves(table: CsvTable, columns: dict[str, list[int]], values: Sequence[Sequence[float]]) -> None:
    """Raise ModelError with the line of a point that no curve may have."""
    for phase in range(max(map(len, columns.values()))):
        at = {key: places[phase if len(places) > 1 else 0] for key, places in columns.items()}
        if (fault := curve_fault(*(values[at[key]] for key in _COLUMNS))) is not None:
            key, point, problem, allowed = fault
            where = f"{table.name}, line {table.lines[point + 1]}, column {at[key] + 1}: {key} {problem}"
            given = f"{values[at[key]][point]!r} {table.columns[at[key]][1]}"
            raise ModelError(where, path=table.path, given=given, allowed=allowed)


def _is_file_name(value: object) -> bool:
    """Return whether what stands at `pitch` is the name of a file: a text that is neither a list nor a length."""
    return isinstance(value, str) and not value.lstrip().startswith("[") and not _LENGTH.match(value)


def _pitch_list(name: str, path: str, folder: Path | None) -> str:
    """Return the last column of a CSV file as a list with its unit, m without a heading. Raises ModelError."""
    allowed = "a CSV file beside the model file: one tooth a line, heading `pitch [um]` for a unit other than m"
    table = read_table((folder or Path()) / name, most=MAX_BYTES, allowed=allowed, path=path, given=name)
    unit = table.columns[-1][1]
    if not unit:  # the first line is a tooth too
        rows, lines = [table.heading, *table.rows], [0, *table.lines]
        unit, table = "m", replace(table, heading=["pitch"], rows=rows, lines=lines)
    return f"[{', '.join(map(repr, table.numbers(len(table.heading) - 1)))}] {unit}"


def check_assumed(layer: PlainTable, data: PlainTable, names: Names) -> None:
    """Raise ModelError for an assumed path of a layer that is not in `data`, with the nearest one that is.

    layer : as it is written.  data : expanded.
    """
    table = layer.get("assumed")
    for text, reason in leaves(table) if isinstance(table, dict) else ():
        for path in expand_path(text, names, path=f"assumed.{text}"):
            if value_at(data, path.split(".")) is None:
                near = nearest(path, (p for p, _ in leaves(data) if not p.startswith(("assumed.", "tolerance."))))
                allowed = "a path of this file"
                raise ModelError(f"no such path{near}", path=f"assumed.{text}", given=reason, allowed=allowed)


def still_assumed(data: PlainTable, overridden: Iterable[str]) -> PlainTable:
    """Return the document without assumptions about values that an override has set or removed."""
    gone = frozenset(overridden)

    def stands(path: str) -> bool:
        value = value_at(data, path.split("."))
        below = {p for p, _ in leaves({path: value})} if value is not None else set()
        return f"assumed.{path}" in gone or not below <= gone

    if not isinstance(data.get("assumed"), dict):
        return data
    return data | {"assumed": {path: reason for path, reason in data["assumed"].items() if stands(path)}}


def _check_units_stated(
    data: PlainTable, names: Names, file: PlainTable, settings: PlainTable, overridden: Collection[str]
) -> None:
    """Raise ModelError for the first number without a unit that a person wrote, by its path as written, and the others.

    file, settings : tables of the file, and values typed on the command line; empty where built in Python, whose
    numbers are SI.  overridden : paths set by any override.
    """
    if not (file or settings):
        return
    try:
        errors = bare_numbers(data, names)
    except ModelError:  # a name that is none, which validation tells
        return
    written: dict[str, BareNumber] = {}
    for layer, set_there in ((file, False), (settings, True)):
        for path, full in as_written(layer, errors, names):
            if (full in overridden) == set_there:
                written.setdefault(path, errors[full])
    if written:
        (path, first), *rest = written.items()
        others = f"{', '.join(p for p, _ in rest[:3])}{', ...' if rest[3:] else ''}"
        more = f" (and {len(rest)} more, at {others})" if rest else ""
        raise ModelError(f"{first.problem}{more}", path=path, given=first.given, allowed=first.allowed)


# reading --------------------------------------------------------------------------------------------------------------

Source = str | Path | Mapping[str, object]
Origin = Literal["given", "set"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Document:
    """A model file with its overrides, read.

    model : validated, in SI, references as full member paths; at the case that it names.
    data : the same as nested tables as written, shorthands expanded, overrides laid over (plain JSON).
    origin : by path of every value in `data`, whether the file gives it or an override sets it.
    source : name of the ready drive, path of the file, or "dict".
    warnings : what was assumed of a REXS file; numbers that follow teeth an override sets.
    hints : those of the warnings that say what else to set, for errors that follow.
    toleranced : what may stand at the path of each entry of `[tolerance]`.
    """

    model: ModelFile
    data: PlainTable
    origin: Mapping[str, Origin]
    source: str
    warnings: tuple[CodedText, ...] = ()
    hints: tuple[CodedText, ...] = ()
    toleranced: Mapping[str, Unit] = field(default_factory=dict)


def read(source: Source, overrides: Mapping[str, object] | None = None) -> Document:
    """Return the document of a model file or REXS file (path), ready drive (name) or nested dict, with overrides laid
    over it.

    overrides : values by path, ``{"stages.main.sun.mass": "750 kg"}``; None removes the key. A table that is removed
        may be filled anew: ``{"deviations": None, "deviations.sun.run_out": "6 um"}``.
    Raises ModelError for whatever is wrong, with path, value and what is allowed.
    """
    if isinstance(source, (str, Path)) and is_rexs_name(source):
        return _read_rexs(source, overrides)
    base, name, folder = _open(source)
    _check_format(base)
    *removed, layer = (with_files(layer_of(part, base), folder) for part in stepwise(overrides or {}))
    base = with_files(base, folder)
    names = collect(base, layer)
    check_names(names, base, layer)
    file, above = expand(base, names), expand(layer, names)
    case = str(above.get("case", file.get("case")))
    if isinstance(stated := value_at(file, ["cases", case]), dict):
        above = of_case(above, case, stated)
    for expanded in (file, above):
        check_alternatives(expanded)
    check_assumed(base, file, names)
    for emptied in removed:
        file = merge(file, expand(emptied, names))
    merged = merge(replace_alternatives(file, above), above)
    _check_format(merged)
    check_assumed(layer, merged, names)
    overridden = {path for path, _ in leaves(above)}
    names = collect(merged)  # an override may have removed what is referred to
    data = expand(still_toleranced(still_assumed(merged, overridden), file, above, names), names)
    data, followed, hints, moved = follow_teeth(data, file, frozenset(overridden), names)
    as_written, typed = {} if isinstance(source, Mapping) else base, settings_of(overrides or {})
    try:
        model, has_bare = validate(data, names)
    except ModelError:  # the size of a number without a unit is not to be believed
        _check_units_stated(data, names, as_written, typed, overridden)
        raise
    if has_bare:
        _check_units_stated(data, names, as_written, typed, overridden)
    toleranced = check_tolerance(data, names)
    origin: dict[str, Origin] = {path: "set" if path in overridden | moved else "given" for path, _ in leaves(data)}
    return Document(
        model=model,
        data=data,
        origin=origin,
        source=name,
        warnings=(*followed, *hints),
        hints=hints,
        toleranced=toleranced,
    )


def ready_drives() -> tuple[str, ...]:
    """Return the names of the drives that come with the package."""
    files = resources.files("epicyclic.systems").iterdir()
    stems = (file.name.removesuffix(".toml") for file in files if file.name.endswith(".toml"))
    return tuple(sorted(stem for stem in stems if "." not in stem))  # NAME.audit.toml lies beside NAME.toml


def _check_format(base: PlainTable) -> None:
    """Raise ModelError for a file of another version of the format, or of none, ahead of any other error."""
    version = base.get("format")
    if type(version) is int and version == FORMAT:  # 2.0 equals 2
        return
    allowed = f"format = {FORMAT}, described in docs/reference/model-file.md"
    if version is None:
        raise ModelError("missing", path="format", allowed=allowed)
    newer = type(version) is int and version > FORMAT
    problem = f"format {version} is newer than this program reads" if newer else "no version that this program reads"
    allowed += ", or a newer epicyclic" if newer else ""
    raise ModelError(problem, path="format", given=version, allowed=allowed)


def _open(source: object) -> tuple[PlainTable, str, Path | None]:
    """Return the raw tables, the name of the source, and the folder it is in."""
    if isinstance(source, Mapping):
        return clean(source), "dict", None
    if isinstance(source, str) and source in ready_drives():
        return parse_text(drive_text(source), source), source, None
    if not isinstance(source, (str, Path)):
        raise ModelError(
            "not a model", path=type(source).__name__, allowed="a path, the name of a ready drive, or a dict"
        )
    path = Path(source)
    return parse_text(file_text(path), str(source)), str(source), path.parent


def _read_rexs(path: str | Path, overrides: Mapping[str, object] | None) -> Document:
    """Return the document of a REXS file, with warnings of what is assumed and not read. Raises ModelError."""
    from ..rexs.import_train import read_rexs, traced  # only here: few models are REXS files

    train = read_rexs(path)
    try:
        document = read(train.document, overrides)
    except ModelError as error:
        raise traced(error, train) from None
    told = coded(
        "rexs-assumed",
        f"read from a REXS file: {len(train.assumed)} values assumed, {len(train.dropped)} entries dropped; "
        f"`epicyclic import {path}` lists them",
    )
    return replace(document, source=str(path), warnings=(told, *train.warnings, *document.warnings))


def file_text(path: Path) -> str:
    """Return the text of a file. Raises ModelError where there is none."""
    name = str(path)
    drives = ready_drives()
    allowed = f"a .toml file, or one of the ready drives {', '.join(drives)}"
    try:
        os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        problem = f"no such file or ready drive{nearest(path.stem, drives)}"
        raise ModelError(problem, path=name, allowed=allowed) from None
    except (OSError, ValueError) as error:
        raise ModelError(f"cannot be read: {error}", path=name[:80], allowed=allowed) from None
    return decoded(read_bytes(path, most=MAX_BYTES, allowed=allowed), name)


def decoded(raw: bytes, name: str) -> str:
    """Return bytes as text. Raises ModelError for an empty or binary file, and for another encoding than UTF-8."""
    allowed = f"a TOML text in UTF-8 that begins with `format = {FORMAT}`"
    if not raw.strip():
        raise ModelError("empty", path=name, allowed=allowed)
    if b"\0" in raw:
        raise ModelError("a binary file", path=name, allowed=allowed)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw[: error.start].count(b"\n") + 1
        raise ModelError(f"not UTF-8 (line {line})", path=name, allowed=allowed) from None


def parse_text(text: str, name: str) -> PlainTable:
    """Return the tables of a TOML text. Raises ModelError with the line."""
    if (line := dotted_line(text)) is not None:
        raise ModelError(f"nested too deeply (line {line})", path=name, allowed="tables a few levels deep")
    try:
        table = tomllib.loads(text, parse_float=finite_float)
    except RecursionError:
        raise ModelError("nested too deeply", path=name, allowed="tables and lists a few levels deep") from None
    except (ValueError, OverflowError) as error:  # TOML errors, and integers of thousands of digits
        raise ModelError(f"not TOML: {error}", path=name, allowed="a TOML file") from None
    cleaned: PlainTable = clean(table)
    return cleaned


def drive_titles() -> dict[str, str]:
    """Name -> title of every ready drive, the model files that come with the package."""
    return {name: str(tomllib.loads(drive_text(name))["title"]) for name in ready_drives()}


def drive_text(name: str) -> str:
    """Model file of a ready drive, with its comments.

    Raises
    ------
    ModelError : no drive of this name.
    """
    names = ready_drives()
    if name not in names:
        raise ModelError(f"no ready drive{nearest(name, names)}", path="NAME", given=name, allowed=", ".join(names))
    return resources.files("epicyclic.systems").joinpath(f"{name}.toml").read_text(encoding="utf-8")
