"""The command `epicyclic relief`: the best tip and root relief and lead modification, written as a model file.

Depends on: console, studies, imported when used.
"""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from ..errors import ModelError
from .console import frequency, reported
from .options import Json, Model, Sets, run_verb

__all__ = ["relief"]


class Objective(StrEnum):
    """What is made least."""

    lte = "lte"
    load = "load"
    force_rms = "force_rms"
    force_peak = "force_peak"


def relief(
    model: Model,
    vary: Annotated[
        list[str],
        typer.Option(
            "--vary",
            metavar="[GEAR.]KEY=BOUNDS",
            help='tip_relief.amount="0..40 um", sun.tip_relief.length="0.5..3 mm", tip_relief.shape=linear,parabolic; '
            "without a gear on all flanks alike; one value is set. May be repeated.",
        ),
    ],
    sets: Sets = None,
    as_json: Json = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="FILE", help="Write the model (.toml) or the result (.nc, .json, .html)."
        ),
    ] = None,
    mesh: Annotated[
        list[str] | None,
        typer.Option("--mesh", metavar="NAME", help="A mesh or a pair; may be repeated.", show_default="every mesh"),
    ] = None,
    torque: Annotated[
        str | None, typer.Option("--torque", help='On the first gear of the mesh, e.g. "850 N m"; else as operated.')
    ] = None,
    objective: Annotated[
        list[Objective] | None,
        typer.Option("--objective", help="What is made least; several give a Pareto set.", show_default="lte"),
    ] = None,
    loads: Annotated[
        str | None,
        typer.Option("--loads", help='Loads of lte and load, relative: "0.5..1.25" or "0.5, 1".', show_default="1"),
    ] = None,
    load_points: Annotated[int, typer.Option("--load-points", min=1, max=1000, help="Number of loads in a range.")] = 4,
    start: Annotated[
        str | None, typer.Option("--from", help='Lowest mesh frequency of the dynamic force, e.g. "200 Hz".')
    ] = None,
    stop: Annotated[str | None, typer.Option("--to", help='Highest, e.g. "2 kHz".')] = None,
    points: Annotated[int, typer.Option("--points", min=1, max=10_000, help="Number of speeds.")] = 30,
    population: Annotated[int, typer.Option("--population", min=4, max=100_000, help="Candidates a generation.")] = 60,
    generations: Annotated[int, typer.Option("--generations", min=1, max=100_000, help="Generations.")] = 60,
    seed: Annotated[int, typer.Option("--seed", min=0, help="The same seed, the same search.")] = 1,
    resume: Annotated[
        Path | None,
        typer.Option(
            "--resume", metavar="FILE", help="Record of the search, written as it goes; gone on with if there."
        ),
    ] = None,
    pick: Annotated[
        int | None,
        typer.Option("--pick", min=0, help="Number of the solution to take.", show_default="nearest to all best"),
    ] = None,
    samples: Annotated[int, typer.Option("--samples", min=3, max=10_000, help="Phases of a mesh cycle.")] = 64,
    slices: Annotated[int, typer.Option("--slices", min=1, max=1000, help="Pieces of each face.")] = 20,
    misalignment: Annotated[
        str | None, typer.Option("--misalignment", help='Of the flanks, e.g. "0.1 mrad"; positive opens the right end.')
    ] = None,
    corner: Annotated[bool, typer.Option("--corner", help="Let tips bear beyond the path of contact.")] = False,
) -> None:
    """The best tip and root relief and lead modification of a mesh, or of all meshes of a train."""
    options: dict[str, Any] = {"mesh": mesh or None, "torque": torque, "pick": pick, "resume": resume}
    options |= {"population": population, "generations": generations, "seed": seed}
    options |= {"samples": samples, "slices": slices, "corner": corner}
    if misalignment is not None:
        options["misalignment"] = misalignment
    with reported():
        options["vary"] = dict(_varied(text) for text in vary)
        options["objectives"] = [str(one.value) for one in objective or [Objective.lte]]
        if (start is None) != (stop is None):
            raise ModelError("go together", path="--from, --to", allowed='--from "200 Hz" --to "2 kHz"')
        if start is not None and stop is not None:
            options["speeds"] = frequency(start, "--from"), frequency(stop, "--to")
        options["speed_points"] = points
        if loads is not None:
            from ..studies.tooth_contact import factors_of

            options["factors"] = factors_of(loads, load_points)
    result = run_verb("relief", model, sets, as_json, output, write_model=_model_text, **options)
    if result is not None and result.attrs["stopped"]:
        raise typer.Exit(130)


def _varied(text: str) -> tuple[str, str]:
    name, equals, bounds = text.partition("=")
    if not equals or not name.strip() or not bounds.strip():
        raise ModelError("not bounds", path="--vary", given=text, allowed='tip_relief.amount="0..40 um"')
    return name.strip(), bounds.strip()


def _model_text(result: Any) -> str:
    from ..studies.relief import relief_model

    return relief_model(result)
