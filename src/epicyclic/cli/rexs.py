"""The commands `epicyclic import` and `epicyclic export`: REXS files, with lists of what became of each."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import ModelError
from ..results.files import write_text
from ..rexs.file import SUFFIXES
from .command import Model, Sets, file_name
from .console import complain, complain_of, on_stdout, parsed_overrides, reported, require_stdout, target_of

if TYPE_CHECKING:
    from ..rexs.export import RexsExport
    from ..rexs.import_train import RexsImport
    from ..rexs.stages import Entry

_HEADINGS = {
    "read": "Read from the file",
    "assumed": "Assumed, as the file does not say it",
    "dropped": "Dropped, as the model has no place for it",
}


def import_rexs(
    file: Annotated[str, typer.Argument(metavar="FILE", help="A REXS file: .rexs, .rexsj or .rexsz.")],
    load_case: Annotated[
        int | None, typer.Option("--load-case", metavar="ID", help="Load case whose speeds and loads count.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print what was read, assumed and dropped as JSON on stdout.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", parser=file_name, metavar="FILE", help="Write the model file (.toml)."),
    ] = None,
) -> None:
    """A REXS file as a commented model file, and what of it was read, assumed and dropped."""
    with reported():
        _import(file, load_case, as_json=as_json, output=output)


def _import(file: str, load_case: int | None, *, as_json: bool, output: Path | None) -> None:
    if output is not None:
        target_of(output, (".toml",))
    require_stdout()
    from ..document.document import read
    from ..rexs.import_train import read_rexs, traced

    found = read_rexs(file, load_case=load_case)
    try:
        read(found.document)  # what no model file may hold is refused before anything is written
    except ModelError as error:
        raise traced(error, found) from None
    if output is not None:
        from ..rexs.export import rexs_model_text

        write_text(output, rexs_model_text(found, file))
        complain(f"written: {output}")
    complain_of(found.warnings)
    with on_stdout():
        if as_json:
            typer.echo(json.dumps(_as_tables(found)))
        else:
            _print_import(found)


def _as_tables(found: RexsImport) -> dict[str, Any]:
    """Entries and document as plain tables."""
    keys = ("component", "attribute", "path", "text")
    lists = {kind: [{key: getattr(e, key) for key in keys} for e in getattr(found, kind)] for kind in _HEADINGS}
    return {"version": found.file.version, "title": found.document["title"], **lists}


def _print_import(found: RexsImport) -> None:
    """Print the lists: of what was dropped one line for all components of a type that lost the same."""
    from ..show.console import stdout_console

    console = stdout_console()
    console.print(str(found.document["title"]), style="bold", markup=False, soft_wrap=True)
    types = {component.id: component.type for component in found.file.components}
    for kind, heading in _HEADINGS.items():
        entries: tuple[Entry, ...] = getattr(found, kind)
        console.print(f"\n{heading} ({len(entries)})", style="bold", markup=False)
        for line in _lines(entries, types):
            console.print(line, markup=False, highlight=False, soft_wrap=True)


def _lines(entries: tuple[Entry, ...], types: dict[int, str]) -> list[str]:
    """Lines of entries, those of one type with equal words together."""
    groups: dict[tuple[str, str, str, str], list[int]] = {}
    for entry in entries:
        kind = "" if entry.component is None else types[entry.component]
        groups.setdefault((kind, entry.attribute, entry.path, entry.text), []).extend(
            [] if entry.component is None else [entry.component]
        )
    lines = []
    for (kind, attribute, path, text), ids in groups.items():
        who = f"{kind} {', '.join(map(str, ids))}: " if kind else ""
        where = f"{path} = {text}" if path and text else path or text
        lines.append(f"  {who}{attribute}: {where}")
    return lines


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
    from ..rexs.export import write_rexs

    found = write_rexs(model, output, overrides=parsed_overrides(sets))
    complain(f"written: {output}")
    with on_stdout():
        if as_json:
            dropped = [{"path": entry.path, "text": entry.text} for entry in found.dropped]
            counts = {"components": len(found.file.components), "relations": len(found.file.relations)}
            typer.echo(json.dumps({"version": found.file.version, **counts, "dropped": dropped}))
        else:
            _print_export(found)


def _print_export(found: RexsExport) -> None:
    from ..show.console import stdout_console

    console = stdout_console()
    file = found.file
    head = f"REXS {file.version}: {len(file.components)} components, {len(file.relations)} relations"
    console.print(head, style="bold", markup=False)
    console.print(f"\nNot carried ({len(found.dropped)})", style="bold", markup=False)
    for entry in found.dropped:
        console.print(f"  {entry.path}: {entry.text}", markup=False, highlight=False, soft_wrap=True)
