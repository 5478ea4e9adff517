"""Model file -> validated, normalised document in SI, with overrides laid over it.

Paths of `[assumed]` must exist.  What a person wrote without a unit is refused by its path.
"""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Literal

from ..errors import ModelError
from ..input_files import read_bytes
from ..rexs.file import is_rexs_name
from ..warning_codes import CodedText, coded
from .csv_files import with_files
from .overrides import check_alternatives, follow_teeth, layer_of, replace_alternatives, settings_of, stepwise
from .schema import FORMAT, ModelFile, Names, check_names, collect, nearest
from .shorthand import expand, expand_path
from .tables import PlainTable, clean, dotted_line, leaves, merge, nested, value_at
from .tolerances import check_tolerance, still_toleranced
from .units import finite_float
from .validation import bare_numbers, validate
from .written_numbers import BareNumber


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
        for path, value in leaves(layer):
            if isinstance(value, str) and "[" not in value:
                continue
            try:
                expanded = [p for p, _ in leaves(expand(nested(tuple(path.split(".")), value), names))]
            except ModelError:
                continue
            bare = [p for p in expanded if p in errors and (p in overridden) == set_there]
            if bare:
                written[path] = errors[bare[0]]
    if written:
        (path, first), *rest = written.items()
        others = f"{', '.join(p for p, _ in rest[:3])}{', ...' if rest[3:] else ''}"
        more = f" (and {len(rest)} more, at {others})" if rest else ""
        raise ModelError(f"{first.problem}{more}", path=path, given=first.given, allowed=first.allowed)


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
    warnings : what was assumed of a REXS file; numbers that follow teeth an override sets.
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
    of_file, typed = {} if isinstance(source, Mapping) else base, settings_of(overrides or {})
    try:
        model, has_bare = validate(data, names)
    except ModelError:  # the size of a number without a unit is not to be believed
        _check_units_stated(data, names, of_file, typed, overridden)
        raise
    if has_bare:
        _check_units_stated(data, names, of_file, typed, overridden)
    check_tolerance(data, names)
    origin: dict[str, Origin] = {path: "set" if path in overridden | moved else "given" for path, _ in leaves(data)}
    return Document(model=model, data=data, origin=origin, source=name, warnings=(*followed, *hints), hints=hints)


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
        table = tomllib.loads(text, parse_float=finite_float)
    except RecursionError:
        raise ModelError("nested too deeply", path=name, allowed="tables and lists a few levels deep") from None
    except (ValueError, OverflowError) as error:  # TOML errors, and integers of thousands of digits
        raise ModelError(f"not TOML: {error}", path=name, allowed="a TOML file") from None
    cleaned: PlainTable = clean(table)
    return cleaned
