"""Record of a verb: what computes it, and the dataclass of its options, whose fields are the keywords of all that asks.

    @dataclass(frozen=True, slots=True, kw_only=True)
    class ModesOptions:
        damped: Annotated[bool, Option("Solve the damped problem.")] = False

    @takes(ModesOptions)
    def modes(drive, options): ...

    VERBS = (Verb(run=modes, gives=("modes",)),)

Annotations are evaluated when a module is imported, so types of heavy rooms stand in quotes, and heavy rooms are
imported inside the function.  `help(verb)` shows a signature of plain types, and a line for each keyword with its type,
unit and default.  All verbs that a model allows run for a report.
"""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields
from difflib import get_close_matches
from functools import cache, partial, wraps
from importlib import import_module
from importlib.util import find_spec
from inspect import Parameter, Signature, signature
from math import isfinite
from numbers import Real
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ForwardRef, get_args, get_origin

from ..errors import ConvergenceError, ModelError
from ..options import ALL_CASES, Option, option_fields, shape_of
from ..questions import ROOMS
from ..user_input import check_arguments
from ..warning_codes import CodedText, coded, placed

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.run_folder import RunFolder
    from ..engine.source import Overrides, Source
    from ..system.system import System
    from ..train.train import Train

Analysis = Callable[..., "xr.Dataset"]
RESPONSE = "equations inertia damping speed balance"
"""What a train must have for its linear response."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Verb:
    """One verb.

    run : source and keywords -> Dataset.  gives : kinds of result, values of the attribute `verb` of the Dataset.
    question : the one of the help of all commands that it answers.  line : what it does, in a line below it.
    needs : what a train must have, names of methods of `Readiness` in questions/check/check.py; options may need less
    (``sharing --method static``) or more.
    drawing : whether the source must have its drawing; a System will not do.
    in_report : place in the order in which a report runs verbs; 0: not part of a report.
    examples : keywords of short runs of a ready drive, which give each of the kinds; pages and tests take them.
    model_text : text of a model file made of a result, where the verb proposes a model.
    writers : suffix -> function that writes a result to such a file, beside the formats of all results; what it returns
    may have what is not carried, `dropped`.
    reads : what its source is, where that is no model.
    """

    run: Callable[..., xr.Dataset]
    gives: tuple[str, ...]
    question: str
    line: str
    needs: str = ""
    drawing: bool = False
    in_report: int = 0
    examples: tuple[Mapping[str, Any], ...] = (MappingProxyType({}),)
    model_text: Callable[[xr.Dataset], str] | None = None
    writers: Mapping[str, Callable[[xr.Dataset, Path], object]] = field(default_factory=lambda: MappingProxyType({}))
    reads: str = ""

    @property
    def name(self) -> str:
        """Name of the verb in Python; with dashes that of the command."""
        return self.run.__name__


def model_in(attribute: str) -> Callable[[xr.Dataset], str]:
    """`Verb.model_text` of a verb whose results hold the document of the model in an attribute, as JSON."""

    def text(result: xr.Dataset) -> str:
        """The model file (TOML)."""
        from ..document.writer import model_text

        return model_text(json.loads(str(result.attrs[attribute])))

    return text


@cache
def verbs() -> Mapping[str, Verb]:
    """Name -> record of every verb whose source is a model, in alphabetical order."""
    return {name: record for name, record in records().items() if not record.reads}


@cache
def records() -> Mapping[str, Verb]:
    """Name -> record of every verb, in alphabetical order; those of a question stand in its module `verbs`."""
    homes = [f"..{room}.verbs" for room in ("statics", *ROOMS) if find_spec(f"..{room}.verbs", __package__)]
    found: list[Verb] = [record for home in homes for record in import_module(home, __package__).VERBS]
    return {record.name: record for record in sorted(found, key=lambda record: record.name)}


Options = Mapping[str, tuple[Any, Any, Option]]
"""Keyword -> default, `Parameter.empty` of what must be given, type and option."""


def keywords(run: Callable[..., Any]) -> dict[str, tuple[Any, Any, Option]]:
    """`Options` of a verb: every keyword that has an option."""
    return {
        name: (parameter.default, *get_args(annotation))
        for name, parameter in signature(run).parameters.items()
        if get_origin(annotation := run.__annotations__.get(name)) is Annotated
    }


def command_words(known: Options, values: Mapping[str, Any]) -> list[str]:
    """Words of the command line that give keywords these values; of None there are none."""
    words: list[str] = []
    for name, value in given(**values).items():
        default, kind, option = known[name]
        flag = str(option.flag_of(name))
        if isinstance(value, bool):
            no = [] if default is False else [f"--no-{flag.removeprefix('--')}"]
            words += [flag] if value else no
        elif isinstance(value, Mapping):
            words += [word for key, one in value.items() for word in (flag, f"{key}={one}")]
        elif isinstance(value, Sequence) and not isinstance(value, str):
            texts = [f"{one:.12g}" if isinstance(one, float) else str(one) for one in value]
            entries = texts if shape_of(kind).several else [", ".join(texts)]
            words += [word for entry in entries for word in (flag, entry)]
        else:
            words += [flag, f"{value:.12g}" if isinstance(value, float) else str(value)]
    return words


def help_of(verb: Verb) -> str:
    """The paragraphs of a verb's docstring before its sections."""
    paragraphs = (verb.run.__doc__ or "").split("\n\n")
    return "\n\n".join(" ".join(text.split()) for text in paragraphs if "\n    ----" not in text)


