"""Record of a verb: the plain typed function is the declaration, its annotations carry what a command line needs.

    def modes(source, *, overrides=None, damped: Annotated[bool, Option("Solve the damped problem.")] = False): ...
    VERBS = (Verb(run=modes, gives=("modes",)),)

Annotations of a verb are evaluated when its module is imported, so types of heavy rooms stand in quotes and heavy rooms
are imported inside the function.  `help(verb)` shows a signature of plain types, and a line for each keyword with its
type, unit and default.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, wraps
from importlib import import_module
from importlib.util import find_spec
from inspect import Parameter, Signature, signature
from math import isfinite
from numbers import Real
from pkgutil import iter_modules
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ForwardRef, TypeVar, cast, get_args, get_origin

from ..errors import ModelError
from ..user_input import check_arguments

if TYPE_CHECKING:
    from pathlib import Path

    import xarray as xr

Progress = Callable[[float], None]
"""Called with the share done, 0..1."""

Run = TypeVar("Run", bound=Callable[..., Any])


@dataclass(frozen=True, slots=True, repr=False)
class Option:
    """What help, documentation and command line say of a keyword.

    help : one sentence.  flag : of the command line; empty: the keyword with dashes; None: keyword of Python alone.
    least, most : bounds of a number, above : what it must be above.
    default : in words, where the default is None.  metavar : of the value.
    """

    help: str
    flag: str | None = ""
    least: float | None = None
    most: float | None = None
    above: float | None = None
    default: str = ""
    metavar: str = ""

    def __repr__(self) -> str:
        """The help alone: `help(verb)` shows it beside the type."""
        return repr(self.help)

    def flag_of(self, keyword: str) -> str | None:
        """Flag of a keyword; None where it has none."""
        return f"--{keyword.replace('_', '-')}" if self.flag == "" else self.flag


@dataclass(frozen=True, slots=True, kw_only=True)
class Verb:
    """One verb.

    run : source and keywords -> Dataset.  gives : kinds of result, values of the attribute `verb` of the Dataset.
    drawing : whether the source must have its drawing; a System will not do.
    in_report : place in the order in which a report runs verbs; 0: not part of a report.
    examples : keywords of short runs of a ready drive, which give each of the kinds; pages and tests take them.
    model_text : text of a model file made of a result, where the verb proposes a model.
    writers : suffix -> function that writes a result to such a file, beside the formats of all results.
    """

    run: Callable[..., xr.Dataset]
    gives: tuple[str, ...]
    drawing: bool = False
    in_report: int = 0
    examples: tuple[Mapping[str, Any], ...] = (MappingProxyType({}),)
    model_text: Callable[[xr.Dataset], str] | None = None
    writers: Mapping[str, Callable[[xr.Dataset, Path], Path]] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        """Give the function the signature and docstring that `help` shows; annotations stay as they are written."""
        if "__signature__" not in vars(self.run):
            shown, doc = described(signature(self.run), self.run.__doc__ or "", keywords(self.run))
            vars(self.run).update(__signature__=shown)
            self.run.__doc__ = doc

    @property
    def name(self) -> str:
        """Name of the verb in Python; with dashes that of the command."""
        return self.run.__name__


@cache
def verbs() -> Mapping[str, Verb]:
    """Name -> record of every verb, in alphabetical order; those of a question stand in its module `verbs`."""
    questions = import_module("..questions", __package__)
    rooms = ("statics", *(f"questions.{room.name}" for room in iter_modules(questions.__path__)))
    homes = [f"..{room}.verbs" for room in rooms if find_spec(f"..{room}.verbs", __package__)]
    records: list[Verb] = [record for home in homes for record in import_module(home, __package__).VERBS]
    return {record.name: record for record in sorted(records, key=lambda record: record.name)}


def keywords(run: Callable[..., Any]) -> dict[str, tuple[Parameter, Any, Option]]:
    """Keyword -> parameter, type and option of every keyword of a verb that has an option."""
    found = {}
    for name, parameter in signature(run).parameters.items():
        annotation = run.__annotations__.get(name)
        if get_origin(annotation) is Annotated:
            kind, option = get_args(annotation)
            found[name] = parameter, kind, option
    return found


def help_of(verb: Verb) -> str:
    """The paragraphs of a verb's docstring before its sections."""
    paragraphs = (verb.run.__doc__ or "").split("\n\n")
    return "\n\n".join(" ".join(text.split()) for text in paragraphs if "\n    ----" not in text)


def bounded(run: Run) -> Run:
    """Let a verb refuse arguments of other types and numbers that are not finite or outside the bounds of their option.

    Raises
    ------
    ModelError : such an argument, before any work; of the verb.
    """

    @wraps(run)
    def within(*arguments: Any, **options: Any) -> Any:
        check_arguments(run, arguments, options)
        for name, (_, _, option) in keywords(run).items():
            _check_bounds(name, options.get(name), option)
        return run(*arguments, **options)

    return cast(Run, within)


def _check_bounds(name: str, value: object, option: Option) -> None:
    """Raise ModelError where a value is a number outside the bounds of its option."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return
    number, least, most = float(value), option.least, option.most
    if not isfinite(number) or (least is not None and number < least) or (most is not None and number > most):
        low = "" if least is None else f"{least:g} or more" if most is None else f"{least:g} to {most:g}"
        high = f"at most {most:g}" if least is None and most is not None else ""
        raise ModelError("out of range", path=name, given=value, allowed=low or high or "a finite number")
    if (option.above is not None) and number <= option.above:
        raise ModelError("out of range", path=name, given=value, allowed=f"above {option.above:g}")


def given(**options: Any) -> dict[str, Any]:
    """The options that are not None, so that the default of the others is that of the analysis."""
    return {name: value for name, value in options.items() if value is not None}


def refuse_without(condition: bool, words: str, **options: object) -> None:
    """Refuse options that mean nothing without a condition.

    Raises
    ------
    ModelError : one of the options is not None and the condition does not hold.
    """
    if not condition:
        for name, value in given(**options).items():
            raise ModelError(f"goes with {words}", path=name, given=value)


def require_folder(resume: bool, folder: object) -> None:
    """Refuse to go on from nowhere.

    Raises
    ------
    ModelError : a run is to go on, and no folder is given.
    """
    if resume and folder is None:
        raise ModelError("needs the file of the run that was stopped", path="resume", allowed="-o FILE.nc, or folder")


# --- what help says --------------------------------------------------------------------------------------------------

_SOURCE = "source : name of a ready drive, model file, dict, Train or System."
_OVERRIDES = "overrides : path of the model file -> value; of a model, not of a Train or System."
_PROGRESS = "progress : called with the share done, 0..1."
_PLAIN = {"source": _SOURCE, "overrides": _OVERRIDES, "progress": _PROGRESS}
_WIDTH = 112  # of a docstring, behind its indent
Options = Mapping[str, tuple[Parameter, Any, Option]]


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
    options : keyword -> parameter, type and option, as of `keywords`.
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


def _bounds(option: Option) -> str:
    parts = [] if option.least is None else [f"{option.least:g} or more"]
    parts += [] if option.most is None else [f"at most {option.most:g}"]
    parts += [] if option.above is None else [f"above {option.above:g}"]
    return f", {', '.join(parts)}" if parts else ""
