"""Reading of audit files: rows that are wrong are told apart, so that the others can be computed."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from importlib import resources
from pathlib import Path
from typing import get_args

from pydantic import BaseModel, ValidationError

from ..document.validation import words_of
from ..errors import ModelError
from ..user_input import read_text
from .audit_file import Audit, Row, Run, SourceReading, Value, Verdict

AUDITED = ".audit.toml"
_MAX_BYTES = 4_000_000  # as of a model file
# parts of a place in the schema that no key of the file is: kinds of a value that may be of several
_KINDS = re.compile(r"[\[\]]|^(str|float|int|bool)$")


@dataclass(frozen=True, slots=True, kw_only=True)
class WrongRow:
    """A row that cannot be read.  at : place among the rows of the file.  row : of it what is a text.  error : why."""

    at: int
    row: Row
    error: ModelError


@dataclass(frozen=True, slots=True, kw_only=True)
class AuditFile:
    """What an audit file says.

    file : its name, or path.  drive : name or path of the model audited.  audit : with the rows that can be read.
    places : of those among the rows of the file.  wrong : the other rows.
    """

    file: str
    drive: str
    audit: Audit
    places: tuple[int, ...]
    wrong: tuple[WrongRow, ...]

    def named(self, error: ModelError) -> ModelError:
        """The same error with the file in front of its path."""
        return _named(error, self.file)


def audited_drives() -> tuple[str, ...]:
    """Names of the ready drives that come with an audit."""
    files = resources.files("epicyclic.systems").iterdir()
    return tuple(sorted(file.name.removesuffix(AUDITED) for file in files if file.name.endswith(AUDITED)))


def read_audit(source: str | Path) -> AuditFile:
    """Read the audit of a ready drive (its name), or an audit file (its path).

    Raises
    ------
    ModelError : no such audit, or something in it beside single rows is wrong, with file, path, what was given and what
        is allowed.
    """
    file, drive, text = _text(source)
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ModelError(f"not TOML: {error}", path=file, allowed="an audit file") from None
    rows = table.get("rows")
    try:
        whole = Audit.model_validate({**table, "rows": []} if isinstance(rows, list) else table)
    except ValidationError as error:
        raise _named(_as_model_error(error), file) from None
    found = [_row(whole, entry, at, file) for at, entry in enumerate(rows if isinstance(rows, list) else ())]
    return AuditFile(
        file=file,
        drive=whole.drive or drive,
        audit=whole.model_copy(update={"rows": tuple(one for one in found if isinstance(one, Row))}),
        places=tuple(at for at, one in enumerate(found) if isinstance(one, Row)),
        wrong=tuple(one for one in found if isinstance(one, WrongRow)),
    )


def _row(audit: Audit, entry: object, at: int, file: str) -> Row | WrongRow:
    """A row of an audit, or why it is none."""
    path = f"rows.{at}"
    try:
        row = Row.model_validate(entry)
        audit.check_row(row, path)
    except ValidationError as error:
        wrong = _as_model_error(error, ("rows", at))
    except ModelError as error:
        wrong = error
    else:
        return row
    return WrongRow(at=at, row=_legible(entry, path), error=_named(wrong, file))


def _legible(entry: object, path: str) -> Row:
    """What a table that is no row says of itself, unchecked: its texts, and a verdict where it is one."""
    table = entry if isinstance(entry, Mapping) else {}

    def text(key: str, otherwise: str = "") -> str:
        value = table.get(key)
        return value if isinstance(value, str) and value else otherwise

    published = table.get("published", "")
    return Row.model_construct(
        quantity=text("quantity", path),
        place=text("place"),
        published=published if isinstance(published, str) else repr(published),
        unit=text("unit", "1"),
        verdict=text("verdict") if text("verdict") in get_args(Verdict) else "",
        reading=text("reading"),
        reason=text("reason"),
        because=text("because"),
    )


def _text(source: str | Path) -> tuple[str, str, str]:
    """Name of the file, model audited and text of the audit."""
    drives = audited_drives()
    if isinstance(source, str) and source in drives:
        found = resources.files("epicyclic.systems").joinpath(source + AUDITED)
        return source + AUDITED, source, found.read_text(encoding="utf-8")
    path = Path(source)
    if not path.name.endswith(AUDITED) or not path.is_file():
        near = get_close_matches(str(source), drives, n=1)
        problem = f"no such audit; did you mean {near[0]!r}?" if near else "no such audit"
        raise ModelError(problem, path=str(source), allowed=", ".join(drives) + f", or the path of a file *{AUDITED}")
    name = path.name.removesuffix(AUDITED)
    beside = path.with_name(f"{name}.toml")
    return str(source), str(beside) if beside.is_file() else name, read_text(path, most=_MAX_BYTES)


def _named(error: ModelError, file: str) -> ModelError:
    """The same error with a file in front of its path."""
    return error.at(f"{file}: {error.path}" if error.path else file)


def _as_model_error(error: ValidationError, above: tuple[int | str, ...] = ()) -> ModelError:
    """One ModelError: unknown keys first, since a misspelt key is also a missing one.

    above : place of what was validated.
    """
    details = sorted(error.errors(include_url=False), key=lambda entry: entry["type"] != "extra_forbidden")
    first = details[0]
    loc = (*above, *first["loc"])
    path = _path(loc)
    inner = first.get("ctx", {}).get("error")
    if isinstance(inner, ModelError):
        return inner.at(inner.path or path)
    if first["type"] == "extra_forbidden":
        return ModelError("unknown key", path=path, allowed=", ".join(_keys(loc)))
    problem, allowed = words_of(first)
    # of a value that may be of several kinds, those that it is not
    other = [words_of(one)[1] for one in details if _path((*above, *one["loc"])) == path]
    allowed = " or ".join(dict.fromkeys(text for text in (allowed, *other) if text))
    if first["type"] == "missing":
        return ModelError(problem, path=path, allowed=allowed)
    return ModelError(problem, path=path, given=first["input"], allowed=allowed)


def _path(loc: tuple[int | str, ...]) -> str:
    """Path in the file of a place in the schema."""
    return ".".join(str(part) for part in loc if not _KINDS.search(str(part)))


def _keys(loc: tuple[int | str, ...]) -> tuple[str, ...]:
    """Keys of the table a place is in."""
    table: type[BaseModel] = Audit
    if "ours" in loc[:-1]:
        table = Value
    elif "readings" in loc[:-1]:
        table = SourceReading
    elif len(loc) > 1:
        table = Run if loc[0] == "runs" else Row
    return tuple(table.model_fields)
