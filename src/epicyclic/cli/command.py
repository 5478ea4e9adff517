"""Commands of the verbs: the signature of a verb as typer reads it, one run of it, and what a stopped run leaves.

A run shows its progress, prints its result or writes it to a file, and tells errors in words of the flags.  A run that
is stopped names the command that goes on from there.  Before them stand the help of the program by question, completion
in the shell, and the nearest word for one that is not there.
"""

from __future__ import annotations

import os
import re
import shlex
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from enum import StrEnum
from glob import escape, glob
from inspect import Parameter, Signature, signature
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from ..errors import ModelError
from ..options import Option, default_words, shape_of
from ..results.files import write_text
from ..verbs.record import Options, Verb, help_of, keywords, records, verbs
from .output import (
    FORMATS,
    complain,
    every_case,
    figure_option,
    help_on_stdout,
    import_model_rooms,
    parsed_overrides,
    print_result,
    progress_bar,
    put,
    reported,
    require_output,
)

if TYPE_CHECKING:
    import xarray as xr

_COMMANDS: Mapping[str, Mapping[str, str]] = {
    "Where do I begin?": {
        "new": "Write a model file from teeth or ratio, power and speed.",
        "app": "A page on this machine: sliders, and a train that answers.",
        "import": "Write a model file from a REXS file.",
        "systems": "The ready drives: names that stand for a model file.",
        "explain": "What a key, a variable or a warning means.",
        "schema": "The JSON Schema of the model file, for editors.",
    },
    "What does the drawing say?": {
        "compare": "What differs between trains, and what it does.",
        "audit": "Published numbers of the ready drives beside ours.",
    },
    "How does it vibrate?": {},
    "How do planets share the load?": {},
    "How do the teeth carry it?": {},
    "Which number do I change?": {},
    "How do I take it away?": {
        "report": "Everything in one HTML file that opens offline.",
        "study": "A verb over many points, from a job file.",
        "show": "Tables and figures of a saved result again.",
        "export": "A REXS file of a train.",
    },
}
"""Question -> command that is no verb -> what it does in a line."""


def panels() -> dict[str, dict[str, str]]:
    """Question -> command -> what it does in a line: the verbs of a report, commands, the other verbs."""
    every = sorted(records().values(), key=lambda verb: (verb.in_report, verb.name))
    lines: dict[str, dict[str, str]] = {}
    for question, commands in _COMMANDS.items():
        own = {verb.name.replace("_", "-"): verb for verb in every if verb.question == question}
        first = {name: verb.line for name, verb in own.items() if verb.in_report}
        lines[question] = {**first, **commands, **{name: verb.line for name, verb in own.items()}}
    return lines


