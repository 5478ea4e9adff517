"""Load sharing by named definitions, from static or steady forces.  Options of its verb."""

from dataclasses import dataclass
from typing import Annotated, Literal

from ...options import MOST_SPEED, Cycles, Limit, Of, Option, Samples, Turns

FIGURES = {"sharing": ("sharing", "history", "forces")}
"""Kind of result -> names of its figures."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SharingOptions:
    """Options of the load-sharing coefficients.

    cycles : mesh cycles of the first mesh in the record; the exact hunting period where None and affordable.
    turns : of ``static``, instead, turns of the body `of`; `of` alone: the common period in its turns.
    limit : None: that of the model, see `limits`.
    """

    method: Annotated[
        Literal["steady", "superposition", "static"], Option("Vibrating, every frequency alone, or at rest.")
    ] = "steady"
    cycles: Cycles = None
    turns: Turns = None
    of: Of = None
    samples: Samples = None
    relative_speed: Annotated[
        float,
        Option(
            'Speed per operating speed, or e.g. "20 Hz", "50 rpm", "50 %"; of a train that vibrates.',
            least=0,
            most=MOST_SPEED,
            default="1",
            reads="relative speed",
        ),
    ] = 1.0
    stored_cycles: Annotated[
        int | None,
        Option("Mesh cycles of the forces kept in the result.", least=1, most=1_000_000, default="at most 64"),
    ] = None
    limit: Limit = None
