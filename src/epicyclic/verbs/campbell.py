"""The verb campbell."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from ..errors import ModelError
from .record import Option, Progress, Verb, bounded
from .speeds import SPEED_HINT

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source


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
    from ..engine.source import system_of
    from ..questions.modes.campbell import campbell as run

    system = system_of(source, overrides=overrides)
    if not system.tones:
        raise ModelError("a Campbell diagram needs a speed", path="operation.speed", allowed=SPEED_HINT)
    speeds = [2 * point / 40 for point in range(41)] if relative_speeds is None else relative_speeds
    return run(system, relative_speeds=speeds, damped=damped, progress=progress)


VERB = Verb(run=campbell, gives=("campbell",), in_report=50)
