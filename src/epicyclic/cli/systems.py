"""The command `epicyclic systems`: the ready drives, and the model file of one."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from ..errors import ModelError
from ..results.files import write_text
from .command import file_name
from .console import complain, on_stdout, reported, target_of

__all__ = ["systems"]


def systems(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="Print the model file of this drive.", show_default=False)
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print names and titles as JSON.")] = False,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", parser=file_name, metavar="FILE", help="Copy the model file of NAME (.toml)."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace FILE where there is one.")] = False,
) -> None:
    """The ready drives: names that every verb takes in place of a model file; with a name, its file."""
    with reported():
        if name is not None:
            _file_of(name, output, force=force, as_json=as_json)
        elif output is not None:
            raise ModelError("is missing", path="NAME", allowed="the name of a ready drive, before -o FILE")
        else:
            _list(as_json=as_json)


def _file_of(name: str, output: Path | None, *, force: bool, as_json: bool) -> None:
    """Print or copy the model file of a drive."""
    from ..document.drives import drive_text

    if as_json:
        raise ModelError("prints names and titles only", path="--json", allowed=f"epicyclic systems {name}, without it")
    text = drive_text(name)
    if output is None:
        with on_stdout():
            typer.echo(text.encode("utf-8"), nl=False)  # whatever the encoding of stdout, TOML is UTF-8
        return
    if not force and (output.exists() or output.is_symlink()):
        raise ModelError("is there already", path="--output", given=str(output), allowed="another name, or --force")
    target_of(output, (".toml",))
    write_text(output, text)
    complain(f"written: {output}")


def _list(*, as_json: bool) -> None:
    """Print names and titles."""
    from ..document.drives import drive_titles

    titles = drive_titles()
    if as_json:
        with on_stdout():
            typer.echo(json.dumps(titles))
        return
    from ..show.console import show_pairs, stdout_console

    with on_stdout():
        show_pairs(titles, stdout_console())
