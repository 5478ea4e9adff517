"""Output: the gearbox seen from one shaft, the others locked; stiffness, hysteresis, lost motion, kinematic error.

Options of its verb.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from ...options import Option

FIGURES = {"output": ("torque-angle", "kinematic-error")}
"""Kind of result -> names of its figures."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputOptions:
    """Options of what a gearbox is at one of its shafts.

    shaft, held : members as `[operation]` names them.  rated : size of the torque [N m].
    share, backlash_share : torques per rated torque at which angles are read [1].
    """

    shaft: Annotated[
        str | None, Option("Shaft that is seen, e.g. main.carrier.", metavar="MEMBER", default="the output")
    ] = None
    held: Annotated[
        Sequence[str] | None,
        Option("Another shaft that is locked; may be repeated.", metavar="MEMBER", default="every other port"),
    ] = None
    rated: Annotated[
        float | None,
        Option(
            'Rated torque [N m], "20 N m".', above=0, default="of operation.rated, else of operation", reads="torque"
        ),
    ] = None
    share: Annotated[float, Option("Torque per rated torque of the lost motion.", above=0, most=1, reads="share")] = (
        0.03
    )
    backlash_share: Annotated[
        float, Option("Torque per rated torque of the backlash.", above=0, most=1, reads="share")
    ] = 0.005
    points: Annotated[int, Option("Torques from zero to rated torque.", least=4, most=2000)] = 40
    phases: Annotated[int, Option("Places in the mesh cycle at which it is locked.", least=1, most=1000)] = 12
    samples: Annotated[int, Option("Trains drawn from [tolerance], a power of two.", least=1, most=2**17)] = 1024
    seed: Annotated[int, Option("The same seed, the same samples.", least=0)] = 1
    friction: Annotated[
        float | None, Option("Of the teeth, for the starting torque.", least=0, most=1, default="none")
    ] = None
