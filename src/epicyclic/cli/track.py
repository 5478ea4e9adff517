"""The command `epicyclic track`: natural frequencies along a number of the model, crossings and veerings told apart.

Depends on: console, terminal, studies, results, report, imported when used.
"""

from __future__ import annotations

from typing import Annotated, Any

import typer

from .options import Json, Model, Output, Sets, run_verb

__all__ = ["track"]


def track(
    model: Model,
    over: Annotated[
        str, typer.Option("--over", metavar="PATH", help="The number that is moved, PATH[2] for an entry of a list.")
    ],
    sets: Sets = None,
    as_json: Json = False,
    output: Output = None,
    start: Annotated[
        str | None,
        typer.Option("--from", help='First value, as the file says it: "1e8 N/m".', show_default="half of it"),
    ] = None,
    stop: Annotated[str | None, typer.Option("--to", help="Last value.", show_default="twice")] = None,
    points: Annotated[
        int, typer.Option("--points", min=3, max=10_000, help="Values to begin with; more where modes meet.")
    ] = 41,
    modes: Annotated[
        int | None, typer.Option("--modes", min=1, help="How many modes, from the lowest.", show_default="all")
    ] = None,
) -> None:
    """Natural frequencies along a number of the model, each mode followed; where they cross and where they veer."""
    options: dict[str, Any] = {"over": over, "start": start, "stop": stop, "points": points, "modes": modes}
    run_verb("track", model, sets, as_json, output, **options)
