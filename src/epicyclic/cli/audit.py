"""The command `epicyclic audit`: published numbers beside ours."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from .command import file_name
from .console import complain, on_stdout, progress_bar, reported, require_stdout, target_of, write_result

__all__ = ["audit"]

CONTRADICTED, REFUSED = 4, 2


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
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", parser=file_name, metavar="FILE", help="Write the table: .nc or .json."),
    ] = None,
) -> None:
    """Published numbers beside ours, each with a verdict and its reason; exit status 4 where one does not hold.

    A row that needs a package which is not installed is not computed, and fails nothing.  A row that is wrong, or whose
    run is refused, is told; the others are computed, and the exit status is 2 where none of them is contradicted.
    """
    with reported():
        _audit(name, as_json=as_json, output=output)


def _audit(name: str | None, *, as_json: bool, output: Path | None) -> None:
    if output is not None:
        target_of(output, (".nc", ".json"))
    if as_json or output is None:
        require_stdout()
    from ..audits.audit import HOLDS, NOT_COMPUTED, WRONG
    from ..audits.audit import audit as run

    with progress_bar(f"audit {name or 'of all ready drives'}") as step:
        result = run(name, progress=step)
    if output is not None:
        write_result(result, output)
    said = json.loads(result.attrs["warnings"])
    if as_json:
        from ..results.dataset import to_json

        with on_stdout():
            typer.echo(to_json(result))
    elif output is None:
        from ..show.console import show, stdout_console

        with on_stdout():
            show(result, stdout_console())
    for text in said if as_json or output is not None else ():
        complain(text)
    outcomes = [str(outcome) for outcome in result.outcome.values]
    if any(outcome != HOLDS and not outcome.startswith((NOT_COMPUTED, WRONG)) for outcome in outcomes):
        raise typer.Exit(CONTRADICTED)
    if any(outcome.startswith(WRONG) for outcome in outcomes):
        raise typer.Exit(REFUSED)
