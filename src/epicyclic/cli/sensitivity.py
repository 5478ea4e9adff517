"""The command `epicyclic sensitivity`: which number of the model file moves a frequency or a mesh force most.

Depends on: console, terminal, studies, results, report, imported when used.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Any

import typer

from .console import frequency, reported
from .options import Json, Model, Output, Sets, run_verb

__all__ = ["sensitivity"]


class Quantity(StrEnum):
    """What is differentiated."""

    frequency = "frequency"
    force = "force"


def sensitivity(
    model: Model,
    sets: Sets = None,
    as_json: Json = False,
    output: Output = None,
    of: Annotated[
        Quantity, typer.Option("--of", help="Natural frequencies, or the RMS of the dynamic mesh forces.")
    ] = Quantity.frequency,
    mode: Annotated[
        int | None, typer.Option("--mode", help="Rank by this mode, from 1.", show_default="lowest elastic")
    ] = None,
    mesh: Annotated[
        str | None,
        typer.Option("--mesh", help="Rank by this mesh, e.g. main/sun-planet/1.", show_default="largest force"),
    ] = None,
    paths: Annotated[
        list[str] | None,
        typer.Option(
            "--path",
            help="A number of the model, PATH[2] for an entry of a list; may be repeated.",
            show_default="all that move something",
        ),
    ] = None,
    at: Annotated[
        str | None,
        typer.Option("--at", help='Mesh frequency for forces, e.g. "0.6 kHz".', show_default="operating speed"),
    ] = None,
    harmonic: Annotated[
        int | None, typer.Option("--harmonic", help="Amplitude of this mesh order in place of the RMS.")
    ] = None,
    relative_speed: Annotated[
        float | None,
        typer.Option("--relative-speed", help="Speed per operating speed; gyroscopic terms for frequencies."),
    ] = None,
) -> None:
    """Which number of the model moves a natural frequency or a mesh force most: percent per percent, ranked."""
    with reported():
        hertz = None if at is None else frequency(at, "--at")
    options: dict[str, Any] = {"of": of.value, "mode": mode, "mesh": mesh, "paths": paths or None}
    options |= {"mesh_frequency": hertz, "harmonic": harmonic, "relative_speed": relative_speed}
    run_verb("sensitivity", model, sets, as_json, output, **options)
