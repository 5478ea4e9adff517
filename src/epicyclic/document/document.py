"""Model file -> validated, normalised document in SI.

`[assumed]`: its paths must exist.

The rule of units: what a person wrote without one is refused in format 2, and told in format 1, by its path.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Any, Literal

from ..errors import ModelError
from ..input_files import read_bytes
from ..rexs.file import is_rexs_name
from ..warning_codes import CodedText, coded
from .csv_files import with_files
from .overrides import check_alternatives, follow_teeth, layer_of, replace_alternatives, settings_of, stepwise
from .schema import ModelFile, Names, check_names, collect, nearest
from .shorthand import expand
from .tables import PlainTable, clean, dotted_line, leaves, merge, nested
from .tolerances import check_tolerance, still_toleranced
from .units import KINDS
from .validation import bare_places, validate
from .written_numbers import BareNumber, likely_text


def check_assumed(layer: PlainTable, data: PlainTable) -> None:
    """Raise ModelError for an assumed path that is not in `data`, with the nearest one that is."""
    for path, reason in _entries(layer):
        if _find(data, path) is None:
            near = nearest(path, (p for p, _ in leaves(data)))
            allowed = "a path of this file"
            raise ModelError(f"no such path{near}", path=f"assumed.{path}", given=reason, allowed=allowed)


def still_assumed(data: PlainTable, overridden: Iterable[str]) -> PlainTable:
    """Return the document without assumptions about values that an override has set or removed."""
    gone = frozenset(overridden)

    def stands(path: str) -> bool:
        found = _find(data, path)
        below = {p for p, _ in leaves({path: found})} if found is not None else set()
        return f"assumed.{path}" in gone or not below <= gone

    if not isinstance(data.get("assumed"), dict):
        return data
    return data | {"assumed": {path: reason for path, reason in data["assumed"].items() if stands(path)}}


def _entries(data: PlainTable) -> list[tuple[str, object]]:
    """Return path and reason of every assumption."""
    table = data.get("assumed")
    return list(table.items()) if isinstance(table, dict) else []


def _find(data: PlainTable, path: str) -> object | None:
    """Return what stands at a path, None where nothing does."""
    here: object = data
    for part in path.split("."):
        if not isinstance(here, dict) or part not in here:
            return None
        here = here[part]
    return here


# warnings of one file: as many as fit on a screen, or the first few and the count
_MOST, _FEW = 8, 5


@dataclass(frozen=True, slots=True, kw_only=True)
class WrittenLayers:
    """Layers that a person wrote, as they stand; empty where built in Python, whose numbers are SI.

    file : tables of the file.  settings : values typed on the command line.  overridden : paths set by any override.
    """

    file: PlainTable
    settings: PlainTable
    overridden: Collection[str]


def checked_model(
    data: PlainTable, names: Names, folder: Path | None, layers: WrittenLayers
) -> tuple[ModelFile, tuple[CodedText, ...]]:
    """Return the validated model, and a warning of each number without a unit in a file of format 1.

    Raises ModelError for whatever is wrong; first for a number without a unit, whose size is not to be believed.
    """
    fault: ModelError | None = None
    try:
        model, found = validate(data, names, folder)
    except ModelError as error:
        fault, found = error, True
    written = _written_bare(data, names, folder, layers) if found and (layers.file or layers.settings) else {}
    if written and data.get("format") != 1:
        raise _refusal(written)
    if fault is not None:
        raise fault
    return model, (*_told(written), *check_tolerance(data, names, folder))


def _written_bare(data: PlainTable, names: Names, folder: Path | None, layers: WrittenLayers) -> dict[str, BareNumber]:
    """Return the bare numbers that a person wrote, by the path as it is written."""
    try:
        places = {place.path: place.error for place in bare_places(data, names, folder)}
    except ModelError:  # a name that is none, which validation tells
        return {}
    found: dict[str, BareNumber] = {}
    for layer, set_there in ((layers.file, False), (layers.settings, True)):
        for path, value in _numbers(layer):
            try:
                stands = [p for p, _ in leaves(expand(nested(path, value), names))]
            except ModelError:
                continue
            mine = [p for p in stands if p in places and (p in layers.overridden) == set_there]
            if mine:
                found[".".join(path)] = places[mine[0]]
    return found


def _numbers(table: PlainTable, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield path and value of everything in which a bare number may stand."""
    for name, value in table.items():
        if isinstance(value, dict):
            yield from _numbers(value, (*path, name))
        elif isinstance(value, (int, float, list)) or (isinstance(value, str) and "[" in value):
            yield (*path, name), value


def _refusal(written: dict[str, BareNumber]) -> ModelError:
    """Return the error of the first, which names the others."""
    (path, first), *rest = written.items()
    more = (
        f" (and {len(rest)} more, at {', '.join(p for p, _ in rest[:3])}{', ...' if rest[3:] else ''})" if rest else ""
    )
    return ModelError(f"{first.problem}{more}", path=path, given=first.given, allowed=first.allowed)


def _told(written: dict[str, BareNumber]) -> list[CodedText]:
    """Return a warning of each, of very many the first few and their number."""
    texts = [_warning(path, error) for path, error in written.items()]
    if len(texts) <= _MOST:
        return texts
    return [
        *texts[:_FEW],
        coded("no-unit", f"{len(texts)} numbers of the file have no unit, {len(texts) - _FEW} more than these"),
    ]


def _warning(path: str, error: BareNumber) -> CodedText:
    """Return what a bare number was read as, and what was likely meant."""
    unit = KINDS[error.kinds[0]].unit
    read = likely_text(error.given, error.kinds, ((0.0, unit),))
    given = read.removesuffix(unit).strip()
    meant = "write it so, as format = 2 asks" if read == error.likely else f'"{error.likely}"?'
    return coded("no-unit", f'{path} = {given}: no unit, read as "{read}"; {meant}')


