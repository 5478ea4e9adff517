"""Vibration seen by a sensor at a fixed position while planets pass it: lines, families, signal.

Options of its verb.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from ...options import Option, RelativeSpeed

if TYPE_CHECKING:
    from .spectrum import Transfer, Window

FIGURES = {"modulation": ("modulation",)}
"""Kind of result -> names of its figures."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModulationOptions:
    """Options of what a sensor sees.

    stage, body, sensor, through_planet : as of `sensor_position`.  window, width : as of `named_window`.
    floor : relative to the largest line; 0 lists all.  turns : where the carrier stands, of the fastest body of the
        stage.
    """

    stage: Annotated[str | None, Option("Stage whose planets pass.", default="the one whose ring stands")] = None
    sensor: Annotated[float | str, Option("Angle from branch 1 [rad], or a sensor of the model.", reads="sensor")] = 0.0
    body: Annotated[str | None, Option("What it sits on: a member that stands, or housing.", default="the ring")] = None
    direction: Annotated[Literal["radial", "tangential", "axial"], Option("Motion of the ring.")] = "radial"
    window: Annotated[
        "Window | str | Path", Option("hann, gaussian, cos2, cos4, ..., constant, or a CSV file of angle and gain.")
    ] = "hann"
    width: Annotated[
        float | None, Option('Width of the window [rad], or e.g. "120 deg".', default="by the planets", reads="angle")
    ] = None
    transfer: Annotated[
        "Transfer | str | Path | None",
        Option("CSV file of frequency, gain or accelerance, and phase.", default="1 at every frequency"),
    ] = None
    through_planet: Annotated[
        float, Option("Share of the sun mesh's force that reaches the ring.", least=0, most=1000)
    ] = 0.0
    mean_load: Annotated[bool, Option("Hear the mean load passing, too.")] = False
    radius: Annotated[
        float | None,
        Option('Radius of the sensor from the axis [m], or e.g. "400 mm".', default="that of the ring", reads="length"),
    ] = None
    floor: Annotated[float, Option("Leave out lines below this share of the largest.")] = 1e-4
    turns: Annotated[int, Option("Length of the signal in turns of the carrier.", least=1)] = 1
    samples: Annotated[int | None, Option("Instants of the signal.", least=1, default="as its highest line needs")] = (
        None
    )
    relative_speed: RelativeSpeed = 1.0
