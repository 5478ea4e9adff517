"""Audit file: published numbers of a drive, how ours is computed, and what is claimed of the two.

The format is described in docs/papers/audit.md.  `read_audit` reads it, and tells rows that are wrong apart, so that
the others can be computed; whether the claims hold is found by `audit`.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, model_validator

from ..document.validation import words_of
from ..errors import ModelError
from ..user_input import read_text
from ..verbs.record import verbs

AS_PRINTED = "as printed"
"""Text of the attempt that needs no reading."""
Verdict = Literal["reproduced", "under a reading", "not reproducible", "not compared"]
Origin = Literal["source", "hand calculation"]
Label = str | bool | int | float
Text = Annotated[str, Field(min_length=1)]
_REDUCTIONS = ("max", "min", "mean", "sum", "rms", "range", "ratio", "largest", "count", "first", "last")
_PLACES = ("argmax", "argmin")
_NUMBER = r"[+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?"
_BOUND = re.compile(rf"(<=|>=|<|>)\s*({_NUMBER})")
_RANGE = re.compile(rf"({_NUMBER})\s*\.\.\s*({_NUMBER})")


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Run(_Table):
    """One run of a verb.

    verb : name of a verb; may come from `based_on`.  drive : another ready drive than the audited one.
    set : overrides, path -> value, an empty text removes.  options : keyword arguments of the verb.
    based_on : another run whose verb, drive, set, options and fitted this one starts from.
    fitted : paths of `set` whose values were chosen so that a published number comes out.
    needs : a package outside the plain installation that the verb needs.
    """

    verb: str | None = None
    drive: str | None = None
    set: dict[str, Any] = {}
    options: dict[str, Any] = {}
    based_on: str | None = None
    fitted: tuple[str, ...] = ()
    needs: str | None = None

    @model_validator(mode="after")
    def _known(self) -> Run:
        if self.verb is None and self.based_on is None:
            raise ModelError("neither verb nor based_on", allowed="verb = " + ", ".join(verbs()))
        if self.verb is not None and self.verb not in verbs():
            raise ModelError(f"no verb {self.verb!r}", allowed=", ".join(verbs()))
        return self


class Value(_Table):
    """A number (or several) taken from a run, or made of others.

    run, take : variable `take` of the result of a run; ``take = "warnings"`` are its warnings.
    where : labels to keep, by coordinate or variable of one dimension: a text (``*`` and ``?`` match), number or list.
    between : least and greatest value to keep, by coordinate or variable.  nearest : keep the one label nearest to it.
    reduce : how one number is left, in steps: "max", "mean time".  read : variable read where the largest or smallest
    is ("argmax", "argmin").  pick : positions kept of what is left, 0 the first.
    difference, ratio (of two), sum, product, greatest, least (of several) : made of other values.
    value : a plain number.  unit : converted to before scale and offset.  scale : number, or text with a unit.
    """

    run: str | None = None
    take: str | None = None
    where: dict[str, Label | list[Label]] = {}
    between: dict[str, tuple[float, float]] = {}
    nearest: dict[str, float] = {}
    pick: int | list[int] | None = None
    reduce: str | list[str] = "only"
    read: str | None = None
    difference: tuple[Value, Value] | None = None
    ratio: tuple[Value, Value] | None = None
    sum: tuple[Value, ...] | None = None
    product: tuple[Value, ...] | None = None
    greatest: tuple[Value, ...] | None = None
    least: tuple[Value, ...] | None = None
    value: float | None = None
    unit: str | None = None
    scale: float | str = 1.0
    offset: float = 0.0
    absolute: bool = False

    @model_validator(mode="after")
    def _one_form(self) -> Value:
        forms = [key for key in _FORMS if getattr(self, key) is not None]
        if len(forms) != 1:
            problem = f"both {' and '.join(forms)}" if forms else "nothing to compute"
            raise ModelError(problem, allowed="one of " + ", ".join(_FORMS))
        if (self.take is None) != (self.run is None):
            raise ModelError("take and run belong together", allowed='run = "NAME", take = "VARIABLE"')
        for step in self.steps:
            _check_step(step, self.read)
        return self

    @property
    def steps(self) -> tuple[str, ...]:
        """The steps of the reduction."""
        return (self.reduce,) if isinstance(self.reduce, str) else tuple(self.reduce)

    @property
    def parts(self) -> tuple[Value, ...]:
        """The values this one is made of."""
        found = [getattr(self, key) for key in _FORMS[1:-1]]
        return tuple(part for parts in found if parts is not None for part in parts)

    def runs(self) -> Iterator[str]:
        """Names of the runs it needs."""
        if self.run is not None:
            yield self.run
        for part in self.parts:
            yield from part.runs()

    def with_run(self, name: str) -> Value:
        """The same value taken from another run."""
        changed: dict[str, Any] = {} if self.run is None else {"run": name}
        for key in _FORMS[1:-1]:
            if (parts := getattr(self, key)) is not None:
                changed[key] = tuple(part.with_run(name) for part in parts)
        return self.model_copy(update=changed)


_FORMS = ("take", "difference", "ratio", "sum", "product", "greatest", "least", "value")


class Attempt(_Table):
    """One number of ours for a row: its own, or that of a reading, with the tolerance that holds for it.

    reading : under which reading of the source.  ours : how the number is computed.
    tolerance (in the unit of the row) or relative : how far ours may be away, and because : why so much.
    reason : erratum or missing datum, or why there is no number.  fitted : a parameter was fitted.
    """

    reading: str = ""
    ours: Value | None = None
    tolerance: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    relative: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    because: str = ""
    reason: str = ""
    fitted: bool = False

    @property
    def bounded(self) -> bool:
        """Whether it states a tolerance."""
        return self.tolerance is not None or self.relative is not None

    def problems(self) -> Iterator[tuple[str, str]]:
        """Contradictions in it: problem, and what is allowed."""
        if self.tolerance is not None and self.relative is not None:
            yield "both tolerance and relative", "one of them"
        if self.bounded and not self.because:
            yield "a tolerance without its reason", 'because = "..."'

    @model_validator(mode="after")
    def _claims_fit(self) -> Self:
        for problem, allowed in self.problems():
            raise ModelError(problem, allowed=allowed)
        return self


class SourceReading(Attempt):
    """One way to read the source, and the number it gives.

    reading : the way, in words.  run : the run with which `ours` of the row is computed, where that is not stated here.
    tolerance or relative, because : if other than those of the row.
    """

    reading: Text
    run: str | None = None

    def problems(self) -> Iterator[tuple[str, str]]:
        """Contradictions in it: problem, and what is allowed."""
        if self.ours is not None and self.run is not None:
            yield "both ours and run", "one of them"
        if self.ours is None and self.run is None and not self.reason:
            yield "no number and no reason", 'ours = { ... }, run = "NAME", or reason = "why it gives no number"'
        yield from super().problems()


class Row(Attempt):
    """A published number (or list of them, one row each) and what is claimed of it.

    published : number, list, inequality "> 0", range "0.2 .. 0.3"; any text where not reproducible or not compared.
    published_as : "measured" or "drawn", of a row that is not compared.
    origin : who gives `published`; a hand calculation of ours is no number of the source.
    readings : the ways to read the source that were tried.  nothing_to_try : why there is no other way to read it.
    labels : of the numbers of a list, put in place of {} in `quantity`.
    """

    quantity: Text
    place: Text
    published: FiniteFloat | str | list[FiniteFloat]
    unit: str = "1"
    verdict: Verdict
    labels: tuple[str, ...] = ()
    published_as: Literal["measured", "drawn"] | None = None
    origin: Origin = "source"
    readings: tuple[SourceReading, ...] = ()
    nothing_to_try: str = ""

    def problems(self) -> Iterator[tuple[str, str]]:
        """Contradictions in it: problem, and what is allowed."""
        runs = set(self.ours.runs()) if self.ours else set()
        if len(runs) != 1 and any(reading.run for reading in self.readings):
            yield "a reading names a run, but ours of the row is not computed from one", "ours = { ... } in the reading"
        if self.verdict in ("reproduced", "under a reading"):  # what a claimed number lacks to be checked
            tried = [one for one in attempts(self) if one.ours is not None]
            if not tried or (self.verdict == "reproduced" and self.ours is None):
                yield f"{self.verdict}, but nothing is computed", "ours = { run = ..., take = ... }"
            if isinstance(self.published, str) and claim_of(self.published) is None:
                yield "a text cannot be checked", 'a number, "> 0", "0.2 .. 0.3"'
            if not isinstance(self.published, str) and not all(one.bounded for one in tried):
                yield "no tolerance", "tolerance (in the unit of the row) or relative, and because"
        yield from super().problems()
        if self.verdict == "under a reading" and not self.reading and not self.readings:
            yield "the reading is not stated", 'reading = "..."'
        if self.verdict == "not reproducible" and not self.reason:
            yield "no reason", 'reason = "the erratum, or the datum that is missing"'
        if self.fitted and self.verdict == "reproduced":
            yield "reproduced with a fitted value", 'verdict = "under a reading"'
        if self.labels and (not isinstance(self.published, list) or len(self.labels) != len(self.published)):
            yield "labels do not go with the published list", "as many labels as published numbers"
        if (self.verdict == "not compared") != (self.published_as is not None):
            yield "not compared and published_as belong together", 'published_as = "measured" or "drawn"'
        if self.verdict == "not compared" and (self.bounded or self.readings):
            yield "not compared, with a tolerance or readings", "another verdict, or neither of them"
        if self.nothing_to_try and self.verdict != "not reproducible":
            yield "nothing_to_try, though a number came out", 'verdict = "not reproducible"'
        if self.origin != "source" and self.verdict not in ("reproduced", "under a reading"):
            yield f"a hand calculation that is {self.verdict}", "reproduced, under a reading"
        texts = [self.reading or AS_PRINTED, *(reading.reading for reading in self.readings)]
        if len(set(texts)) < len(texts):
            yield "two readings of the same text", "one text each"


class Audit(_Table):
    """An audit file.  drive : ready drive or path of the model audited; None: the name of the file."""

    format: Literal[2]
    drive: str | None = None
    source: Text
    notes: str = ""
    runs: dict[str, Run] = {}
    rows: tuple[Row, ...]

    @model_validator(mode="after")
    def _runs_exist(self) -> Audit:
        for name, run in self.runs.items():
            self._chain(name)
            if missing := [path for path in run.fitted if path not in self.resolved(name).set]:
                where = f"runs.{name}.fitted"
                raise ModelError("fitted, but not set", path=where, given=missing, allowed="paths of set")
            if self.resolved(name).verb is None:
                raise ModelError("no verb", path=f"runs.{name}.verb", allowed=", ".join(verbs()))
        return self

    def check_row(self, row: Row, path: str) -> None:
        """Refuse a row that does not go with the runs.

        Raises
        ------
        ModelError : no such run, reproduced with a fitted run; at `path` of the row.
        """
        for name in row.ours.runs() if row.ours else ():
            self._known(name, f"{path}.ours.run")
        for place, reading in enumerate(row.readings):
            for name in (reading.run,) if reading.run else reading.ours.runs() if reading.ours else ():
                self._known(name, f"{path}.readings.{place}.run")
        if row.verdict == "reproduced" and self.fitted(row):
            allowed = 'verdict = "under a reading"'
            raise ModelError("reproduced with a fitted value", path=f"{path}.verdict", allowed=allowed)

    def resolved(self, name: str) -> Run:
        """The run with what it is based on."""
        run = self.runs[name]
        if run.based_on is None:
            return run
        base = self.resolved(run.based_on)
        return Run(
            verb=run.verb or base.verb,
            drive=run.drive or base.drive,
            set={**base.set, **run.set},
            options={**base.options, **run.options} if run.verb in (None, base.verb) else run.options,
            fitted=(*base.fitted, *run.fitted),
            needs=run.needs or base.needs,
            based_on=None if run.verb or base.verb else run.based_on,
        )

    def fitted(self, row: Attempt) -> bool:
        """Whether `ours` of a row or of an attempt rests on a fitted parameter, its own or one of its runs'."""
        return row.fitted or any(self.resolved(name).fitted for name in (row.ours.runs() if row.ours else ()))

    def _chain(self, name: str) -> None:
        seen = [name]
        while (follow := self.runs[seen[-1]].based_on) is not None:
            self._known(follow, f"runs.{seen[-1]}.based_on")
            if follow in seen:
                raise ModelError("based on itself", path=f"runs.{follow}.based_on", given=" -> ".join([*seen, follow]))
            seen.append(follow)

    def _known(self, name: str, path: str) -> None:
        if name not in self.runs:
            allowed = ", ".join(self.runs) or "a table [runs.NAME]"
            raise ModelError("no such run", path=path, given=name, allowed=allowed)