FORMAT = 2
MAX_BYTES = 4_000_000
Source = str | Path | Mapping[str, object]
Origin = Literal["given", "set"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Document:
    """A model file with its overrides, read.

    model : validated, in SI, references as full member paths.
    data : the same as nested tables as written, shorthands expanded, overrides laid over (plain JSON).
    origin : by path of every value in `data`, whether the file gives it or an override sets it.
    source : name of the ready drive, path of the file, or "dict".
    warnings : numbers without a unit, read as SI in a file of format 1; what was assumed of a REXS file; numbers that
        follow teeth an override sets.
    hints : those of the warnings that say what else to set, for errors that follow.
    """

    model: ModelFile
    data: PlainTable
    origin: Mapping[str, Origin]
    source: str
    warnings: tuple[CodedText, ...] = ()
    hints: tuple[CodedText, ...] = ()


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
    for one in (file, above):
        check_alternatives(one)
    check_assumed(file, file)
    for emptied in removed:
        file = merge(file, expand(emptied, names))
    merged = merge(replace_alternatives(file, above), above)
    check_assumed(above, merged)
    overridden = {path for path, _ in leaves(above)}
    names = collect(merged)  # an override may have removed what is referred to
    data = expand(still_toleranced(still_assumed(merged, overridden), file, above, names), names)
    data, followed, hints, moved = follow_teeth(data, file, frozenset(overridden), names)
    layers = WrittenLayers(
        file={} if isinstance(source, Mapping) else base, settings=settings_of(overrides or {}), overridden=overridden
    )
    model, warnings = checked_model(data, names, folder, layers)
    origin: dict[str, Origin] = {path: "set" if path in overridden | moved else "given" for path, _ in leaves(data)}
    return Document(
        model=model, data=data, origin=origin, source=name, warnings=(*warnings, *followed, *hints), hints=hints
    )


def ready_drives() -> tuple[str, ...]:
    """Return the names of the drives that come with the package."""
    files = resources.files("epicyclic.systems").iterdir()
    stems = (file.name.removesuffix(".toml") for file in files if file.name.endswith(".toml"))
    return tuple(sorted(stem for stem in stems if "." not in stem))  # NAME.audit.toml lies beside NAME.toml


def _check_format(base: PlainTable) -> None:
    """Raise ModelError for a file without version or of a newer one, ahead of any other error."""
    version = base.get("format")
    if version is None:
        raise ModelError("missing", path="format", allowed=f"format = {FORMAT}, the version of the file format")
    if isinstance(version, bool):
        raise ModelError("not a whole number", path="format", given=version, allowed=f"format = {FORMAT}")
    if isinstance(version, int) and version > FORMAT:
        problem = f"format {version} is newer than this program reads"
        raise ModelError(problem, path="format", given=version, allowed=f"format = 1 or {FORMAT}, or a newer epicyclic")


def _open(source: object) -> tuple[PlainTable, str, Path | None]:
    """Return the raw tables, the name of the source, and the folder it is in."""
    if isinstance(source, Mapping):
        return clean(source), "dict", None
    if isinstance(source, str) and source in ready_drives():
        text = resources.files("epicyclic.systems").joinpath(f"{source}.toml").read_text(encoding="utf-8")
        return parse_text(text, source), source, None
    if not isinstance(source, (str, Path)):
        raise ModelError(
            "not a model", path=type(source).__name__, allowed="a path, the name of a ready drive, or a dict"
        )
    path = Path(source)
    return parse_text(file_text(path), str(source)), str(source), path.parent


def _read_rexs(path: str | Path, overrides: Mapping[str, object] | None) -> Document:
    """Return the document of a REXS file, with warnings of what is assumed and not read. Raises ModelError."""
    from ..rexs.import_train import read_rexs, traced  # only here: few models are REXS files

    found = read_rexs(path)
    try:
        document = read(found.document, overrides)
    except ModelError as error:
        raise traced(error, found) from None
    told = coded(
        "rexs-assumed",
        f"read from a REXS file: {len(found.assumed)} values assumed, {len(found.dropped)} entries dropped; "
        f"`epicyclic import {path}` lists them",
    )
    return replace(document, source=str(path), warnings=(told, *found.warnings, *document.warnings))


def file_text(path: Path) -> str:
    """Return the text of a file. Raises ModelError where there is none."""
    name = str(path)
    drives = ready_drives()
    allowed = f"a .toml file, or one of the ready drives {', '.join(drives)}"
    try:
        if path.is_dir():
            raise ModelError("a folder", path=name, allowed=allowed)
        if not path.exists():
            raise ModelError(f"no such file or ready drive{nearest(path.stem, drives)}", path=name, allowed=allowed)
    except (OSError, ValueError) as error:
        if isinstance(error, ModelError):
            raise
        raise ModelError(f"cannot be read ({error})", path=name[:80], allowed=allowed) from None
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
        table = tomllib.loads(text, parse_float=_float)
    except RecursionError:
        raise ModelError("nested too deeply", path=name, allowed="tables and lists a few levels deep") from None
    except ValueError as error:  # TOML errors, and integers of thousands of digits
        raise ModelError(f"not TOML: {error}", path=name, allowed="a TOML file") from None
    cleaned: PlainTable = clean(table)
    return cleaned


def _float(text: str) -> float:
    """Return a float. Raises ValueError where it is too large to be one."""
    number = float(text)
    if math.isinf(number) and "inf" not in text:
        raise ValueError(f"{text} is too large")
    return number
