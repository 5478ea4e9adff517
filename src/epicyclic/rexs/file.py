"""A REXS file as plain data: components with attributes, the relations between them, load cases.  No meaning yet.

Its names are asked of every model, before any module that reads XML is imported.  The values are the same from XML and
from JSON: texts, arrays and matrices in Base64.  A file has bounds of size, depth and count, so that none costs long or
much memory.
"""

from __future__ import annotations

import base64
import binascii
import math
import re
import sys
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import ModelError

# A gear unit of 100 components is 0.1 MB; 16 MB leaves room for long load spectra and is parsed in a few seconds.
MAX_BYTES = 16_000_000
# Tags, attributes of tags, braces and keys: each becomes an object of up to 400 bytes. A file then stays below
# 250 MB and 3 s.
MAX_MARKS = 400_000
# model / load_spectrum / load_case / component / attribute / matrix / r / c is 8 deep.
MAX_DEPTH = 16
# The real files shrink to 1/17; a file of nothing but blanks and repeated tags to about 1/100.
MAX_RATIO = 300
# Names and texts: longer ones say nothing that a model file could carry.
MAX_TEXT = 2_000


SUFFIXES = (".rexs", ".rexsj", ".rexsz", ".rexs.xml", ".rexs.json", ".rexs.zip")


def is_rexs_name(name: str | Path) -> bool:
    """Whether a file is a REXS file by its name."""
    return str(name).lower().endswith(SUFFIXES)


Value = float | int | bool | str | tuple["Value", ...] | None
"""Value of an attribute: scalar, tuple (array), tuple of tuples (matrix, array of arrays); None where it is empty."""


@dataclass(frozen=True, slots=True)
class Attribute:
    """A value of a component, in the unit beside it.

    id : name by the standard, ``normal_module``.
    value : in `unit`, as the file has it.
    unit : as the file spells it, ``"N / (mm mum)"``; ``"none"`` or empty without one.
    """

    id: str
    value: Value
    unit: str = "none"


@dataclass(frozen=True, slots=True)
class Component:
    """A part, a stage, a load, a material: whatever has attributes.

    id : its number in the file.  type : of the standard, ``cylindrical_gear``.  name : free text.
    attributes : by their id, in the order of the file.
    """

    id: int
    type: str
    name: str = ""
    attributes: Mapping[str, Attribute] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Relation:
    """A statement about components.

    id : its number in the file.  type : of the standard, ``side``.  order : of ordered relations, else None.
    refs : (role, id of the component), in the order of the file.
    """

    id: int
    type: str
    order: int | None
    refs: tuple[tuple[str, int], ...]

    def part(self, role: str) -> int | None:
        """Id of the first component in a role, None where there is none."""
        return next((part for name, part in self.refs if name == role), None)


@dataclass(frozen=True, slots=True)
class LoadCase:
    """A load case of a load spectrum: attributes that stand in place of those of the components, or beside them.

    id : its number in the file.  components : those with attributes of their own here.
    """

    id: int
    components: tuple[Component, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class RexsFile:
    """A REXS file, read.

    version : ``"1.7"``, ``"2.0.0"``.  application, application_version, date : as the file says.
    components : in the order of the file, each id once.  relations : in the order of the file.
    load_cases : of all load spectra.  accumulations : attributes over a whole load spectrum.
    encoding : ``"xml"`` or ``"json"``.  notes : what the reader left out, in words.
    """

    version: str
    components: tuple[Component, ...]
    relations: tuple[Relation, ...]
    application: str = ""
    application_version: str = ""
    date: str = ""
    load_cases: tuple[LoadCase, ...] = ()
    accumulations: tuple[Component, ...] = ()
    encoding: str = "xml"
    notes: tuple[str, ...] = ()


# what XML and JSON may hold and a model file may not: control characters, and halves of surrogate pairs
_UNSAFE = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff]+")
_INTEGER = re.compile(r"[+-]?[0-9]{1,18}")
_FLOAT = re.compile(r"[+-]?(?:[0-9]{1,400}(?:\.[0-9]{0,400})?|\.[0-9]{1,400})(?:[eE][+-]?[0-9]{1,6})?")
# attributes that are names even where a name is all digits: a material 1.6580 is not 1.658
_NAMES = re.compile(r"(?:^|_)(?:name|designation|manufacturer|description|comment|remark|number_of_drawing)(?:_|$)")
# code of an array -> type code of the standard library's arrays
_CODES = {"float64": "d", "float32": "f", "int32": "i"}


