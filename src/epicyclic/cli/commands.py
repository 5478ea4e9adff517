"""Commands that are no verbs of one model: app, audit, compare, explain, report, show, study, systems; and those that
make a file of a model: `new`, from the first numbers of a drawing, `import` and `export` of REXS.

`new` asks for what is missing, or takes flags; `import` and `export` list what became of each value.
"""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import ConvergenceError, ModelError
from ..options import option_fields
from ..results.files import write_text
from ..rexs.file import HEADINGS, SUFFIXES, is_rexs_name
from ..train import NewTrainOptions
from ..verbs.record import command_words
from .command import (
    Case,
    Json,
    Model,
    Output,
    Sets,
    explained_names,
    file_name,
    file_option,
    flagged,
    kept,
    model_names,
    plain,
    source_names,
    typed_options,
    with_signature,
)
from .output import (
    FORMATS,
    complain,
    complain_of,
    every_case,
    figure_option,
    import_model_rooms,
    on_stdout,
    parsed_overrides,
    progress_bar,
    put,
    put_text,
    reported,
    require_output,
    require_stdout,
    target_of,
)

if TYPE_CHECKING:
    import xarray as xr

    from ..rexs.stages import Entry
    from ..train.new_train import NewTrain

_NEEDED = ("nicegui", "tomlkit")  # of the extra "app"
_LARGEST_PORT = 65_535


@reported()
def app(
    model: Annotated[
        str | None,
        typer.Argument(
            metavar="[MODEL]",
            help="A model file (.toml), a REXS file (.rexs), or the name of a ready drive; without it an empty page.",
            show_default=False,
            autocompletion=model_names,
        ),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(
            metavar="N", min=1, max=_LARGEST_PORT, help="Port to listen on.", show_default="8765, or the next free one"
        ),
    ] = None,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
) -> None:
    """The cockpit: a page on this machine with sliders, where the train answers while they move."""
    missing = [name for name in _NEEDED if find_spec(name) is None]
    if missing:
        raise ModelError(f"needs {' and '.join(missing)}", path="epicyclic app", allowed="pip install 'epicyclic[app]'")
    from ..cockpit.server import serve

    def tell(address: str) -> None:
        complain(f"the cockpit is open at {address}")
        complain("for this browser and this machine alone; Ctrl-C ends it")

    serve(model, port=port, browser=browser, tell=tell)


CONTRADICTED, REFUSED = 4, 2


@reported()
def audit(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]",
            show_default="all",
            help="A ready drive, or an audit file (NAME.audit.toml beside NAME.toml).",
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the table as JSON on stdout.")] = False,
    output: Annotated[Path | None, file_option(f"Write the table: {FORMATS}.")] = None,
) -> None:
    """Published numbers beside ours, each with a verdict and its reason; exit status 4 where one does not hold.

    A row that needs a package which is not installed is not computed, and fails nothing.  A row that is wrong, or whose
    run is refused, is told; the others are computed, and the exit status is 2 where none of them is contradicted.
    """
    require_output(output, None, ["audit"], as_json=as_json)
    from ..audits.audit import HOLDS, NOT_COMPUTED, WRONG
    from ..audits.audit import audit as run

    with progress_bar(f"audit {name or 'of all ready drives'}") as step:
        result = run(name, progress=step)
    put({"audit": result}, output=output, as_json=as_json)
    outcomes = [str(outcome) for outcome in result.outcome.values]
    if any(outcome != HOLDS and not outcome.startswith((NOT_COMPUTED, WRONG)) for outcome in outcomes):
        raise typer.Exit(CONTRADICTED)
    if any(outcome.startswith(WRONG) for outcome in outcomes):
        raise typer.Exit(REFUSED)


Sources = Annotated[
    list[str],
    typer.Argument(
        metavar="A B ...",
        help="Model files, ready drives or saved results (.nc, .json); A is the first.",
        autocompletion=source_names,
    ),
]
Variants = Annotated[
    list[str] | None,
    typer.Option(
        "--with",
        metavar="PATH=VALUE",
        help='A variant of A, beside it; may be repeated. Several values of one: "PATH=VALUE; PATH=VALUE".',
    ),
]


