"""Commands that make a file of a model: `new`, from the first numbers of a drawing; `import` and `export` of REXS.

`new` asks for what is missing, or takes flags; `import` and `export` list what became of each value.
"""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import ModelError
from ..options import option_fields
from ..results.files import write_text
from ..rexs.file import HEADINGS, SUFFIXES
from ..train import NewTrainOptions
from ..verbs.record import command_words
from .command import Model, Sets, file_name, file_option, flagged, plain, typed_options, with_signature
from .output import complain, complain_of, on_stdout, parsed_overrides, reported, require_stdout, target_of

if TYPE_CHECKING:
    from ..rexs.stages import Entry
    from ..train.new_train import NewTrain

_FLAGS = {name: str(option.flag_of(name)) for name, (_, _, option) in option_fields(NewTrainOptions).items()}
_BY_LOAD = "by load"  # answer to a question: let it be chosen


def new(file: Path, force: bool, **given: Any) -> None:
    """A model file of a new train from teeth or ratio, power and speed; asks for what is missing in a terminal."""
    with reported(), flagged(_FLAGS):
        target_of(file, (".toml",), name="FILE", force=force)  # before any question
        words = {name: plain(value) for name, value in given.items() if value not in (None, [])}
        train, words = _asked(words) if _asks(words) else (_made(words), words)
        command = shlex.join(["epicyclic", "new", str(file), *command_words(option_fields(NewTrainOptions), words)])
        chosen = f"Values under [assumed] are chosen, not given. Next: epicyclic check {file}"
        write_text(file, train.text((f"Written by: {command}", chosen)))
        with on_stdout():
            _tell(file, train)


def new_command() -> Callable[..., None]:
    """Function of the command `new` with the signature that typer makes a command of."""
    place = typer.Argument(parser=file_name, metavar="FILE", help="The model file to write (.toml).")
    further = {"force": (Annotated[bool, typer.Option("--force", help="Replace FILE where there is one.")], False)}
    options = typed_options(option_fields(NewTrainOptions), asked=True)
    return with_signature(new, {"file": (Annotated[Path, place], Path("train.toml")), **options, **further})


def _made(given: Mapping[str, Any]) -> NewTrain:
    from ..train.new_train import new_train

    return new_train(**given)


def _tell(file: Path, train: NewTrain) -> None:
    """Say what was written, what was chosen and what to run next."""
    name = shlex.quote(str(file))
    title = train.document["title"]
    heads = {name: title if name == "main" else name for name in train.document["stages"]}
    facts = [f"{head}: {train.comments[f'stages.{name}']}" for name, head in heads.items()]
    for line in (f"written: {file}", *facts, *train.remarks):
        typer.echo(line)
    typer.echo(f"{len(train.document['assumed'])} values are chosen by rules, see [assumed] in the file. Next:")
    for command, why in (
        ("check", "speeds, torques, geometry"),
        ("modes", "natural frequencies"),
        ("sharing", "how equally the planets carry"),
        ("sweep", "vibration over speed"),
        ("tolerance", "K_gamma from the tolerances"),
        ("report", "all of it in one HTML file"),
    ):
        typer.echo(f"  {f'epicyclic {command} {name}':<40} # {why}")


# questions ------------------------------------------------------------------------------------------------------------


def _asks(given: Mapping[str, Any]) -> bool:
    """Whether a necessary value is missing and somebody is there to be asked."""
    load = [name in given for name in ("speed", "torque", "power", "output_torque")]
    whole = ("teeth" in given or "ratio" in given) and sum(load) >= (2 if given.get("kind") != "differential" else 1)
    return not whole and sys.stdin is not None and sys.stdin.isatty()


def _asked(given: dict[str, Any]) -> tuple[NewTrain, dict[str, Any]]:
    """Train and words of a person who is asked for all that is missing; a wrong answer is asked for again."""
    words = dict(given)
    for name in _QUESTIONS:
        _ask(name, words)
    while True:
        try:
            return _made(words), words
        except ModelError as error:
            name = next((name for name in _QUESTIONS if error.path in _answers(name)), "")
            if not name:
                raise
            complain(f"{error.problem}; allowed: {error.allowed}" if error.allowed else error.problem)
            for key in _answers(name):
                words.pop(key, None)
            _ask(name, words)


# keyword -> question, and the answer that is taken where none is given
_QUESTIONS: Mapping[str, tuple[str, str | None]] = {
    "kind": ("Kind: planetary, star, differential ..., or planetary,parallel", "planetary"),
    "teeth": ("Teeth sun/planet/ring (21/39/99), or a ratio (5.7)", None),
    "planets": ("Planets", "3"),
    "held": ("Held member: ring or sun", "ring"),
    "speed": ('Speed of what drives ("1000 rpm")', None),
    "torque": ('Its torque or power ("7.2 kN m", "750 kW")', None),
    "module": ("Normal module", _BY_LOAD),
    "face_width": ("Face width", _BY_LOAD),
    "helix_angle": ("Helix angle", "0 deg"),
}
_OF_MEMBERS = {
    "speed": 'Speeds of two members ("sun=1000 rpm, carrier=100 rpm")',
    "torque": 'Torque or power of one ("sun=500 N m")',
}