class Commands(TyperGroup):
    """The commands of the program, whose help is one screen; an error of one that is not there, or of its options,
    names the nearest."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the options before the command."""
        ctx.meta[_TYPED] = list(args)
        return list(_told(lambda: super(Commands, self).parse_args(ctx, args), self, ctx))

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        return _told(lambda: super(Commands, self).invoke(ctx), self, ctx)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write usage, commands by question, options."""
        width = max(map(len, self.commands)) + 2
        lines = [self.help or "", "Usage: epicyclic COMMAND [MODEL] [OPTIONS]; epicyclic COMMAND --help tells more."]
        for question, names in panels().items():
            lines.append(typer.style(question, bold=True))
            lines += [_line(name, words, width) for name, words in names.items()]
        lines.append(typer.style("Options", bold=True))
        for parameter in self.get_params(ctx):
            words = getattr(parameter, "help", None)
            if words:
                lines.append(_line(", ".join(parameter.opts), words.split(",")[0].rstrip("."), max(width, 22)))
        formatter.write("\n".join(lines) + "\n")


def _line(name: str, words: str, width: int) -> str:
    return f"  {typer.style(name, fg=typer.colors.CYAN)}{' ' * (width - len(name))}{words}"


_MODELS = (".toml", ".rexs", ".rexsj", ".rexsz")
# folder of the ready drives: reading its names must not import the model, which takes longer than a key stroke
_DRIVES = Path(__file__).parents[1] / "systems"


def model_names(incomplete: str) -> list[str]:
    """Ready drives, model files and folders that begin with what is typed; none where a folder cannot be read."""
    return _names(incomplete, _MODELS)


def source_names(incomplete: str) -> list[str]:
    """The same and saved results."""
    return _names(incomplete, (*_MODELS, ".nc", ".json"))


def explained_names(incomplete: str) -> list[str]:
    """Codes of warnings and variables of results that begin with what is typed."""
    from ..results.variables import VARIABLES
    from ..warning_codes import WARNING_CODES

    return [name for name in (*WARNING_CODES, *VARIABLES) if name.startswith(incomplete)]


def _names(incomplete: str, suffixes: tuple[str, ...]) -> list[str]:
    try:
        drives = sorted(path.stem for path in _DRIVES.glob("*.toml") if "." not in path.stem)
        return [*(name for name in drives if name.startswith(incomplete)), *_files(incomplete, suffixes)]
    except (OSError, ValueError, RuntimeError):  # a folder that cannot be read, a name with a zero byte, no such home
        return []


def _files(incomplete: str, suffixes: tuple[str, ...]) -> list[str]:
    """Files and folders below the folder that is typed; hidden ones where a point is typed."""
    head, begin = os.path.split(incomplete)
    folder, found = Path(head).expanduser(), list[str]()
    for name in sorted(glob(f"{escape(begin)}*", root_dir=folder)):
        typed = os.path.join(head, name)  # ~ and ./ stay
        if (folder / name).is_dir():
            found.append(f"{typed}/")
        elif name.lower().endswith(suffixes):
            found.append(typed)
    return found


_TYPED = "epicyclic.typed"
_NO_COMMAND = re.compile(r"No such command '(.*?)'\.?", re.DOTALL)
_NO_WORD = re.compile(r"'?([^']*)'? is not one of (.*?)\.?$", re.DOTALL)


def _told(run: Any, group: TyperGroup, ctx: Any) -> Any:
    """Run a function; errors of names that are not there get the nearest ones.

    The classes of the errors are of click or of typer's own copy of it: they are known by what they hold.
    """
    try:
        with help_on_stdout():
            return run()
    except Exception as error:
        if hasattr(error, "message") and hasattr(error, "ctx"):
            typed = ctx.meta.get(_TYPED, [])
            if hasattr(error, "option_name") and hasattr(error, "possibilities"):
                error.message, error.possibilities = _option_message(error, group, ctx, typed), None
            elif found := _NO_COMMAND.match(str(error.message)):
                error.message = _command_message(found[1], group)
            elif found := _NO_WORD.search(str(error.message)):
                words = re.findall(r"'([^']*)'", found[2])
                text = str(error.message).removeprefix("Value error, ").rstrip(".")
                error.message = f"{text}{_nearest(found[1], words)}"
        raise


def _option_message(error: Any, group: TyperGroup, ctx: Any, typed: list[str]) -> str:
    """Message of an option that is not there: the nearest of its command, or of which commands it is."""
    words = [word.split("=")[0] for word in typed]
    # of -damped the parser reads -d alone
    name = next((word for word in words if word.startswith(error.option_name)), error.option_name)
    command = (error.ctx or ctx).command
    if command is not group:
        return f"no such option {name}{_nearest(name, _options(command))}"
    others = [own for own, one in group.commands.items() if name in _options(one)]
    if others:
        own = next((word for word in words if word in others), others[0])
        return f"{name} stands behind the command: epicyclic {own} ... {name}"
    return f"no such option {name}{_nearest(name, _options(group))}"


def _command_message(name: str, group: TyperGroup) -> str:
    """Message of a command that is not there."""
    from ..document.document import ready_drives

    known = [own for own, one in group.commands.items() if not getattr(one, "hidden", False)]
    if name in ready_drives() or name.endswith(_MODELS):
        return f"no such command '{name}'; a model stands behind the command: epicyclic check {name}"
    return f"no such command '{name}'{_nearest(name, known)}"


def _options(command: Any) -> list[str]:
    """Names of the options of a command, those that its help shows."""
    shown = [one for one in command.params if getattr(one, "param_type_name", "") == "option" and not one.hidden]
    return [name for one in shown for name in (*one.opts, *one.secondary_opts)]


def _nearest(word: str, known: Iterable[str]) -> str:
    """``; did you mean '--damped'?``, or nothing; dashes and underscores count as the same."""
    from ..document.schema import nearest

    plain = {_plain_name(name): name for name in known}
    found = re.search(r"'(.*)'", nearest(_plain_name(word), plain))
    return f"; did you mean '{plain[found[1]]}'?" if found else ""


def _plain_name(name: str) -> str:
    return name.lstrip("-").replace("_", "-").lower()


@contextmanager
def kept(
    output: Path | None, *, keeps: str = "-o FILE", named: Path | None = None, takes_folder: bool = False
) -> Iterator[Path | None]:
    """The folder beside the output that keeps what is done until the run is whole; None without one.

    Where a command is stopped or can write no more, says what is kept and names the command that goes on.  A folder
    beside the output with nothing to go on from is deleted.

    Parameters
    ----------
    keeps : option that has the command keep what is done; nothing of a command that keeps nothing.
    named : folder that keeps it instead.  takes_folder : whether ``--resume`` names the folder.
    """
    parts = output.with_name(output.name + ".parts") if output is not None and output.name else None
    if parts is not None and not parts.absolute().parent.is_dir():
        parts = None
    try:
        yield parts
        if parts is not None:
            from ..engine.run_folder import remove_folder

            remove_folder(parts)
    except (KeyboardInterrupt, ModelError) as error:
        _tell(error, parts if named is None else named, keeps, takes_folder)
        raise
    finally:
        if parts is not None:
            from ..engine.run_folder import remove_folder

            remove_folder(parts, with_results=False)


def _tell(error: KeyboardInterrupt | ModelError, folder: Path | None, keeps: str, takes_folder: bool) -> None:
    """Say what a command that ends with an error has kept; parameters as of `kept`."""
    from ..engine.run_folder import begun

    stopped = isinstance(error, KeyboardInterrupt)
    broken = isinstance(error, ModelError) and error.problem.startswith(("cannot be written", "the connection"))
    if folder is not None and (stopped or broken) and begun(folder):
        words = ["epicyclic", *sys.argv[1:]]
        if "--resume" not in words:
            words += ["--resume", *[str(folder)] * takes_folder]
        complain(f"what is done is kept in {folder}; this command continues it:\n  {shlex.join(words)}")
    elif stopped and keeps and folder is not None:
        complain("nothing was done yet that could be kept")
    elif stopped and keeps:
        complain(f"nothing is kept without {keeps}; with it, --resume goes on from where a run was stopped")


def run_verb(
    verb: Verb,
    flags: Mapping[str, str],
    /,
    *,
    model: str,
    sets: list[str] | None,
    as_json: bool,
    output: Path | None,
    case: str | None = None,
    figure: list[str] | None = None,
    whole: bool = False,
    further: Callable[[xr.Dataset], xr.Dataset] = lambda result: result,
    **given: Any,
) -> None:
    """Run one verb; print its result for people or as JSON, and write it, or figures of it, to a file.

    Parameters
    ----------
    flags : keyword -> flag, for errors.  sets, case, as_json, output, figure, whole : as on the command line.
    further : what other verbs say beside the result.  given : keyword -> value of the verb.

    Raises
    ------
    typer.Exit : 2 wrong input, 3 no convergence, 130 stopped, 1 a fault of the program.
    """
    options = {name: plain(value) for name, value in given.items() if value not in (None, [])}
    every = every_case(sets, case)
    # of several cases each would need a folder of its own
    in_folder = "folder" in signature(verb.run).parameters and not every
    takes_folder = in_folder and keywords(verb.run)["resume"][1] is not bool
    named = options.get("resume" if takes_folder else "store")
    keeping = kept(
        output if in_folder else None,
        keeps="-o FILE" if in_folder else "--store DIR" if "store" in flags else "",
        named=Path(named) if named else None,
        takes_folder=takes_folder,
    )
    writers: dict[str, Callable[[xr.Dataset, Path], object]] = dict(verb.writers)
    if (model_text := verb.model_text) is not None:
        writers[".toml"] = lambda result, file: write_text(file, model_text(result))
    with reported(), flagged({"overrides": "--set", "case": "--case", **flags}), keeping as folder:
        require_output(output, figure, verb.gives, as_json=as_json, further=tuple(writers))
        if figure and every and not getattr(verb.run, "joint", False):
            raise ModelError("is of one case", path="--figure", given=", ".join(figure), allowed="--case with its name")
        if verb.reads and every:
            raise ModelError("has no load cases, it gives them", path="--set", given="case=all", allowed="no case")
        if verb.reads and output is not None:
            _keep_model(output)
        import_model_rooms()
        overrides = parsed_overrides(sets, case)
        with progress_bar(f"{verb.name} {model}") as step:
            more: dict[str, Any] = {} if folder is None else {"folder": folder}
            if "progress" in signature(verb.run).parameters:
                more["progress"] = lambda done, of=1: step(done if of == 1 else done / of)
            result = further(verb.run(model, overrides=overrides or None, **options, **more))
        if output is not None and not figure and (kind := output.suffix.lower()) in writers:
            made = writers[kind](result, output)
            complain(f"written: {output}")
            for entry in getattr(made, "dropped", ()):
                complain(f"not carried: {entry.path}: {entry.text}")
            print_result(result, as_json=as_json, beside_file=True)
        else:

            def make(name: str) -> xr.Dataset:
                return verbs()[name].run(model, overrides=overrides or None)

            put({verb.name: result}, output=output, figures=figure, as_json=as_json, make=make, whole=whole)
        if result.attrs.get("stopped"):
            raise KeyboardInterrupt


def _keep_model(output: Path) -> None:
    """Refuse to write a part of a model file over a whole one."""
    if output.suffix.lower() != ".toml" or not output.is_file():
        return
    try:
        whole = "format" in tomllib.loads(output.read_text(encoding="utf-8"))
    except (ValueError, OSError):
        return
    if whole:
        raise ModelError(
            "is a model file",
            path="--output",
            given=str(output),
            allowed="another name: what is written goes behind it",
        )


_PAIR = re.compile(r'"(\w+)": "([^"]+)"')
_TABLE = re.compile(r"(?:\w+ = )?\{[^{}]+\}")


@contextmanager
def flagged(flags: Mapping[str, str]) -> Iterator[None]:
    """Name keywords by their flags in errors; a table by member is several flags on the command line."""
    try:
        yield
    except ModelError as error:
        path = ", ".join(flags.get(part, part) for part in error.path.split(", "))
        rest = str(error).removeprefix(error.path)
        if error.path in flags and error.path != "case" and isinstance(error.given, bool):
            # a flag without a value, as it was typed
            path = path if error.given else path.replace("--", "--no-", 1)
            rest = rest.removeprefix(f" = {error.given!r}")
        if error.path in flags and (table := _TABLE.search(error.allowed)) and (pairs := _PAIR.findall(table[0])):
            several = " ".join(f"{path} '{member}={value}'" for member, value in pairs)
            rest = rest.replace(table[0], several)
        raise ModelError(path + rest) from error


def file_name(text: str | Path) -> Path:
    """File that a person named, or a default; an empty text would be the folder here."""
    if not str(text).strip():
        raise typer.BadParameter("an empty name")
    return Path(text)


def file_option(words: str) -> Any:
    """The option ``-o`` with its help."""
    return typer.Option("-o", "--output", parser=file_name, metavar="FILE", help=words)


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
Case = Annotated[
    str | None,
    typer.Option(
        "--case", metavar="NAME", help="Load case of the model, or all of them; default the nominal operation."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON, xarray's Dataset.to_dict(), on stdout.")]
Output = Annotated[Path | None, file_option(f"Write the result: {FORMATS}.")]


def command(
    verb: Verb, own: Callable[..., None] | None = None, more: Mapping[str, tuple[Any, Any]] = MappingProxyType({})
) -> Callable[..., None]:
    """Function that runs a verb, with the signature, the name and the help that typer makes a command of.

    own : runs it in place of `run_verb`, with the options of its own of `more`, name -> annotation and default.
    """
    shown = {name: entry for name, entry in keywords(verb.run).items() if entry[2].flag is not None}
    flags = {name: str(option.flag_of(name)) for name, (_, _, option) in shown.items()}

    def run(**given: Any) -> None:
        run_verb(verb, flags, **given)

    run.__name__, run.__doc__ = verb.name, _unmarked(help_of(verb))
    words = f"Write the result: {', '.join([*verb.writers, FORMATS])}."
    if verb.model_text:
        words = f"Write it for a model file (.toml), or the result ({FORMATS})."
    source = Annotated[str, typer.Argument(metavar="FILE", help=_unmarked(verb.reads))] if verb.reads else Model
    typed = {
        "model": (source, Parameter.empty),
        **more,
        **typed_options(shown),
        "sets": (Sets, None),
        **({} if verb.reads else {"case": (Case, None)}),
        "as_json": (Json, False),
        "figure": (Annotated[list[str] | None, figure_option(verb.gives)], None),
        "output": (Annotated[Path | None, file_option(words)], None),
    }
    return with_signature(own or run, typed)


def with_signature(run: Callable[..., None], typed: Mapping[str, tuple[Any, Any]]) -> Callable[..., None]:
    """A function with the keywords that typer makes a command of: name -> annotation and default."""
    run.__annotations__ = {name: annotation for name, (annotation, _) in typed.items()}
    run.__signature__ = Signature(  # type: ignore[attr-defined]
        [
            Parameter(name, Parameter.KEYWORD_ONLY, annotation=annotation, default=default)
            for name, (annotation, default) in typed.items()
        ]
    )
    return run


def typed_options(options: Options, *, asked: bool = False) -> dict[str, tuple[Any, Any]]:
    """Keyword -> annotation and default for typer.

    asked : a person is asked for what is not typed, so that every default is left open.
    """
    return {name: _option(name, *options[name], left=asked) for name in options}


def _option(name: str, default: Any, kind: Any, option: Option, *, left: bool) -> tuple[Any, Any]:
    """Annotation and default of one option; a default that is left, or that nobody could type, is shown alone."""
    flag, typed = str(option.flag_of(name)), _type(kind)
    if typed is bool and default is not False:
        flag = f"{flag}/--no-{flag.removeprefix('--')}"
    if isinstance(typed, type) and issubclass(typed, StrEnum) and isinstance(default, str):
        default = typed(default)
    entry = typed if isinstance(typed, type) else ()
    left = left or (default is not Parameter.empty and not isinstance(default, entry))
    words = option.default or (default_words(default) if left else "")
    number = {float: "number", int: "whole number"}.get(typed, "")
    made = typer.Option(
        flag,
        help=_unmarked(option.help),
        # the bounds of a number are the verb's, which tells them in its own words
        parser=_parsed(typed, number) if number else None,
        metavar=option.metavar or (f"<{', '.join(filter(None, (number, option.range)))}>" if number else None),
        show_default=words or default is not None,
    )
    return (Annotated[typed | None, made], None) if left else (Annotated[typed, made], default)


def plain(value: Any) -> Any:
    """Value without the enumeration of typer: a word stays a plain text."""
    if isinstance(value, list):
        return [plain(one) for one in value]
    return value.value if isinstance(value, StrEnum) else value


def _parsed(kind: type[float] | type[int], words: str) -> Callable[[str], float]:
    """Reader of a number that a person typed; a default is one already."""

    def parse(text: str) -> float:
        try:
            return kind(text)
        except ValueError:
            raise typer.BadParameter(f"{text!r} is no {words}") from None

    return parse


def _type(kind: Any) -> Any:
    """What the command line reads for a type."""
    kind, choices, several = shape_of(kind)
    entry: Any = StrEnum("Choice", [(word, word) for word in choices]) if choices else kind
    return list[entry] if several else entry


def _unmarked(text: str) -> str:
    """A text without markup of rich: [rad] is a unit, [tolerance] a table."""
    return re.sub(r"\[(?=[a-z])", r"\\[", text)
