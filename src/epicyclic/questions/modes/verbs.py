"""The verbs modes and campbell."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from ...errors import ModelError
from ...verbs.options import SPEED_HINT, RelativeSpeed, frequency_band, relative, share, train_and_system
from ...verbs.record import Option, Progress, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Overrides, Source


@bounded
def modes(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    relative_speed: RelativeSpeed = 0.0,
    damped: Annotated[bool, Option("Solve the damped problem.")] = False,
    band: Annotated[
        float | str | None,
        Option(
            'Resonances at most this share from the operating speed alone, e.g. "20 %", or with natural frequencies '
            'in a range, e.g. "500..6000 Hz".',
            default="5 to 130 % of it, those within 20 % marked",
        ),
    ] = None,
) -> "xr.Dataset":
    """Natural frequencies, kinds, shapes and energy shares; the resonances near operation.

    A resonance is a speed at which a mesh order, 1 to 12, meets a natural frequency. Each is listed with the mode, what
    holds most of its energy, whether the order excites the mode, and the mesh force that the mode makes there, from the
    response with linear contact.

    Raises
    ------
    ModelError : the model is wrong; mass or inertia missing; no damping where it is asked for; no such band.
    """
    from ..response.sweep_table import with_resonances
    from .modal import modal

    hertz = frequency_band(band, "band") if isinstance(band, str) and ".." in band else None
    width = None if band is None or hertz is not None else share(band, "band")
    if width is not None and width > 1:
        raise ModelError("more than the operating speed itself", path="band", given=band, allowed='e.g. "20 %" or 0.2')
    train, system = train_and_system(source, overrides)
    result = modal(system, relative_speed=relative(relative_speed, system, train), damped=damped)
    return with_resonances(result, system, band=width, hertz=hertz)


@bounded
def campbell(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    relative_speeds: Annotated[
        Sequence[float] | None,
        Option("(s,) speeds per operating speed [1], in the order to follow.", flag=None, default="0 to 2"),
    ] = None,
    damped: Annotated[bool, Option("Solve the damped problem.")] = False,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """Natural frequencies over speed, standstill to twice the operating speed.

    Raises
    ------
    ModelError : the model is wrong, or says no speed; a speed that is not finite.
    """
    from ...engine.source import system_of
    from .campbell import campbell as run

    system = system_of(source, overrides=overrides)
    if not system.tones:
        raise ModelError("a Campbell diagram needs a speed", path="operation.speed", allowed=SPEED_HINT)
    speeds = [2 * point / 40 for point in range(41)] if relative_speeds is None else relative_speeds
    return run(system, relative_speeds=speeds, damped=damped, progress=progress)


VERBS = (
    Verb(run=modes, gives=("modes",), in_report=40),
    Verb(run=campbell, gives=("campbell",), in_report=50),
)
