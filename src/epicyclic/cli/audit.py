"""The command `epicyclic audit`: published numbers beside ours."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .command import file_name
from .console import progress_bar, reported
from .output import FORMATS, put, require_output

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
        typer.Option("-o", "--output", parser=file_name, metavar="FILE", help=f"Write the table: {FORMATS}."),
    ] = None,
) -> None:
    """Published numbers beside ours, each with a verdict and its reason; exit status 4 where one does not hold.

    A row that needs a package which is not installed is not computed, and fails nothing.  A row that is wrong, or whose
    run is refused, is told; the others are computed, and the exit status is 2 where none of them is contradicted.
    """
    with reported():
        _audit(name, as_json=as_json, output=output)


def _audit(name: str | None, *, as_json: bool, output: Path | None) -> None:
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