def takes(
    options: type[Any] | None = None, *, turning: bool = False, joint: bool = False
) -> Callable[[Analysis], Analysis]:
    """Make the public function of a verb of the function that computes it and the dataclass of its options.

    turning : whether it is of a train that turns, and refuses one that is locked.  joint : whether it takes all load
    cases together (`cases.duty_of`), not one by one.

    The function that computes takes a `Drive`, the options where there are any, and ``progress`` where it has one.  The
    public one takes a source, overrides, the fields of the options as keywords, and ``progress``: it refuses arguments
    of other types, and numbers that are not finite or outside the bounds of their option, before any work, and reads
    what stands in place of the value of a field.
    """

    def public(compute: Analysis) -> Analysis:
        plain = _public_signature(compute, options)
        reports = "progress" in plain.parameters

        @wraps(compute)
        def run(*arguments: Any, **keywords_given: Any) -> xr.Dataset:
            try:  # what is wrong is told before what is missing
                bound = plain.bind_partial(*arguments, **keywords_given).arguments
                check_arguments(run, (), bound)
                plain.bind(*arguments, **keywords_given)
            except TypeError as error:
                raise TypeError(f"{compute.__name__}() {error}{_meant(str(error), plain)}") from None
            for name, (_, _, option) in known.items():
                _check_bounds(name, bound.get(name), option)
            from ..engine.source import Drive
            from .options import READERS

            if (bound.get("overrides") or {}).get("case") == ALL_CASES and not joint:
                from .cases import over_cases

                return over_cases(run, bound.pop("source"), bound.pop("overrides"), bound)
            drive = Drive(bound.pop("source"), bound.pop("overrides", None))
            more = {"progress": bound.pop("progress", None)} if reports else {}
            values = {name: value for name, value in bound.items() if value is not None}
            if turning:
                drive.system.require_turning()
            for name, (_, _, option) in known.items():
                if option.reads and name in values:
                    values[name] = READERS[option.reads](values[name], name, drive, option)
                    _check_bounds(name, values[name], option)
            try:
                return compute(drive, *([] if options is None else [options(**values)]), **more)
            except ModelError as error:
                typed = bound.get(error.path)
                if isinstance(typed, str) and known[error.path][2].reads:  # what was typed, not what was read of it
                    raise ModelError(error.problem, path=error.path, given=typed, allowed=error.allowed) from None
                raise

        vars(run).update(joint=joint)
        run.__annotations__ = {name: one.annotation for name, one in plain.parameters.items()}
        run.__annotations__["return"] = plain.return_annotation
        vars(run).update(__signature__=plain)
        known = keywords(run)
        shown, run.__doc__ = described(plain, compute.__doc__ or "", known)
        vars(run).update(__signature__=shown)
        return run

    return public


def _public_signature(compute: Analysis, options: type[Any] | None) -> Signature:
    """Source, overrides, the fields of the options, and ``progress`` where the function that computes has one."""

    def keyword(name: str, annotation: Any, default: Any = None) -> Parameter:
        return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)

    declared = {} if options is None else option_fields(options)
    parameters = [
        Parameter("source", Parameter.POSITIONAL_OR_KEYWORD, annotation="Source"),
        keyword("overrides", "Overrides | None"),
        *(
            keyword(name, Annotated[option.accepted(kind), option], Parameter.empty if default is MISSING else default)
            for name, (default, kind, option) in declared.items()
        ),
    ]
    if "progress" in compute.__annotations__:
        parameters.append(keyword("progress", compute.__annotations__["progress"]))
    return Signature(parameters, return_annotation="xr.Dataset")