@reported()
def compare(
    sources: Sources,
    variants: Variants = None,
    sets: Sets = None,
    figure: Annotated[list[str] | None, figure_option(("compare",))] = None,
    as_json: Json = False,
    output: Output = None,
) -> None:
    """What differs between trains, and what it does to speeds, modes, load sharing and mesh forces.

    Saved results are compared variable by variable. --set applies to all models, --with makes one more of A.
    """
    require_output(output, figure, ("compare",), as_json=as_json)
    import_model_rooms()
    from ..questions.studies.compare import compare as run

    overrides = parsed_overrides(sets) or None
    with flagged({"overrides": "--set", "variants": "--with", "sources": "A B ..."}):
        result = run(*sources, overrides=overrides, variants=[_variant(text) for text in variants or ()])
    put({"compare": result}, output=output, figures=figure, as_json=as_json)


def _variant(text: str) -> dict[str, object]:
    """Overrides of one variant.

    Raises
    ------
    ModelError : no path or no = in a part of the text.
    """
    parts = [part.strip() for part in text.split(";") if part.strip()]
    if not parts:
        raise ModelError("says nothing", path="--with", given=text, allowed="PATH=VALUE")
    return parsed_overrides(parts)


Word = Annotated[
    str,
    typer.Argument(
        metavar="WORD",
        help="A path of the model file, a variable of a result, the code of a warning, a verb or a figure.",
        autocompletion=explained_names,
    ),
]


@reported()
def explain(
    word: Word, as_json: Annotated[bool, typer.Option("--json", help="Print the explanations as JSON.")] = False
) -> None:
    """What a path of the model file, a variable, a warning, a verb or a figure means."""
    from ..terms import explain as run

    found = run(word)
    with on_stdout():
        if as_json:
            typer.echo(json.dumps([one.as_dict() for one in found], indent=1, ensure_ascii=False))
            return
        from rich.markup import escape
        from rich.table import Table

        from ..show.console import stdout_console

        console = stdout_console()
        for place, one in enumerate(found):
            if place:
                console.print()
            console.print(f"[bold]{escape(one.name)}[/bold]  {one.kind}", soft_wrap=True)
            table = Table.grid(padding=(0, 2))
            table.add_column(no_wrap=True)
            table.add_column(overflow="fold")
            for label, text in one.rows().items():
                table.add_row(f"  {label}", escape(text))
            console.print(table)


# Trains side by side: more columns than that nobody reads on a screen.
_MOST = 4


def report(
    models: Annotated[
        list[str],
        typer.Argument(metavar="MODEL", help="Model files (.toml) or ready drives; several are put side by side."),
    ],
    sets: Sets = None,
    case: Case = None,
    sections: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES", help="Compute only these, with commas between: modes,sharing; a wrong one lists them all."
        ),
    ] = None,
    output: Annotated[Path, file_option("The HTML file to write.")] = Path("epicyclic-report.html"),
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue a report that was stopped; needs the same -o and options.")
    ] = False,
) -> None:
    """What passes and what to change, and everything the model allows, in one HTML file that opens offline."""
    cases = every_case(sets, case)
    several = len(models) > 1 or cases
    flags = {"sections": "--sections"}
    with reported(), flagged(flags), kept(None if several else output, keeps="" if several else "-o FILE") as folder:
        target_of(output, (".html",))
        require_stdout()
        if len(models) > _MOST:
            raise ModelError("too many models", path="MODEL", given=len(models), allowed=f"{_MOST} at most")
        if several and resume:
            raise ModelError("goes with one model and one case", path="--resume", given=", ".join(models))
        from ..verbs.record import STUDIES, report_verbs, run_report

        variants = _variants(models, parsed_overrides(sets, case), cases)
        if several:  # every model is read before the first is computed, which takes seconds
            from ..engine.source import train_of

            for name, (model, overrides) in list(variants.items()):
                try:
                    train_of(model, overrides=overrides)
                except ModelError as error:
                    if not cases or len(variants) == 1:
                        raise
                    complain(f"left out: case {name}: {error}")
                    del variants[name]
        names = None if sections is None else sections.split(",")
        steps = len(names) + 1 if names else len(report_verbs()) + len(STUDIES) + 1
        results: dict[str, dict[str, Any]] = {}
        with progress_bar(f"report {' '.join(models)}", steps * len(variants) + 1) as step:
            for name, (model, overrides) in variants.items():
                more: dict[str, Any] = {} if several else {"folder": folder, "resume": resume}
                results[name] = run_report(model, overrides=overrides, sections=names, progress=step, **more)
            step("figures")
            from ..engine.workers import each
            from ..show.report import variants_report, write_report

            if several:
                title = f"{next(iter(results.values()))['check'].attrs['title']}: load cases" if cases else ""
                compared = None if cases else _compared(models, sets, case)
                write_text(output, variants_report(results, title=title, compared=compared))
            else:
                write_report(output, next(iter(results.values())), each=partial(each, pickled=False))
        with on_stdout():
            _print(results, output)


