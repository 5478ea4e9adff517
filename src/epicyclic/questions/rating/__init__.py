"""Rating: life of rolling bearings, load factors of gears, a load history as load cases.  Options of its verbs.

Life: what the rolling bearings of a gearbox live under the forces that statics finds, over load cases.

Options of its verb.

Load factors: what a gear rating asks of the dynamics, by pair of gears, flank and load case.

Options of its verb.

Load spectrum: a history of torque and speed as load cases, revolutions of the members, cycles of the torque.

Options of its verb.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

from ...options import Option, Tolerance

if TYPE_CHECKING:
    from ...engine.source import Source

FIGURES = {"life": ("load-zones",), "load_factors": (), "spectrum": ("load-spectrum", "rainflow")}
"""Kind of result -> names of its figures."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LifeOptions:
    """Options of the life of bearings.

    instants : over which forces are taken, the next prime number from here on.
    """

    forces: Annotated[
        Literal["static", "steady"], Option("Forces at rest, or of the steady vibration with linear contact.")
    ] = "static"
    instants: Annotated[int, Option("Instants over the turns of all bodies.", least=8, most=20_000)] = 256
    changes: Annotated[
        bool,
        Option("Also with a larger clearance, a larger rating and a floating sun; one more run each."),
    ] = False


# A bearing by its parts in the examples of the verbs that show its state.
EXAMPLE_PARTS = {
    "type": "cylindrical roller",
    "rows": 2,
    "row_distance": "30 mm",
    "elements": 14,
    "element_diameter": "15 mm",
    "element_length": "24 mm",
    "pitch_diameter": "80 mm",
    "viscosity_ratio": 1.5,
    "contamination": 0.6,
}
EXAMPLE = {"overrides": {f"stages.main.planet.bearing.{key}": one for key, one in EXAMPLE_PARTS.items()}}


# Exponents of the torque in a sum of damage by pitting, of the materials that a rating tells apart [iso63366].
PITTING = {"case-hardened": 6.61, "through-hardened": 6.61, "nitrided": 5.709, "nitrocarburised": 15.715}


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadFactorOptions:
    """Options of the load factors.

    exponent : of the equivalent torque; None: that of pitting of the material.  life : time that shares are of [s].
    """

    flanks: Annotated[
        Literal["slices", "contact"], Option("K_Hbeta of the slices of meshes, or all of loaded tooth contact.")
    ] = "slices"
    tolerance: Tolerance = 0.01
    material: Annotated[
        Literal["case-hardened", "through-hardened", "nitrided", "nitrocarburised"],
        Option("Of the flanks, for the exponent."),
    ] = "case-hardened"
    exponent: Annotated[
        float | None,
        Option("Exponent of the equivalent torque.", above=0, most=100, default="6.61, 5.709 or 15.715 by material"),
    ] = None
    life: Annotated[
        float | None,
        Option('Time that all cases stand for [s], e.g. "20000 h".', above=0, default="their durations", reads="time"),
    ] = None


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
