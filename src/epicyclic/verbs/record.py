"""Record of a verb: the plain typed function is the declaration, its annotations carry what a command line needs.

    def modes(source, *, overrides=None, damped: Annotated[bool, Option("Solve the damped problem.")] = False): ...
    VERB = Verb(run=modes, gives=("modes",))

Annotations of a verb are evaluated when its file is imported, so types of heavy rooms stand in quotes and heavy rooms
are imported inside the function.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, wraps
from importlib import import_module
from inspect import Parameter, signature
from math import isfinite
from numbers import Real
from pkgutil import iter_modules
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, cast, get_args, get_origin

from ..arguments import check_arguments
from ..errors import ModelError
from .described import described

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
    """Name -> record of every file of this folder that has one, in alphabetical order."""
    folder = __name__.rpartition(".")[0]
    modules = [import_module(f"{folder}.{found.name}") for found in iter_modules(import_module(folder).__path__)]
    records = [cast(Verb, module.VERB) for module in modules if hasattr(module, "VERB")]
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
