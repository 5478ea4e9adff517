"""Model file -> validated, normalised document in SI."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Literal

from ..errors import ModelError
from ..input_files import read_bytes
from ..rexs.names import is_rexs_name
from ..warning_codes import CodedText, coded
from .assumptions import check_assumed, still_assumed
from .changed_teeth import follow_teeth
from .force_files import with_files
from .names import check_names, collect, nearest
from .overrides import check_alternatives, layer_of, replace_alternatives, settings_of, stepwise
from .schema import ModelFile
from .shorthand import expand
from .tables import PlainTable, clean, dotted_line, leaves, merge
from .tolerances import still_toleranced
from .unit_rule import WrittenLayers, checked_model

__all__ = ["MAX_BYTES", "Document", "Source", "decoded", "file_text", "parse_text", "read", "ready_drives"]

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
