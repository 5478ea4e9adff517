"""Docstrings and signatures of the package, as Sphinx wants them.

The docstrings are plain text: `name` is a name, sections are underlined, an entry is "name : meaning", and what stands
on goes into the next line indented.
"""

from __future__ import annotations

import inspect
import re
from typing import Annotated, Any, ForwardRef, get_args, get_origin

__all__ = ["WITHOUT_PAGE", "as_restructured_text", "signature_text", "type_text"]

WITHOUT_PAGE = (
    r"((xr|np|go|numpy|xarray|plotly|pathlib|collections|typing|types)\.?.*|Path|Source|Overrides|Array|Progress|Any|"
    r"Datasets|Mapping|Sequence|Callable|Iterable|Literal|Fraction|NDArray|factory|optional|object|property|"
    r"[A-Z]\w+|\w+Error|[a-z_]+\.[\w.]+)"
)
_MARKUP = re.compile(r"(``.+?``|`[^`]+`)")
_PAGE = re.compile(r"\bdocs/([\w/-]+)\.md\b")
_SPECIAL = re.compile(r"([\\*|]|_(?=\W|$))")


def as_restructured_text(_app: Any, _what: str, _name: str, _obj: Any, _options: Any, lines: list[str]) -> None:
    """Replace the lines of a docstring by reStructuredText."""
    lines[:] = _paragraphs(lines)


def _paragraphs(lines: list[str]) -> list[str]:
    made: list[str] = []
    rest = [line.rstrip() for line in lines]
    while rest:
        line, *rest = rest
        entry = re.match(r"(\S[^.]*?) : (.*)", line)
        if rest and rest[0] and not rest[0].strip("-"):
            made, rest = [*made, "", f"**{line}**", ""], rest[1:]
        elif entry is not None:
            item, rest = _taken(rest)
            text = " ".join([entry[2], *(one.strip() for one in item)])
            made += ["", f"- {_names(entry[1])}: {_escaped(text)}", ""]
        elif line.startswith("    ") and made[-1:] == [""]:
            block, rest = _taken(rest)
            made += ["::", "", line, *block, ""]
        else:
            made.append(_escaped(line.strip()))
    return made


def _taken(lines: list[str]) -> tuple[list[str], list[str]]:
    """Indented lines at the beginning, and what follows them."""
    count = next((place for place, line in enumerate(lines) if not line.startswith("    ")), len(lines))
    return lines[:count], lines[count:]


def _names(text: str) -> str:
    return text if "`" in text else f"``{text.strip()}``"


def _escaped(text: str) -> str:
    """Plain text with names in backticks; an asterisk or a bar is what it is."""
    parts = _MARKUP.split(text)
    for place, part in enumerate(parts):
        if place % 2 == 0:
            parts[place] = _PAGE.sub(r":doc:`/\1`", _SPECIAL.sub(r"\\\1", part))
        elif not part.startswith("``"):
            parts[place] = f"`{part}`"
    return "".join(parts)


def signature_text(_app: Any, what: str, _name: str, obj: Any, _options: Any, given: str | None, _result: str) -> Any:
    """Return the signature with the plain types of the keywords; the pages of verbs have their meaning."""
    if given is None or what not in ("function", "class", "method", "exception"):
        return None
    if what in ("class", "exception"):
        return "", ""  # results of `load` and `assemble`, and errors: nobody builds them by hand
    signature = inspect.signature(obj)
    plain = [_plain(one) for one in signature.parameters.values()]
    returned = signature.return_annotation
    back = "" if returned is inspect.Signature.empty else type_text(returned)
    return str(signature.replace(parameters=plain, return_annotation=inspect.Signature.empty)), back


class _Typed:
    """A type as text that `inspect` prints without quotes."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text


def _plain(parameter: inspect.Parameter) -> inspect.Parameter:
    default = parameter.default
    if callable(default) and default is not inspect.Parameter.empty:
        default = _Typed(default.__name__)
    if parameter.annotation is inspect.Parameter.empty:
        return parameter.replace(default=default)
    return parameter.replace(annotation=_Typed(type_text(parameter.annotation)), default=default)


def type_text(kind: Any) -> str:
    """A type as one writes it, without modules and notes."""
    if get_origin(kind) is Annotated:
        kind = get_args(kind)[0]
    if isinstance(kind, ForwardRef):
        text = kind.__forward_arg__
    elif isinstance(kind, str):
        text = kind
    else:
        text = str(kind) if get_origin(kind) or get_args(kind) else getattr(kind, "__name__", str(kind))
    text = re.sub(r"Optional\[(.*)\]$", r"\1 | None", text.replace("typing.", ""))
    return re.sub(r"\b(collections\.abc|pathlib|types)\.", "", text).replace("NoneType", "None")