def plain_text(text: str) -> str:
    """A text without control characters, on one line, of bounded length."""
    return _UNSAFE.sub(" ", text).strip()[:MAX_TEXT]


def text_value(text: str, attribute: str) -> Value:
    """Value of the text of an attribute; None where it is blank.

    In XML every value is a text, so that a text which reads as a number or truth value is one.  A number that is not
    finite stays a text: nothing computes with it by accident.
    """
    stripped = plain_text(text)
    if not stripped:
        return None
    if _NAMES.search(attribute):
        return stripped
    if stripped in ("true", "false"):
        return stripped == "true"
    if _INTEGER.fullmatch(stripped):
        return int(stripped)
    if _FLOAT.fullmatch(stripped) and math.isfinite(number := float(stripped)):
        return number
    return stripped


def scalar(value: object, attribute: str) -> Value:
    """Value of a scalar of JSON: texts as in XML, numbers too large for a float as texts.

    Raises
    ------
    ModelError : a list or table where a scalar stands.
    """
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str):
        return text_value(value, attribute)
    if isinstance(value, int):
        return value if abs(value) < 10**18 else _finite(float(value) if abs(value) < 10**300 else math.inf)
    if isinstance(value, float):
        return _finite(value)
    raise ModelError("a list or table where one value stands", path=attribute, given=type(value).__name__)


def _finite(number: float) -> Value:
    """A number, or its text where it is infinite or nan."""
    return number if math.isfinite(number) else repr(number)


def decoded(code: object, text: object, shape: tuple[object, object] | None, attribute: str) -> Value:
    """Numbers of an array or matrix in Base64, little-endian.

    Parameters
    ----------
    code : ``float64``, ``float32`` or ``int32``.  text : the Base64.
    shape : of a matrix its rows and columns, each None where not given: it is square then.  None for an array.
    attribute : its id, for an error.

    Raises
    ------
    ModelError : another code, no Base64, a number of bytes that does not fit.
    """
    allowed = f"code {', '.join(_CODES)} with Base64 text"
    if not isinstance(code, str) or code not in _CODES:
        raise ModelError("an array in an unknown code", path=attribute, given=code, allowed=allowed)
    if not isinstance(text, str):
        raise ModelError("no Base64 text", path=attribute, given=text, allowed=allowed)
    try:
        raw = base64.b64decode("".join(text.split()), validate=True)
    except (binascii.Error, ValueError):
        raise ModelError("no Base64", path=attribute, given=text[:40], allowed=allowed) from None
    numbers = array(_CODES[code])
    if len(raw) % numbers.itemsize:
        problem = f"{len(raw)} bytes are no whole number of values of {code}"
        raise ModelError(problem, path=attribute, allowed=f"a multiple of {numbers.itemsize} bytes")
    numbers.frombytes(raw)
    if sys.byteorder == "big":
        numbers.byteswap()
    values = tuple(_finite(n) if isinstance(n, float) else n for n in numbers)
    return values if shape is None else _matrix(values, shape, attribute)


def _matrix(values: Sequence[Value], shape: tuple[object, object], attribute: str) -> Value:
    """Values in rows. Raises ModelError where they do not fill them."""
    rows, columns = (_whole(size) for size in shape)
    if rows is None and columns is None:
        rows = columns = math.isqrt(len(values))
    elif columns is None:
        columns = len(values) // rows if rows else 0
    elif rows is None:
        rows = len(values) // columns if columns else 0
    # rows without columns would fit no values, a thousand million of them too
    counts = () if rows is None or columns is None else (rows, columns)
    if not counts or min(counts) < 0 or max(counts) > len(values) or math.prod(counts) != len(values):
        problem = f"{len(values)} values do not fill the matrix"
        raise ModelError(problem, path=attribute, given=list(shape), allowed="rows and columns that fit")
    height, width = counts
    return tuple(tuple(values[row * width : (row + 1) * width]) for row in range(height))


def _whole(size: object) -> int | None:
    """A count of rows or columns, written as number or text; None where it is not given."""
    if size is None:
        return None
    if isinstance(size, str) and _INTEGER.fullmatch(size.strip()):
        return int(size)
    return size if isinstance(size, int) and not isinstance(size, bool) else -1