def _variants(
    models: Sequence[str], overrides: dict[str, object], every: bool
) -> dict[str, tuple[str, dict[str, object]]]:
    """Model and overrides by what each is called in the page: its case, or its file without folder and ending.

    A name that comes again is numbered.  every : whether all load cases are asked for.
    """
    from ..questions.studies.compare import distinct_names
    from ..verbs.cases import case_names

    found, names = list[tuple[str, dict[str, object]]](), list[str]()
    for model in models:
        cases = case_names(model, overrides) if every else ()
        stem = Path(model).stem or model
        names += [case if len(models) == 1 else f"{stem}, {case}" for case in cases] or [stem]
        found += [(model, {**overrides, "case": case}) for case in cases] or [(model, overrides)]
    return dict(zip(distinct_names(names), found, strict=True))


def _compared(models: Sequence[str], sets: list[str] | None, case: str | None) -> Any:
    """What differs between the models, as `compare` says it; None where it cannot."""
    from ..questions.studies.compare import compare as run

    try:
        return run(*models, overrides=parsed_overrides(sets, case) or None)
    except (ModelError, ConvergenceError) as error:
        complain(f"left out: what differs between the models: {error}")
        return None


def _print(found: dict[str, dict[str, Any]], output: Path) -> None:
    """Key figures and warnings of one train, differences of several."""
    from ..show.console import show_pairs, show_table, show_warnings, stdout_console, warnings_of
    from ..show.report import difference_table
    from ..show.views import key_figures_of

    console = stdout_console()
    for name, results in found.items():
        title = results["check"].attrs["title"]
        console.print(title if len(found) == 1 else f"{name}: {title}", style="bold", markup=False)
        show_warnings(list(dict.fromkeys(text for result in results.values() for text in warnings_of(result))), console)
        for text in json.loads(results["check"].attrs.get("not_run", "[]")):
            console.print(f"left out: {text}", markup=False, soft_wrap=True)
    if len(found) == 1:
        show_pairs({words: value for value, words in key_figures_of(next(iter(found.values())))}, console)
    else:
        show_table(difference_table(found), console)
    console.print(f"written: {output}", markup=False, soft_wrap=True)


