"""The command `epicyclic stability`: where the motion of a train grows by itself, over speed and a second parameter.

Depends on: console, studies, imported when used.
"""

from __future__ import annotations

from typing import Annotated, Any

import typer

from ..errors import ModelError
from .console import reported
from .options import FrameSpeed, From, Json, Model, Output, Sets, To, range_end, run_verb

__all__ = ["stability"]


def stability(
    model: Model,
    sets: Sets = None,
    as_json: Json = False,
    output: Output = None,
    start: From = None,
    stop: To = None,
    points: Annotated[
        int | None,
        typer.Option("--points", min=1, max=100_000, help="Number of speeds.", show_default="200, of a map 100"),
    ] = None,
    frame_speed: Annotated[
        FrameSpeed, typer.Option("--frame-speed", help="Let the frame turn with the speed, or as at operation.")
    ] = FrameSpeed.kinematic,
    over: Annotated[
        str | None,
        typer.Option(
            "--over",
            metavar="PATH",
            help="Second parameter of a map: a path of the model file, or variation or damping, a factor.",
        ),
    ] = None,
    values: Annotated[str | None, typer.Option("--values", help='Its values: "0..2", "1 %..5 %" or "1, 2, 5".')] = None,
    value_points: Annotated[
        int, typer.Option("--value-points", min=1, max=10_000, help="Number of values in a range.")
    ] = 21,
) -> None:
    """Floquet multipliers over speed: where the varying mesh stiffness makes vibration grow by itself."""
    options: dict[str, Any] = {"points": points, "frame_speed": frame_speed.value}
    with reported():
        for name, text, option in (("start", start, "--from"), ("stop", stop, "--to")):
            options[name] = range_end(text, option)
        if (over is None) != (values is None):
            raise ModelError("go together", path="--over, --values", allowed="--over damping.modal --values 0.01..0.05")
        if over is not None and values is not None:
            from ..studies.stability import spread

            options |= {"over": over.strip(), "values": spread(values, value_points)}
    run_verb("stability", model, sets, as_json, output, **options)
