"""Load spectrum: a history of torque and speed as load cases, revolutions of the members, cycles of the torque.

Options of its verb.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from ...options import Option

if TYPE_CHECKING:
    from ...engine.source import Source

Bins = int | Sequence[float]
Given = Bins | str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SpectrumOptions:
    """Options of a load spectrum.

    member : path in the model file, ``carrier`` or ``main.carrier``; needed with a train, and to write load cases.
    time, torque, speed, weight : headings of the columns without their units; the weight is the time or share of a bin.
    torque_bins, speed_bins : about how many, of one round width, or edges [N m, rad/s]; zero is always an edge between
        values of both signs.
    """

    train: Annotated[
        "Source | None", Option("Train whose members turn with it: a model file or ready drive.", metavar="MODEL")
    ] = None
    member: Annotated[str | None, Option("Member that torque and speed are of, e.g. main.carrier.")] = None
    time: Annotated[str | None, Option("Column of the time.", default="time", metavar="NAME")] = None
    torque: Annotated[str | None, Option("Column of the torque.", default="torque", metavar="NAME")] = None
    speed: Annotated[str | None, Option("Column of the speed.", default="speed", metavar="NAME")] = None
    weight: Annotated[str | None, Option("Column of the hours or share of bins.", default="duration, hours, share")] = (
        None
    )
    torque_bins: Annotated[
        Bins,
        Option('Bins of torque: how many, about, or edges [N m], "0, 2, 5 kN m".', accepts=Given, reads="torque bins"),
    ] = 10
    speed_bins: Annotated[
        Bins, Option('The same of speed [rad/s], or "0, 8, 12 rpm".', accepts=Given, reads="speed bins")
    ] = 4
    exponent: Annotated[
        float,
        Option("Exponent of damage: 6.61 pitting of hard flanks, 3 ball, 3.333 roller bearings.", above=0, most=100),
    ] = 6.61
    life: Annotated[
        float | None,
        Option('Time it stands for [s], e.g. "20000 h"; shares need it.', above=0, default="its own", reads="time"),
    ] = None
    gap: Annotated[
        float | None,
        Option('Longest time between rows [s], e.g. "9 min".', above=0, default="10 times the median", reads="time"),
    ] = None