@reported()
def show(
    files: Annotated[
        list[str],
        typer.Argument(metavar="FILE...", help="Results that -o has written: .nc or .json.", show_default=False),
    ],
    figure: Annotated[
        list[str] | None,
        typer.Option(
            "--figure",
            metavar="NAME",
            help="Write this figure to -o FILE.svg, .png, .pdf or .html; a wrong one lists all.",
        ),
    ] = None,
    everything: Annotated[
        bool, typer.Option("--all", help="Print every table with every row, also what its verb leaves out.")
    ] = False,
    as_json: Json = False,
    output: Annotated[
        Path | None, file_option(f"Write the result in another format: {FORMATS}; several results in one .html.")
    ] = None,
) -> None:
    """Print a saved result again as its verb did, draw its figures, convert it."""
    several = len(files) > 1
    if several and as_json:
        raise ModelError("goes with one result alone", path="--json", given=", ".join(files))
    if several and output is not None and not figure and output.suffix.lower() != ".html":
        raise ModelError("holds one result", path="--output", given=str(output), allowed=".html, or one FILE at a time")
    results = _loaded(files)
    kinds = [str(result.attrs.get("verb", "")) for result in results.values()]
    require_output(output, figure, kinds, as_json=as_json)
    try:
        put(results, output=output, figures=figure, as_json=as_json, computed=False, whole=everything)
    except (KeyError, TypeError, ValueError) as error:
        from ..results.dataset import has_digest

        if isinstance(error, ModelError) or all(has_digest(file) for file in files):
            raise  # what the package wrote is no fault of the file
        problem = f"no whole result of its verb ({', '.join(kinds)}): {type(error).__name__}: {error}"
        raise ModelError(problem, path=", ".join(files), allowed="a file as epicyclic wrote it") from error


def _loaded(files: Sequence[str]) -> dict[str, xr.Dataset]:
    """Results by the names of their files, by their paths where two have one name.

    Raises
    ------
    ModelError : a file given twice, or as of `load_result`.
    """
    from ..results.dataset import load_result

    if len(set(files)) < len(files):
        raise ModelError("given twice", path="FILE", given=", ".join(files), allowed="each file once")
    stems = [Path(file).stem for file in files]
    names = [stem if stems.count(stem) == 1 else file for stem, file in zip(stems, files, strict=True)]
    for file in files:
        if file.lower().endswith(".toml") or is_rexs_name(file):
            raise ModelError("a model, no saved result", path=str(file), allowed=f"a result; epicyclic check {file}")
    return {name: load_result(file) for name, file in zip(names, files, strict=True)}


def study(
    job: Annotated[str, typer.Argument(metavar="JOB", help="A job file (.toml): verb, model, options, what varies.")],
    store: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder that keeps every point that is done; --resume goes on from it."),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the store of the same job.")] = False,
    workers: Annotated[
        int | None, typer.Option(metavar="N", min=1, max=1024, help="Local processes.", show_default="this process")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="URL", help="A Dask scheduler that runs: tcp://HOST:8786.")
    ] = None,
    as_json: Json = False,
    figure: Annotated[list[str] | None, figure_option(["study"])] = None,
    output: Output = None,
) -> None:
    """A verb over a grid, a list or a sample of values in the model file and of options, as one labelled Dataset."""
    flags = {name: f"--{name}" for name in ("store", "resume", "workers", "scheduler")}
    with reported(), flagged(flags), kept(None, keeps="--store DIR", named=store):
        require_output(output, figure, ["study"], as_json=as_json)
        import_model_rooms()
        from ..questions.studies.verbs import study as run

        with progress_bar(f"study {job}") as step:
            result = run(job, store=store, resume=resume, workers=workers, scheduler=scheduler, progress=step)
        put({"study": result}, output=output, figures=figure, as_json=as_json)


@reported()
def systems(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="Print the model file of this drive.", show_default=False)
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print names and titles as JSON.")] = False,
    output: Annotated[Path | None, file_option("Copy the model file of NAME (.toml).")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace FILE where there is one.")] = False,
) -> None:
    """The ready drives: names that every verb takes in place of a model file; with a name, its file."""
    from ..document.document import drive_text, drive_titles

    if name is not None:
        if as_json:
            allowed = f"epicyclic systems {name}, without it"
            raise ModelError("prints names and titles only", path="--json", allowed=allowed)
        return put_text(drive_text(name), output, ".toml", force=force)
    if output is not None:
        raise ModelError("is missing", path="NAME", allowed="the name of a ready drive, before -o FILE")
    titles = drive_titles()
    with on_stdout():
        if as_json:
            typer.echo(json.dumps(titles))
        else:
            from ..show.console import show_pairs, stdout_console

            show_pairs(titles, stdout_console())


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