def _answers(name: str) -> tuple[str, ...]:
    """Keywords that answer a question."""
    return {"teeth": ("teeth", "ratio"), "torque": ("torque", "power")}.get(name, (name,))


def _ask(name: str, words: dict[str, Any]) -> None:
    """Ask one question unless it is answered. Raises KeyboardInterrupt where nobody answers any more."""
    kind = words.get("kind", "planetary")
    if any(key in words for key in _answers(name)) or (name == "held" and kind != "planetary"):
        return
    if name == "speed" and "torque" in words and "power" in words:
        return
    text, default = _QUESTIONS[name]
    if kind == "differential":
        text = _OF_MEMBERS.get(name, text)
    try:
        answer = str(typer.prompt(text, default=default, err=True)).strip()
    except typer.Abort:
        raise KeyboardInterrupt from None
    if answer != _BY_LOAD:
        words |= _answer(name, answer)


def _answer(name: str, answer: str) -> dict[str, Any]:
    """Keyword and value that an answer gives."""
    if name == "teeth":
        with suppress(ValueError):
            return {"ratio": float(answer)}
    if name == "torque" and answer.endswith(("W", "hp")):
        name = "power"
    several = name in ("speed", "torque", "power") and "=" in answer
    return {name: answer.split(",") if several else answer}


@reported()
def import_rexs(
    file: Annotated[str, typer.Argument(metavar="FILE", help="A REXS file: .rexs, .rexsj or .rexsz.")],
    load_case: Annotated[
        int | None, typer.Option("--load-case", metavar="ID", help="Load case whose speeds and loads count.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print what was read, assumed and dropped as JSON on stdout.")
    ] = False,
    output: Annotated[Path | None, file_option("Write the model file (.toml).")] = None,
) -> None:
    """A REXS file as a commented model file, and what of it was read, assumed and dropped."""
    if output is not None:
        target_of(output, (".toml",))
    require_stdout()
    from ..document.document import read
    from ..rexs.export import rexs_model_text
    from ..rexs.import_train import read_rexs, traced

    found = read_rexs(file, load_case=load_case)
    try:
        read(found.document)  # what no model file may hold is refused before anything is written
    except ModelError as error:
        raise traced(error, found) from None
    if output is not None:
        write_text(output, rexs_model_text(found, file))
        complain(f"written: {output}")
    complain_of(found.warnings)
    entries: dict[str, tuple[Entry, ...]] = {kind: getattr(found, kind) for kind in HEADINGS}
    with on_stdout():
        if as_json:
            lists = {kind: list(map(asdict, own)) for kind, own in entries.items()}
            typer.echo(json.dumps({"version": found.file.version, "title": found.document["title"], **lists}))
        else:
            types = {component.id: component.type for component in found.file.components}
            lines = {f"{HEADINGS[kind]} ({len(own)})": _lines(own, types) for kind, own in entries.items()}
            _print_lists(str(found.document["title"]), lines)


def _print_lists(title: str, lists: Mapping[str, Sequence[str]]) -> None:
    """Print lines by heading."""
    from ..show.console import stdout_console

    console = stdout_console()
    console.print(title, style="bold", markup=False, soft_wrap=True)
    for heading, lines in lists.items():
        console.print(f"\n{heading}", style="bold", markup=False)
        for line in lines:
            console.print(f"  {line}", markup=False, highlight=False, soft_wrap=True)


def _lines(entries: Sequence[Entry], types: dict[int, str]) -> list[str]:
    """Lines of entries, those of one type with equal words together."""
    groups: dict[tuple[str, str, str], list[int]] = {}
    for entry in entries:
        ids = [] if entry.component is None else [entry.component]
        kind = "".join(types[one] for one in ids)
        groups.setdefault((kind, entry.attribute, entry.where), []).extend(ids)
    lines = []
    for (kind, attribute, where), ids in groups.items():
        who = f"{kind} {', '.join(map(str, ids))}: " if kind else ""
        lines.append(f"{who}{attribute}: {where}")
    return lines


@reported()
def export(
    model: Model,
    output: Annotated[Path, file_option("The file: .rexs, .rexsj or .rexsz.")],
    sets: Sets = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what is not carried as JSON on stdout.")] = False,
) -> None:
    """A REXS file of a train, version 1.7, and what of the model it does not carry."""
    target_of(output, SUFFIXES)
    require_stdout()
    from ..rexs.export import write_rexs

    found = write_rexs(model, output, overrides=parsed_overrides(sets))
    complain(f"written: {output}")
    counts = {"components": len(found.file.components), "relations": len(found.file.relations)}
    with on_stdout():
        if as_json:
            dropped = list(map(asdict, found.dropped))
            typer.echo(json.dumps({"version": found.file.version, **counts, "dropped": dropped}))
        else:
            head = f"REXS {found.file.version}: {counts['components']} components, {counts['relations']} relations"
            lines = [f"{entry.path}: {entry.text}" for entry in found.dropped]
            _print_lists(head, {f"Not carried ({len(lines)})": lines})
