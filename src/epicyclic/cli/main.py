"""The command line: a command for every verb, and those that are no verbs.  Computes nothing.

    epicyclic VERB MODEL [--set PATH=VALUE ...] [--json] [--figure NAME] [-o FILE]

Exit status: 0; 1 a fault of the program; 2 the input is wrong; 3 no convergence; 4 an audit contradicted;
130 stopped with Ctrl-C.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import ConvergenceError, ModelError
from ..verbs.record import records, verbs
from .command import Commands, command, file_option, run_verb
from .commands import app as cockpit
from .commands import audit, compare, explain, export, import_rexs, new_command, report, show, study, systems
from .output import collect_again, every_case, open_streams, parsed_overrides, put_text, reported

if TYPE_CHECKING:
    import xarray as xr

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


def check(resolved: bool, everything: bool, **given: Any) -> None:
    """Ratio, speeds, torques, phases on one screen; every derived value and where it came from with --all."""
    model, sets, case = given["model"], given["sets"], given["case"]
    if resolved:
        with reported():
            from ..document.writer import model_text
            from ..train.resolution import load, resolved_document

            train = load(model, overrides=parsed_overrides(sets, case))
            return put_text(model_text(resolved_document(train)), given["output"], ".toml")

    def with_efficiency(result: xr.Dataset) -> xr.Dataset:
        """Efficiency of every case beside what the train is in it, where it is known."""
        if not every_case(sets, case):
            return result
        try:
            found = verbs()["efficiency"].run(model, overrides=parsed_overrides(sets, case))
        except (ModelError, ConvergenceError):
            return result
        return result.assign(train_efficiency=found["train_efficiency"])

    run_verb(verbs()["check"], {}, whole=everything, further=with_efficiency, **given)


_OF_CHECK = {
    "resolved": ("--resolved", "Write the model with everything filled in: a model file again."),
    "everything": ("--all", "Print every table: bodies, gears, links, deviations, the origin of values."),
}
_FLAGS = {name: (Annotated[bool, typer.Option(flag, help=words)], False) for name, (flag, words) in _OF_CHECK.items()}

for _verb in records().values():
    app.command()(command(_verb, check, _FLAGS) if _verb.name == "check" else command(_verb))
for _function in (audit, study, import_rexs, export, compare, explain, report, show, new_command(), cockpit, systems):
    app.command("import" if _function is import_rexs else None)(_function)


@app.command()
def schema(
    output: Annotated[Path | None, file_option("Write it to a file.")] = None,
) -> None:
    """The JSON Schema of the model file, for editors."""
    with reported():
        from ..document.writer import json_schema_text

        put_text(json_schema_text(), output, ".json")
