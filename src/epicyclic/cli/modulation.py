"""The command `epicyclic modulation`: what an accelerometer beside the ring sees.

Depends on: console, terminal, studies, results, imported when used.
"""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from .options import Json, Model, Output, RelativeSpeed, Sets, run_verb

__all__ = ["modulation"]


class Direction(StrEnum):
    """Which motion of the ring is felt."""

    radial = "radial"
    tangential = "tangential"
    axial = "axial"


def modulation(
    model: Model,
    sets: Sets = None,
    as_json: Json = False,
    output: Output = None,
    stage: Annotated[
        str | None, typer.Option("--stage", help="Stage whose planets pass.", show_default="the one whose ring stands")
    ] = None,
    sensor: Annotated[
        str, typer.Option("--sensor", help='Angle of the sensor from branch 1, e.g. "90 deg".')
    ] = "0 deg",
    body: Annotated[
        str | None,
        typer.Option("--body", help="What it sits on: a member that stands, or housing.", show_default="the ring"),
    ] = None,
    direction: Annotated[Direction, typer.Option("--direction", help="Motion of the ring.")] = Direction.radial,
    window: Annotated[
        str,
        typer.Option("--window", help="hann, gaussian, cos2, cos4, ..., constant, or a CSV file of angle and gain."),
    ] = "hann",
    width: Annotated[
        str | None, typer.Option("--width", help='Width of the window, e.g. "120 deg".', show_default="by the planets")
    ] = None,
    transfer: Annotated[
        Path | None, typer.Option("--transfer", help="CSV file of frequency, gain or accelerance, and phase.")
    ] = None,
    through_planet: Annotated[
        float, typer.Option("--through-planet", help="Share of the sun mesh's force that reaches the ring.")
    ] = 0.0,
    mean_load: Annotated[bool, typer.Option("--mean-load", help="Hear the mean load passing, too.")] = False,
    floor: Annotated[float, typer.Option("--floor", help="Leave out lines below this share of the largest.")] = 1e-4,
    turns: Annotated[int, typer.Option("--turns", min=1, help="Length of the signal in turns of the carrier.")] = 1,
    relative_speed: RelativeSpeed = 1.0,
) -> None:
    """Vibration at a fixed place beside the ring: sidebands by family and cause."""
    run_verb(
        "modulation",
        model,
        sets,
        as_json,
        output,
        stage=stage,
        sensor=sensor,
        body=body,
        direction=direction.value,
        window=window,
        width=width,
        transfer=transfer,
        through_planet=through_planet,
        mean_load=mean_load,
        floor=floor,
        turns=turns,
        relative_speed=relative_speed,
    )
