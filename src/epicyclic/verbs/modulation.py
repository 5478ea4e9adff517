"""The verb modulation."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from .options import RelativeSpeed
from .record import Option, Verb, bounded
from .sensor_files import quantity, read_transfer, read_window
from .speeds import relative, train_and_system

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source
    from ..questions.modulation.path import Transfer, Window


@bounded
def modulation(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    stage: Annotated[str | None, Option("Stage whose planets pass.", default="the one whose ring stands")] = None,
    sensor: Annotated[float | str, Option('Angle of the sensor from branch 1 [rad], or e.g. "90 deg".')] = 0.0,
    body: Annotated[
        str | None, Option("What it sits on: a member that stands, or housing.", default="the ring")
    ] = None,
    direction: Annotated[Literal["radial", "tangential", "axial"], Option("Motion of the ring.")] = "radial",
    window: Annotated[
        "Window | str | Path",
        Option("hann, gaussian, cos2, cos4, ..., constant, or a CSV file of angle and gain."),
    ] = "hann",
    width: Annotated[
        float | str | None, Option('Width of the window [rad], or e.g. "120 deg".', default="by the planets")
    ] = None,
    transfer: Annotated[
        "Transfer | str | Path | None",
        Option("CSV file of frequency, gain or accelerance, and phase.", default="1 at every frequency"),
    ] = None,
    through_planet: Annotated[
        float, Option("Share of the sun mesh's force that reaches the ring.", least=0, most=1000)
    ] = 0.0,
    mean_load: Annotated[bool, Option("Hear the mean load passing, too.")] = False,
    radius: Annotated[
        float | str | None,
        Option('Radius of the sensor from the axis [m], or e.g. "400 mm".', default="that of the ring"),
    ] = None,
    floor: Annotated[float, Option("Leave out lines below this share of the largest.")] = 1e-4,
    turns: Annotated[int, Option("Length of the signal in turns of the carrier.", least=1)] = 1,
    samples: Annotated[
        int | None, Option("Instants of the signal.", least=1, default="as its highest line needs")
    ] = None,
    relative_speed: RelativeSpeed = 1.0,
) -> "xr.Dataset":
    """Vibration at a fixed place beside the ring: sidebands by family and cause.

    Raises
    ------
    ModelError : the model or an option is wrong; a text without a unit, a file that cannot be read.
    ConvergenceError : no steady motion found.
    """
    from ..questions.modulation.modulation import modulation as run

    train, system = train_and_system(source, overrides)
    return run(
        system,
        relative_speed=relative(relative_speed, system, train),
        stage=stage,
        body=body,
        sensor=quantity(sensor, "angle", "sensor") or 0.0,
        direction=direction,
        window=read_window(window) if _is_file(window) else window,  # type: ignore[arg-type]
        width=quantity(width, "angle", "width"),
        transfer=read_transfer(transfer) if isinstance(transfer, str | Path) else transfer,
        through_planet=through_planet,
        mean_load=mean_load,
        radius=quantity(radius, "length", "radius"),
        floor=floor,
        turns=turns,
        samples=samples,
    )


def _is_file(window: object) -> bool:
    """Whether a window is the path of a table rather than a name."""
    return isinstance(window, Path) or (isinstance(window, str) and window.lower().endswith(".csv"))


VERB = Verb(run=modulation, gives=("modulation",))
