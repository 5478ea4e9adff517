"""Command of a verb: the signature of the verb's function, turned into one that typer reads."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from enum import StrEnum
from inspect import Parameter, Signature
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, ForwardRef, Literal, Union, get_args, get_origin

import typer

from ..verbs.record import Option, Verb, help_of, keywords
from .completion import model_names
from .output import FORMATS, figure_option
from .run import run_verb

__all__ = ["Json", "Model", "Output", "Sets", "command", "file_name"]


def file_name(text: str | Path) -> Path:
    """File that a person named, or a default; an empty text would be the folder here."""
    if not str(text).strip():
        raise typer.BadParameter("an empty name")
    return Path(text)


Model = Annotated[
    str,
    typer.Argument(
        metavar="MODEL",
        help="A model file (.toml), a REXS file (.rexs), or the name of a ready drive.",
        autocompletion=model_names,
    ),
]
Sets = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help="Put a value in place of the file's; may be repeated."),
]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON, xarray's Dataset.to_dict(), on stdout.")]
Output = Annotated[
    Path | None,
    typer.Option("-o", "--output", parser=file_name, metavar="FILE", help=f"Write the result: {FORMATS}."),
]


def command(verb: Verb) -> Callable[..., None]:
    """Function that runs a verb, with the signature, the name and the help that typer makes a command of."""
    shown = {name: entry for name, entry in keywords(verb.run).items() if entry[2].flag is not None}
    flags = {name: str(option.flag_of(name)) for name, (_, _, option) in shown.items()}

    def run(
        model: str,
        sets: list[str] | None,
        as_json: bool,
        output: Path | None,
        figure: list[str] | None = None,
        whole: bool = False,
        **given: Any,
    ) -> None:
        options = {name: _plain(value) for name, value in given.items() if value not in (None, [])}
        run_verb(
            verb, model, options, flags=flags, sets=sets, as_json=as_json, output=output, figures=figure, whole=whole
        )

    annotations: dict[str, Any] = {"model": Model}
    defaults: dict[str, Any] = {"model": Parameter.empty}
    for name, (parameter, kind, option) in shown.items():
        annotations[name], defaults[name] = _option(option, flags[name], kind, parameter.default)
    annotations |= {"sets": Sets, "as_json": Json, "figure": Annotated[list[str] | None, figure_option(verb.gives)]}
    annotations |= {"output": _output(verb)}
    defaults |= {"sets": None, "as_json": False, "figure": None, "output": None}
    run.__name__, run.__doc__, run.__annotations__ = verb.name, _unmarked(help_of(verb)), annotations
    run.__signature__ = Signature(  # type: ignore[attr-defined]
        [
            Parameter(name, Parameter.KEYWORD_ONLY, annotation=annotations[name], default=defaults[name])
            for name in annotations
        ]
    )
    return run


def _output(verb: Verb) -> Any:
    """The option ``-o`` of a verb, with its own kinds of files."""
    words = f"Write the result: {', '.join([*verb.writers, FORMATS])}."
    if verb.model_text:
        words = f"Write the model (.toml) or the result ({FORMATS})."
    made = typer.Option("-o", "--output", parser=file_name, metavar="FILE", help=words)
    return Annotated[Path | None, made]


def _option(option: Option, flag: str, kind: Any, default: Any) -> tuple[Any, Any]:
    """Annotation and default of one option; a default that nobody could type is shown and left to the verb."""
    typed = _type(kind)
    if typed is bool and default is not False:
        flag = f"{flag}/--no-{flag.removeprefix('--')}"
    left = default is not Parameter.empty and not isinstance(default, typed if isinstance(typed, type) else ())
    if isinstance(typed, type) and issubclass(typed, StrEnum) and isinstance(default, str):
        default, left = typed(default), False
    words = option.default or (_worded(default) if left and default is not None else "")
    number = {float: (_number, "number"), int: (_whole_number, "whole number")}.get(typed)
    made = typer.Option(
        flag,
        help=_unmarked(option.help),
        parser=None if number is None else number[0],  # its bounds are the verb's, which tells them in its own words
        metavar=option.metavar or (None if number is None else f"<{number[1]}{_range(option)}>"),
        show_default=words or default is not None,
    )
    return (Annotated[typed | None, made], None) if left else (Annotated[typed, made], default)


def _plain(value: Any) -> Any:
    """Value without the enumeration of typer: a word stays a plain text."""
    if isinstance(value, list):
        return [_plain(one) for one in value]
    return value.value if isinstance(value, StrEnum) else value


def _number(text: str) -> float:
    """Number that a person typed; a default is one already."""
    try:
        return float(text)
    except ValueError:
        raise typer.BadParameter(f"{text!r} is no number") from None


def _whole_number(text: str) -> int:
    """Whole number that a person typed; a default is one already."""
    try:
        return int(text)
    except ValueError:
        raise typer.BadParameter(f"{text!r} is no whole number") from None


def _range(option: Option) -> str:
    """Words of the bounds of an option; "" without any."""
    least, most = option.least, option.most
    if least is None:
        return "" if most is None else f", at most {most:g}"
    return f", {least:g} or more" if most is None else f", {least:g} to {most:g}"


def _worded(default: Any) -> str:
    return ", ".join(map(str, default)) if isinstance(default, tuple) else str(default)


def _type(kind: Any) -> Any:
    """What the command line reads for a type: a text where one can be typed, repeated ones for a sequence of them."""
    members = get_args(kind) if get_origin(kind) in (Union, UnionType) else (kind,)
    entries = [get_args(one)[0] for one in members if get_origin(one) is Sequence]
    for entry in entries:
        if entry is str or get_origin(entry) is Literal:
            return list[_type(entry)]  # type: ignore[misc]
    if any(one is str or isinstance(one, str | ForwardRef) for one in members):
        return str
    (only,) = (one for one in members if one is not NoneType)
    return StrEnum("Choice", [(word, word) for word in get_args(only)]) if get_origin(only) is Literal else only


def _unmarked(text: str) -> str:
    """A text without markup of rich: [rad] is a unit, [tolerance] a table."""
    return re.sub(r"\[(?=[a-z])", r"\\[", text)
