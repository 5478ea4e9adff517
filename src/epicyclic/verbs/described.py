"""What `help(verb)` says: a signature of plain types, and a line for each keyword with its type, unit and default."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping
from inspect import Parameter, Signature
from typing import Any, ForwardRef, get_args, get_origin

_SOURCE = "source : name of a ready drive, model file, dict, Train or System."
_OVERRIDES = "overrides : path of the model file -> value; of a model, not of a Train or System."
_PROGRESS = "progress : called with the share done, 0..1."
_PLAIN = {"source": _SOURCE, "overrides": _OVERRIDES, "progress": _PROGRESS}
_WIDTH = 112  # of a docstring, behind its indent


Options = Mapping[str, tuple[Parameter, Any, Any]]


class _Type(str):
    """A type as one writes it; a signature shows it without quotes."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def type_words(kind: Any) -> str:
    """A type as one writes it, without modules."""
    if isinstance(kind, str | ForwardRef):
        text = kind if isinstance(kind, str) else kind.__forward_arg__
    else:
        text = str(kind) if get_origin(kind) or get_args(kind) else kind.__name__
    text = re.sub(r"\b(typing|collections\.abc|pathlib|types|epicyclic(\.\w+)*)\.", "", text)
    return re.sub(r"Optional\[(.*)\]$", r"\1 | None", text).replace("NoneType", "None")


def described(signature: Signature, doc: str, options: Options) -> tuple[Signature, str]:
    """Signature and docstring of a verb for people; the annotations of the function stay what checkers read.

    Parameters
    ----------
    options : keyword -> parameter, type and option, as of `record.keywords`.
    """
    parameters = []
    for name, one in signature.parameters.items():
        kind = options[name][1] if name in options else one.annotation
        parameters.append(one.replace(annotation=_Type(type_words(kind))))
    shown = signature.replace(parameters=parameters, return_annotation=_Type(type_words(signature.return_annotation)))
    return shown, _with_keywords(doc, shown, options)


def _with_keywords(doc: str, shown: Signature, options: Options) -> str:
    """The docstring with a line for each keyword that it says nothing of, in the section of parameters."""
    head, mark, rest = doc.partition("    Parameters\n    ----------\n")
    if not mark:
        head, raises, rest = doc.partition("    Raises\n    ------\n")
        head, rest = f"{head.rstrip()}\n\n", f"\n{raises}{rest}" if raises else ""
    said = set(re.findall(r"(?:^ {4}|[.;]  )(\w+) :", rest, re.MULTILINE))
    lines = [
        line
        for name, parameter in shown.parameters.items()
        if name not in said
        for line in _lines(name, parameter, options, list(shown.parameters))
    ]
    return f"{head}    Parameters\n    ----------\n{''.join(lines)}{rest}"


def _lines(name: str, parameter: Parameter, options: Options, names: list[str]) -> list[str]:
    if name not in options:
        text = _PLAIN.get(name, f"{name} : {parameter.annotation!r}.")
    else:
        option = options[name][2]
        default = option.default and f", default {option.default}"
        words = re.sub(r"--([a-z][a-z-]*)", lambda flag: _keyword(flag[1], names), option.help)
        text = f"{name} : {type_words(options[name][1])}{_bounds(option)}{default}. {words}"
    return [
        f"{line}\n"
        for line in textwrap.wrap(
            text,
            _WIDTH,
            initial_indent="    ",
            subsequent_indent="        ",
            break_long_words=False,
            break_on_hyphens=False,
        )
    ]


def _keyword(flag: str, names: list[str]) -> str:
    """Keyword of a flag; the flag itself where the verb has none of that name."""
    name = flag.replace("-", "_")
    return f"`{name}`" if name in names else f"--{flag}"


def _bounds(option: Any) -> str:
    parts = [] if option.least is None else [f"{option.least:g} or more"]
    parts += [] if option.most is None else [f"at most {option.most:g}"]
    parts += [] if option.above is None else [f"above {option.above:g}"]
    return f", {', '.join(parts)}" if parts else ""
