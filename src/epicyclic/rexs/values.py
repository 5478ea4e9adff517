"""Texts and Base64 of a REXS file as values: the same value from XML and from JSON."""

from __future__ import annotations

import base64
import binascii
import math
import re
import sys
from array import array
from collections.abc import Sequence

from ..errors import ModelError
from .limits import MAX_TEXT
from .structure import Value

__all__ = ["decoded", "plain_text", "scalar", "text_value"]

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
