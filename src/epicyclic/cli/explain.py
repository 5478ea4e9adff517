"""``epicyclic explain WORD``: what a path, a variable, a warning, a verb or a figure means."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from .completion import explained_names
from .console import on_stdout, reported

__all__ = ["explain"]

Word = Annotated[
    str,
    typer.Argument(
        metavar="WORD",
        help="A path of the model file, a variable of a result, the code of a warning, a verb or a figure.",
        autocompletion=explained_names,
    ),
]


def explain(
    word: Word, as_json: Annotated[bool, typer.Option("--json", help="Print the explanations as JSON.")] = False
) -> None:
    """What a path of the model file, a variable, a warning, a verb or a figure means."""
    with reported():
        _explain(word, as_json=as_json)


def _explain(word: str, *, as_json: bool) -> None:
    from ..terms.explain import explain as run

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
