"""Stability of the periodic motion: Floquet multipliers, boundaries by averaging.  Options of its verb."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from ...options import Folder, FrameSpeed, MeshFrequencies, Option, RelativeSpeeds, Resume, Start, Stop

FIGURES = {"stability": ("stability",)}
"""Kind of result -> names of its figures."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StabilityOptions:
    """Options of stability over speed, or of a map over speed and a second parameter."""

    start: Start = None
    stop: Stop = None
    points: Annotated[int | None, Option("Number of speeds.", least=1, most=100_000, default="200, of a map 100")] = (
        None
    )
    range: Annotated[
        Literal["operation", "modes"] | None,
        Option("Speeds about operation, 5 to 130 %, or to 1.2 times the modes.", default="modes"),
    ] = None
    mesh_frequency: MeshFrequencies = None
    relative_speed: RelativeSpeeds = None
    frame_speed: FrameSpeed = "kinematic"
    variation: Annotated[
        float | None, Option("Factor of the stiffness variation of all meshes.", least=0, most=1000, default="1")
    ] = None
    damping: Annotated[float | None, Option("Factor of all damping.", least=0, most=1000, default="1")] = None
    over: Annotated[
        str | None,
        Option(
            "Second parameter of a map: a path of the model file, or variation or damping, a factor.", metavar="PATH"
        ),
    ] = None
    values: Annotated[Sequence[Any] | str | None, Option('Its values: "0..2", "1 %..5 %" or "1, 2, 5".')] = None
    value_points: Annotated[int, Option("Number of values in a range.", least=1, most=10_000)] = 21
    folder: Folder = None
    resume: Resume = False