def attempts(row: Row) -> tuple[Attempt, ...]:
    """The row's own number if it has one, then those of its readings, with their own tolerance or that of the row."""
    own = row.model_copy(update={"reading": row.reading or AS_PRINTED})
    tried: list[Attempt] = [] if row.ours is None and row.readings else [own]
    for one in row.readings:
        bounds = one if one.bounded else row
        changed: dict[str, Any] = {name: getattr(bounds, name) for name in ("tolerance", "relative", "because")}
        if one.run is not None and row.ours is not None:
            changed["ours"] = row.ours.with_run(one.run)
        tried.append(one.model_copy(update=changed))
    return tuple(tried)


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """Bounds of a published inequality or range [unit of the row]; one of them may be infinite."""

    low: float
    high: float
    strict: bool


def claim_of(text: str) -> Claim | None:
    """The inequality or range a text stands for; None where it is plain words."""
    infinite = float("inf")
    if found := _BOUND.fullmatch(text.strip()):
        sign, limit = found[1], float(found[2])
        low, high = (limit, infinite) if sign.startswith(">") else (-infinite, limit)
        return Claim(low=low, high=high, strict="=" not in sign)
    if found := _RANGE.fullmatch(text.strip()):
        return Claim(low=float(found[1]), high=float(found[2]), strict=False)
    return None


def _check_step(step: str, read: str | None) -> None:
    """Raise ModelError for a step that is no reduction."""
    words = step.split()
    known = (*_REDUCTIONS, *_PLACES, "only", "each")
    if not words or words[0] not in known or len(words) > 2:
        raise ModelError(f"no reduction {step!r}", allowed=", ".join(known) + "; each may name a dimension")
    if (words[0] in _PLACES) != (read is not None) and (words[0] in _PLACES or step == "only"):
        raise ModelError("argmax and argmin need `read`, and it needs them", allowed='reduce = "argmax", read = "..."')


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
        raise named(_as_model_error(error), file) from None
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
    return WrongRow(at=at, row=_legible(entry, path), error=named(wrong, file))


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


def named(error: ModelError, file: str) -> ModelError:
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
    """Keys of the table a place is in, those of it alone before those of every attempt."""
    tables: dict[str, type[BaseModel]] = {"ours": Value, "readings": SourceReading, "runs": Run, "rows": Row}
    table = next((one for key, one in tables.items() if key in loc[:-1]), Audit)
    return tuple(sorted(table.model_fields, key=lambda name: name not in table.__annotations__))
