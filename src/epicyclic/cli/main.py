"""The command line: builds a job, runs it, shows it.  Computes nothing.

    epicyclic VERB MODEL [--set PATH=VALUE ...] [--json] [-o FILE]

Exit status: 0; 1 a fault of the program; 2 the input is wrong; 3 no convergence; 4 an audit contradicted;
130 stopped with Ctrl-C.

Depends on: every room, imported when used.
"""

from __future__ import annotations

import json
import os
from enum import Enum, StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from ..results.whole_file import write_text
from .audit import audit
from .console import complain, parsed_overrides, progress_bar, reported, target_of
from .contact import contact
from .modulation import modulation
from .options import (
    Cycles,
    FrameSpeed,
    From,
    Json,
    Model,
    Of,
    Output,
    RelativeSpeed,
    Samples,
    Sets,
    To,
    Turns,
    range_end,
    run_verb,
)
from .relief import relief
from .sensitivity import sensitivity
from .stability import stability
from .track import track
from .transient import transient

__all__ = ["app", "main"]

app = typer.Typer(
    name="epicyclic",
    help="Epicyclic gear trains: modes, load sharing and response, from what stands on the drawing.",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["--help", "-h"]},
)

app.command()(audit)
app.command()(sensitivity)
app.command()(track)
app.command()(contact)
app.command()(modulation)
app.command()(relief)
app.command()(stability)
app.command()(transient)


class Method(StrEnum):
    """How `sharing` finds the mesh forces."""

    steady = "steady"
    superposition = "superposition"
    static = "static"


class Unstable(Enum):
    """What becomes of motions that are not stable."""

    replace = "replace"
    report = "report"
    tell = "tell"  # the old spelling of report, understood for one version
    ignore = "ignore"


