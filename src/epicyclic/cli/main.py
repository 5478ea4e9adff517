"""The command line: a command for every verb, and those that are no verbs.  Computes nothing.

    epicyclic VERB MODEL [--set PATH=VALUE ...] [--json] [--figure NAME] [-o FILE]

Exit status: 0; 1 a fault of the program; 2 the input is wrong; 3 no convergence; 4 an audit contradicted;
130 stopped with Ctrl-C.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from ..results.files import write_text
from ..verbs.record import verbs
from .command import Commands, Json, Model, Output, Sets, command, file_name
from .commands import app as cockpit
from .commands import audit, compare, explain, report, show, study, systems
from .new import export, import_rexs, new
from .output import collect_again, figure_option, on_stdout, open_streams, parsed_overrides, reported, target_of

app = typer.Typer(
    name="epicyclic",
    help="Epicyclic gear trains: modes, load sharing and response, from what stands on the drawing.",
    cls=Commands,
    add_completion=True,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["--help", "-h"]},
)


def main() -> None:
    """Run the command line.  Its matrices are small: other cores compute other points, not parts of one product."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("MKL_NUM_THREADS", "1")
    open_streams()
    collect_again()
    app(prog_name="epicyclic")  # completion is installed for that name, also where Python runs the package


@app.callback(invoke_without_command=True)
def _root(version: Annotated[bool, typer.Option("--version", help="Print the version and stop.")] = False) -> None:
    if version:
        from ..results.files import package_version

        typer.echo(f"epicyclic {package_version()}")
        raise typer.Exit


def check(
    model: Model,
    resolved: Annotated[
        bool, typer.Option("--resolved", help="Write the model with everything filled in: a model file again.")
    ] = False,
    everything: Annotated[
        bool, typer.Option("--all", help="Print every table: bodies, gears, links, deviations, the origin of values.")
    ] = False,
    sets: Sets = None,
    as_json: Json = False,
    figure: Annotated[list[str] | None, figure_option(["check"])] = None,
    output: Output = None,
) -> None:
    """Ratio, speeds, torques, phases on one screen; every derived value and where it came from with --all."""
    if resolved:
        with reported():
            _write_resolved(model, sets, output)
    else:
        run = command(verbs()["check"])
        run(model=model, sets=sets, as_json=as_json, figure=figure, output=output, whole=everything)


def _write_resolved(model: str, sets: list[str] | None, output: Path | None) -> None:
    from ..document.writer import model_text
    from ..train.resolution import load, resolved_document

    if output is not None:
        target_of(output, (".toml",))
    text = model_text(resolved_document(load(model, overrides=parsed_overrides(sets))))
    if output is None:
        _print_file(text)
    else:
        write_text(output, text)


def _print_file(text: str) -> None:
    """Print the text of a file, in UTF-8 whatever the encoding of stdout: escapes of a terminal are none of TOML."""
    with on_stdout():
        typer.echo(text.encode("utf-8"), nl=False)


for _verb in verbs().values():
    app.command()(check if _verb.name == "check" else command(_verb))
app.command()(audit)
app.command()(study)
app.command("import")(import_rexs)
app.command()(export)
app.command()(compare)
app.command()(explain)
app.command()(report)
app.command()(show)
app.command()(new)
app.command()(cockpit)
app.command()(systems)


@app.command()
def schema(
    output: Annotated[
        Path | None, typer.Option("-o", "--output", parser=file_name, metavar="FILE", help="Write it to a file.")
    ] = None,
) -> None:
    """The JSON Schema of the model file, for editors."""
    with reported():
        from ..document.writer import json_schema_text

        text = json_schema_text()
        if output is None:
            _print_file(text)
        else:
            target_of(output, (".json",))
            write_text(output, text)
