"""The command `epicyclic export`: a train as a REXS file, and the list of what the file does not carry."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..rexs.file import SUFFIXES
from .command import Model, Sets, file_name
from .console import complain, on_stdout, parsed_overrides, reported, require_stdout, target_of

if TYPE_CHECKING:
    from ..rexs_export.export import RexsExport

__all__ = ["export"]


def export(
    model: Model,
    output: Annotated[
        Path,
        typer.Option("-o", "--output", parser=file_name, metavar="FILE", help="The file: .rexs, .rexsj or .rexsz."),
    ],
    sets: Sets = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what is not carried as JSON on stdout.")] = False,
) -> None:
    """A REXS file of a train, version 1.7, and what of the model it does not carry."""
    with reported():
        _export(model, output, sets, as_json=as_json)


def _export(model: str, output: Path, sets: list[str] | None, *, as_json: bool) -> None:
    target_of(output, SUFFIXES)
    require_stdout()
    from ..rexs_export.export import write_rexs

    found = write_rexs(model, output, overrides=parsed_overrides(sets))
    complain(f"written: {output}")
    with on_stdout():
        if as_json:
            dropped = [{"path": entry.path, "text": entry.text} for entry in found.dropped]
            counts = {"components": len(found.file.components), "relations": len(found.file.relations)}
            typer.echo(json.dumps({"version": found.file.version, **counts, "dropped": dropped}))
        else:
            _print(found)


def _print(found: RexsExport) -> None:
    from ..show.console import stdout_console

    console = stdout_console()
    file = found.file
    head = f"REXS {file.version}: {len(file.components)} components, {len(file.relations)} relations"
    console.print(head, style="bold", markup=False)
    console.print(f"\nNot carried ({len(found.dropped)})", style="bold", markup=False)
    for entry in found.dropped:
        console.print(f"  {entry.path}: {entry.text}", markup=False, highlight=False, soft_wrap=True)
