"""Annotated types of keywords that several verbs share, so that one word has one meaning and one help text."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from .record import Option

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

RANGE_LOADS = 7
"""Loads of a range where their number is not given: enough to draw a curve through."""
# beyond any drive; squares of much more are no numbers
MOST_SPEED = 10_000
# mesh cycles or turns, and instants of one: what they cost together is asked where the train is known
_MOST_CYCLES, _MOST_SAMPLES = 10**12, 1_000_000

# one speed
RelativeSpeed = Annotated[
    float | str,
    Option(
        "Speed per operating speed, 0 standstill, 1 the operating point; or a mesh frequency or speed with its unit: "
        '"20 Hz", "50 rpm", "50 %".',
        least=0,
        most=MOST_SPEED,
    ),
]

# ranges of speed
Start = Annotated[
    float | str | None,
    Option('Lowest mesh frequency [Hz] or speed: "20 Hz", "50 rpm", "50 %".', default="by the range"),
]
Stop = Annotated[float | str | None, Option('Highest, e.g. "0.6 kHz", "2000 rpm".', default="by the range")]
Range = Annotated[
    Literal["operation", "modes"] | None,
    Option("Speeds about operation, 5 to 130 %, or to 1.2 times the modes.", default="operation"),
]
MeshFrequencies = Annotated["ArrayLike | None", Option("(P,) mesh frequencies of the first mesh [Hz].", flag=None)]
RelativeSpeeds = Annotated["ArrayLike | None", Option("(P,) speeds per operating speed [1].", flag=None)]
FrameSpeed = Annotated[
    Literal["kinematic", "operating"], Option("Let the frame turn with the speed, or as at operation.")
]

# runs that are stopped and go on
Folder = Annotated[str | Path | None, Option("Folder that keeps what is done while the run goes on.", flag=None)]
Resume = Annotated[bool, Option("Continue a run that was stopped; needs the same -o and options.")]

# records
Cycles = Annotated[
    int | None, Option("Length of the record in mesh cycles.", least=1, most=_MOST_CYCLES, default="chosen")
]
Turns = Annotated[int | None, Option("Length in turns of a body (--of).", least=1, most=_MOST_CYCLES, default="chosen")]
Of = Annotated[str | None, Option("Count turns of this body, e.g. main/sun.", metavar="BODY")]
Samples = Annotated[
    int | None, Option("Instants per mesh cycle or turn.", least=1, most=_MOST_SAMPLES, default="chosen")
]

# shaft orders
ShaftOrders = Annotated[bool, Option("Count run-outs and other shaft orders between the mesh orders.")]
ShaftTones = Annotated[
    int | None,
    Option("With --contact-loss: shaft frequencies that are phases of the torus.", least=0, most=3, default="chosen"),
]

# loaded teeth
LoadPoints = Annotated[
    int | None, Option("Number of loads in a range (--loads).", least=1, most=10_000, default=str(RANGE_LOADS))
]
ChosenSlices = Annotated[
    int | None, Option("Pieces of each face.", least=1, most=1000, default="doubled until the tolerance holds")
]
Tolerance = Annotated[
    float,
    Option(
        "Relative error of transmission error (peak to peak), largest load and pressure, where phases or slices "
        "are not given."
    ),
]
Corner = Annotated[bool, Option("Let tips bear beyond the path of contact.")]
LinearAt = Annotated[
    float | str | None,
    Option(
        'Load per length [N/m], or e.g. "200 N/mm", at which the flanks\' contact is made linear.',
        above=0,
        default="Hertz",
    ),
]
Misalignment = Annotated[float | str, Option('Of the flanks [rad], or e.g. "0.1 mrad"; positive opens the right end.')]