def main() -> None:
    """Run the command line.  Its matrices are small: more than one BLAS thread only burns time."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    app()


@app.callback(invoke_without_command=True)
def _root(version: Annotated[bool, typer.Option("--version", help="Print the version and stop.")] = False) -> None:
    if version:
        from importlib.metadata import version as version_of

        typer.echo(f"epicyclic {version_of('epicyclic')}")
        raise typer.Exit


@app.command()
def check(
    model: Model,
    sets: Sets = None,
    as_json: Json = False,
    output: Output = None,
    resolved: Annotated[
        bool, typer.Option("--resolved", help="Write the model with everything filled in: a model file again.")
    ] = False,
) -> None:
    """Speeds, torques, geometry, phases; every derived value and where it came from."""
    if resolved:
        with reported():
            _write_resolved(model, sets, output)
    else:
        run_verb("check", model, sets, as_json, output)


def _write_resolved(model: str, sets: list[str] | None, output: Path | None) -> None:
    from ..model.toml_writer import to_toml
    from ..resolve import load
    from ..resolve.resolved_document import resolved_document

    text = to_toml(resolved_document(load(model, overrides=parsed_overrides(sets))))
    if output is None:
        typer.echo(text, nl=False)
    else:
        target_of(output, (".toml",))
        write_text(output, text)


@app.command()
def modes(
    model: Model,
    sets: Sets = None,
    as_json: Json = False,
    output: Output = None,
    relative_speed: RelativeSpeed = 0.0,
    damped: Annotated[bool, typer.Option("--damped", help="Solve the damped problem.")] = False,
) -> None:
    """Natural frequencies, kinds, shapes and energy shares."""
    run_verb("modes", model, sets, as_json, output, relative_speed=relative_speed, damped=damped)


@app.command()
def campbell(model: Model, sets: Sets = None, as_json: Json = False, output: Output = None) -> None:
    """Natural frequencies over speed, standstill to twice the operating speed."""
    run_verb("campbell", model, sets, as_json, output)


@app.command()
def stiffness(model: Model, sets: Sets = None, as_json: Json = False, output: Output = None) -> None:
    """Mesh stiffness over a mesh cycle."""
    run_verb("stiffness", model, sets, as_json, output)


@app.command()
def static(
    model: Model,
    sets: Sets = None,
    as_json: Json = False,
    output: Output = None,
    cycles: Cycles = None,
    turns: Turns = None,
    of: Of = None,
    samples: Samples = None,
) -> None:
    """Static equilibrium over the record; the teeth can only push."""
    run_verb("static", model, sets, as_json, output, cycles=cycles, turns=turns, of=of, samples=samples)


@app.command()
def steady(
    model: Model,
    sets: Sets = None,
    as_json: Json = False,
    output: Output = None,
    relative_speed: RelativeSpeed = 1.0,
    contact_loss: Annotated[
        bool, typer.Option("--contact-loss", help="Teeth only push; they part and touch again.")
    ] = False,
) -> None:
    """Steady vibration at one speed."""
    run_verb("steady", model, sets, as_json, output, relative_speed=relative_speed, contact_loss=contact_loss)


@app.command()
def sharing(
    model: Model,
    sets: Sets = None,
    as_json: Json = False,
    output: Output = None,
    method: Annotated[
        Method, typer.Option("--method", help="Vibrating, every frequency alone, or at rest.")
    ] = Method.steady,
    cycles: Cycles = None,
    turns: Turns = None,
    of: Of = None,
    samples: Samples = None,
) -> None:
    """Load-sharing coefficients, each by its named definition."""
    record: dict[str, Any] = {"cycles": cycles, "turns": turns, "of": of, "samples": samples}
    run_verb("sharing", model, sets, as_json, output, method=method.value, **record)


@app.command()
def sweep(
    model: Model,
    sets: Sets = None,
    as_json: Json = False,
    output: Output = None,
    start: From = None,
    stop: To = None,
    points: Annotated[
        int | None, typer.Option("--points", min=1, max=100_000, help="Number of speeds.", show_default="200")
    ] = None,
    orders: Annotated[
        int, typer.Option("--orders", min=1, max=100, help="Mesh orders whose amplitudes are told.")
    ] = 12,
    frame_speed: Annotated[
        FrameSpeed, typer.Option("--frame-speed", help="Let the frame turn with the speed, or as at operation.")
    ] = FrameSpeed.kinematic,
    contact_loss: Annotated[
        bool, typer.Option("--contact-loss", help="Teeth part and touch again: run-up, coast-down, all branches.")
    ] = False,
    unstable: Annotated[
        Unstable,
        typer.Option("--unstable", help="With --contact-loss: replace motions that are not stable, or report them."),
    ] = Unstable.replace,
    shaft_orders: Annotated[
        bool, typer.Option(help="With --contact-loss: put run-outs and other shaft orders on top.")
    ] = True,
) -> None:
    """Steady vibration over speed: mesh and bearing forces, K_v, spectra, accelerations.

    A speed in rpm is that of the first member whose speed the model gives; % is of the operating speed.
    """
    with reported():
        low, high = (range_end(text, option) for text, option in ((start, "--from"), (stop, "--to")))
    if unstable is Unstable.tell:
        complain("--unstable tell is now --unstable report")
        unstable = Unstable.report
    options: dict[str, Any] = {"points": points, "frame_speed": frame_speed.value}
    options |= (
        {"contact_loss": True, "unstable": unstable.value, "shaft_orders": shaft_orders}
        if contact_loss
        else {"orders": orders}
    )
    run_verb("sweep", model, sets, as_json, output, start=low, stop=high, **options)


@app.command()
def report(
    model: Model,
    sets: Sets = None,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FILE", help="The HTML file to write.")] = Path(
        "epicyclic-report.html"
    ),
) -> None:
    """Everything the model allows, in one HTML file that opens offline; prints the key figures."""
    _report(model, sets, output)


def _report(model: str, sets: list[str] | None, output: Path) -> None:
    with reported():
        target_of(output, (".html",))
        from ..show.report import write_report
        from ..verbs.report import REPORT_VERBS, STUDIES, run_report

        with progress_bar(f"report {model}", len(REPORT_VERBS) + len(STUDIES) + 1) as step:
            results = run_report(model, overrides=parsed_overrides(sets), progress=step)
            step("figures")
            write_report(output, results)
        _print_report(results, output)


def _print_report(results: dict[str, Any], output: Path) -> None:
    from ..show.console import show_pairs, stdout_console, warnings_of
    from ..show.views import key_figures_of

    console = stdout_console()
    console.print(results["check"].attrs["title"], style="bold", markup=False)
    for text in dict.fromkeys(text for result in results.values() for text in warnings_of(result)):
        console.print(f"warning: {text}", markup=False, style="yellow", soft_wrap=True)
    show_pairs({words: value for value, words in key_figures_of(results)}, console)
    console.print(f"written: {output}", markup=False, soft_wrap=True)


@app.command()
def schema(
    output: Annotated[Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write it to a file.")] = None,
) -> None:
    """The JSON Schema of the model file, for editors."""
    with reported():
        from ..model.json_schema import json_schema_text

        text = json_schema_text()
        if output is None:
            typer.echo(text, nl=False)
        else:
            target_of(output, (".json",))
            write_text(output, text)


@app.command()
def systems(as_json: Annotated[bool, typer.Option("--json", help="Print names and titles as JSON.")] = False) -> None:
    """The ready drives: names that every verb takes in place of a model file."""
    with reported():
        from ..studies.drives import drive_titles

        titles = drive_titles()
        if as_json:
            typer.echo(json.dumps(titles))
        else:
            from ..show.console import show_pairs, stdout_console

            show_pairs(titles, stdout_console())