def _meant(problem: str, known: Signature) -> str:
    """``; did you mean 'points'?`` behind what is said of an unknown keyword; "" where none is alike."""
    unknown = re.search(r"unexpected keyword argument '(\w+)'", problem)
    alike = get_close_matches(unknown[1], known.parameters, n=1, cutoff=0.7) if unknown else []
    return f"; did you mean {alike[0]!r}?" if alike else ""


def _check_bounds(name: str, value: object, option: Option) -> None:
    """Raise ModelError where a value, or an entry of a list, is a number outside the bounds of its option."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, list | tuple):
        for entry in value:
            _check_bounds(name, entry, option)
        return
    if isinstance(value, bool) or not isinstance(value, Real):
        return
    number, least, most, above = float(value), option.least, option.most, option.above
    below = (least is not None and number < least) or (above is not None and number <= above)
    if not isfinite(number) or below or (most is not None and number > most):
        raise ModelError("out of range", path=name, given=value, allowed=option.range or "a finite number")


def given(**options: Any) -> dict[str, Any]:
    """The options that are not None, so that the default of the others is that of the analysis."""
    return {name: value for name, value in options.items() if value is not None}


def nondefault(options: Any, *names: str) -> dict[str, Any]:
    """Those of the named options of a dataclass that differ from their default."""
    default = {one.name: one.default for one in fields(options)}
    return {name: value for name in names if (value := getattr(options, name)) != default[name]}


def recorded_options(options: Any) -> dict[str, Any]:
    """Field -> value of the options that tell one run from another: all but those that say where it is kept."""
    names = [one.name for one in fields(options) if one.name not in ("folder", "resume")]
    return {name: getattr(options, name) for name in names}


def refuse_without(condition: bool, words: str, **options: object) -> None:
    """Refuse options that mean nothing without a condition.

    Raises
    ------
    ModelError : one of the options is not None and the condition does not hold.
    """
    if not condition:
        for name, value in given(**options).items():
            raise ModelError(f"goes with {words}", path=name, given=value)


def check_range(options: Any) -> None:
    """Refuse a range of speeds beside both of its ends, and ends beside speeds of one's own.

    options : with start, stop, range, mesh_frequency and relative_speed.

    Raises
    ------
    ModelError : one of them, by its name.
    """
    refuse_without(options.start is None or options.stop is None, "at most one end of its own", range=options.range)
    if options.start is not None or options.stop is not None:
        own = {"mesh_frequency": options.mesh_frequency, "relative_speed": options.relative_speed}
        refuse_without(False, "neither start nor stop", **own)


# --- what help says --------------------------------------------------------------------------------------------------

_SOURCE = "source : name of a ready drive, model file, dict, Train or System."
_OVERRIDES = "overrides : path of the model file -> value; of a model, not of a Train or System."
_PROGRESS = "progress : called with the share done, 0..1."
_PLAIN = {"source": _SOURCE, "overrides": _OVERRIDES, "progress": _PROGRESS}
# of a docstring, behind its indent
_WRAPPER = textwrap.TextWrapper(
    112, initial_indent="    ", subsequent_indent="        ", break_long_words=False, break_on_hyphens=False
)


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
    options : as of `keywords`.
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
    entries = [_entry(name, one, options, shown) for name, one in shown.parameters.items() if name not in said]
    return f"{head}    Parameters\n    ----------\n{''.join(entries)}{rest}"


def _entry(name: str, parameter: Parameter, options: Options, shown: Signature) -> str:
    if name not in options:
        text = _PLAIN.get(name, f"{name} : {parameter.annotation!r}.")
    else:
        option = options[name][2]
        bounds, default = option.range and f", {option.range}", option.default and f", default {option.default}"
        words = re.sub(r"--([a-z][a-z-]*)", lambda flag: _keyword(flag[1], shown), option.help)
        text = f"{name} : {type_words(options[name][1])}{bounds}{default}. {words}"
    return f"{_WRAPPER.fill(text)}\n"


def _keyword(flag: str, shown: Signature) -> str:
    """Keyword of a flag; the flag itself where the verb has none of that name."""
    name = flag.replace("-", "_")
    return f"`{name}`" if name in shown.parameters else f"--{flag}"


STUDIES = ("support stiffness", "run-out")
TO_MODES = "sweep to the modes"
# Speeds of the sweeps of a report, about operation and to the modes: with several mesh frequencies, whose balance takes
# 20 ms a speed and more, a second each.
_POINTS, _POINTS_OF_MANY_TONES = (200, 200), (40, 25)
# Points of a curve over support stiffness and over run-out, a point taking up to a tenth of a second: bends still show.
_STUDY_POINTS = (7, 4)
# Error of loads and pressures that the tooth contact of a report is refined to; the page says what is left.  The verb
# itself goes to a hundredth, which takes half a minute where the teeth are finely relieved.
_CONTACT = 0.05
# Samples of tolerances in a report: quantiles to some thousandths, with what buys what in a second.
_SAMPLES = 2**13
# Places in the mesh cycle and trains drawn of the gearbox at its output, in a second and a half: quantiles to some
# hundredths.
_OUTPUT = {"phases": 4, "samples": 2**8}


def report_verbs() -> tuple[str, ...]:
    """Names of the verbs of a report, in the order in which they run."""
    shown = [verb for verb in verbs().values() if verb.in_report]
    return tuple(verb.name for verb in sorted(shown, key=lambda verb: verb.in_report))


def report_sections() -> tuple[str, ...]:
    """Names of what a report computes, as `run_report` takes them in ``sections``."""
    return tuple(_section(name) for name in (*report_verbs(), TO_MODES, *STUDIES))


def _section(name: str) -> str:
    """A name without spaces: ``sweep-to-the-modes``."""
    return name.replace(" ", "-").replace("_", "-")


def run_report(
    source: Source,
    *,
    overrides: Overrides | None = None,
    sections: Sequence[str] | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
    progress: Callable[[str], None] | None = None,
) -> dict[str, xr.Dataset]:
    """Run all analyses a model allows, each once.

    An analysis that asks for what the model does not say (torque, speed, damping, masses), or does not converge, is
    left out, and the first result's attribute ``not_run`` says why.  Tolerances are shown where the model has a table
    of them.

    Parameters
    ----------
    source, overrides : as of every verb.
    sections : names of `report_sections`; only these are computed, and `check`, which says what the train is.  Without
        them all are, but for the studies of trains with several mesh frequencies: their worst case over the slow phases
        takes a minute.
    folder : keeps every section that is done, and what the one at work keeps, so that a report that was stopped goes on
        with `resume`.
    progress : called with the name of what is done, in the order of the sections.

    Returns
    -------
    name -> Dataset, in the order of `report_verbs`, `TO_MODES` and `STUDIES`.

    Raises
    ------
    ModelError : the model itself is wrong, or no such section.
    """
    from ..engine.run_folder import run_folder
    from ..engine.source import train_of

    chosen = None if sections is None else _chosen(sections)
    results: dict[str, xr.Dataset] = {}
    left_out: list[CodedText] = []
    train = train_of(source, overrides=overrides)
    options = {} if chosen is None else {"sections": sorted(chosen)}  # what tells one report from another in its folder
    with run_folder(folder, train, verb="report", options=options, resume=resume) as (train, kept):
        steps = _steps(train, kept.folder)
        if chosen is not None:
            steps = {name: step for name, step in steps.items() if _section(name) in chosen}
        # with several mesh frequencies a worst case is one over their phases too
        elif len(set((train.kinematics.mesh_frequency or {}).values()) - {0}) > 1:
            words = "takes long with several mesh frequencies; it runs where --sections names it,"
            left_out += [coded("section-left-out", f"{name} {words} {_section(name)}") for name in STUDIES]
            steps = {name: step for name, step in steps.items() if name not in STUDIES}
        for name, found in zip(steps, _run_steps(steps, kept, progress), strict=True):
            if isinstance(found, str):
                left_out.append(coded("section-left-out", f"{name}, as {found}"))
            else:
                results[name] = found
    first = next(iter(results.values()))
    first.attrs["not_run"] = json.dumps(left_out)
    return results


def _run_steps(
    steps: Mapping[str, Callable[[], xr.Dataset]], kept: RunFolder, progress: Callable[[str], None] | None
) -> list[xr.Dataset | str]:
    """The result of every section, or why it has none; where forked on several cores."""
    from ..engine.workers import each

    names = list(steps)
    # what takes longest begins first, after the one that says what the train is: no core waits for it at the end
    order = sorted(range(len(names)), key=lambda at: (at > 0, names[at] not in STUDIES))
    done: set[str] = set()

    def made(name: str) -> xr.Dataset | str:
        try:
            return steps[name]()
        except ModelError as error:
            if kept.folder is not None and Path(error.path).is_relative_to(kept.folder):
                raise  # a folder that takes nothing is no property of the model
            # a sentence, where nothing wrong was given
            plain = error.path and error.allowed and f"{error.path} = " not in str(error)
            return f"{error.problem}; it needs {error.allowed} in {error.path}" if plain else str(error)
        except ConvergenceError as error:
            return str(error)

    ordered, untold = [names[at] for at in order], list(names)

    def arrived(turn: int, _: xr.Dataset | str) -> None:
        done.add(ordered[turn])
        while untold and untold[0] in done:
            name = untold.pop(0)
            if progress is not None:
                progress(name)

    found = each(made, ordered, arrived=arrived, kept=kept.part("sections", ordered), pickled=False)
    return [one for _, one in sorted(zip(order, found, strict=True), key=lambda pair: pair[0])]


def _chosen(sections: Sequence[str]) -> set[str]:
    """Names asked for, and `check`.

    Raises
    ------
    ModelError : none, or one that is not known.
    """
    names, known = [_section(name.strip()) for name in sections], report_sections()
    wrong = [name for name in names if name not in known]
    if wrong or not names:
        raise ModelError("no such section", path="sections", given=", ".join(wrong), allowed=", ".join(known))
    return {"check", *names}


def _steps(train: Train, folder: Path | None) -> dict[str, Callable[[], xr.Dataset]]:
    """Everything a report shows, by name; the System is made once, when first asked for.

    folder : in which a verb that keeps what is done has one of its name.
    """
    from ..engine.source import system_of
    from ..questions.studies.parameter_studies import run_out_study, support_study
    from ..system.tooth_pairs import first_mesh

    system = cache(lambda: system_of(train))
    bends = any(body.elastic for body in train.bodies)
    # of a locked train in place of all that needs speeds
    names = (*report_verbs(), *["static"] * (train.kinematics.locked or bends))
    steps: dict[str, Callable[[], xr.Dataset]] = {
        name: partial(_run, verbs()[name], train, system, folder) for name in names
    }
    steps["contact"] = lambda: verbs()["contact"].run(train, mesh=first_mesh(train), tolerance=_CONTACT)
    steps["output"] = partial(verbs()["output"].run, train, **_OUTPUT)
    steps["tolerance"] = partial(verbs()["tolerance"].run, train, samples=_SAMPLES, effects="shares")
    if not train.document.get("tolerance"):  # nothing is missing in a model without tolerances
        del steps["tolerance"]
    if not any(link.rolling for link in train.links):
        del steps["life"]
    steps["sweep"] = partial(_sweep, system, folder, "operation", 0)
    steps[TO_MODES] = partial(_sweep, system, folder, "modes", 1)
    support, run_out = _STUDY_POINTS
    studies = (partial(support_study, train, points=support), partial(run_out_study, train, points=run_out))
    return steps | dict(zip(STUDIES, studies, strict=True))


def _sweep(system: Callable[[], System], folder: Path | None, speed_range: str, which: int) -> xr.Dataset:
    """One of the two sweeps of a report."""
    points = _POINTS if len(system().tones) < 2 else _POINTS_OF_MANY_TONES
    more = _kept_in(folder, f"sweep-{speed_range}")
    result = verbs()["sweep"].run(system(), range=speed_range, points=points[which], **more)
    if speed_range == "modes":  # what is only far from operation is said to be so
        highest = 100 * float(result["speed"].max())
        found = json.loads(result.attrs.get("warnings", "[]"))
        far = [
            one if one in system().warnings else placed(f"up to {highest:.0f} % of the operating speed", one)
            for one in found
        ]
        result.attrs["warnings"] = json.dumps(far)
    return result


def _run(verb: Verb, train: Train, system: Callable[[], System], folder: Path | None) -> xr.Dataset:
    more = _kept_in(folder, verb.name) if "folder" in signature(verb.run).parameters else {}
    return verb.run(train if verb.drawing else system(), **more)


def _kept_in(folder: Path | None, name: str) -> dict[str, Any]:
    """Keywords with which a verb keeps what is done, or goes on with it, in a folder of its own."""
    return {} if folder is None else {"folder": folder / name, "resume": True}
