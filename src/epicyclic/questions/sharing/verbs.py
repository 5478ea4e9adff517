"""The verb sharing."""

from typing import TYPE_CHECKING

from ...errors import ModelError
from ...options import Progress
from ...verbs.record import RESPONSE, Verb, nondefault, takes
from . import SharingOptions

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Drive


@takes(SharingOptions)
def sharing(drive: "Drive", options: SharingOptions, progress: Progress | None = None) -> "xr.Dataset":
    """Load-sharing coefficients, each by its named definition.

    Raises
    ------
    ModelError : the model or an option is wrong; no load; no damping.  ConvergenceError : the method did not converge.
    """
    if options.method == "static" and (speed := nondefault(options, "relative_speed")):
        allowed = "another method"
        raise ModelError("moves nothing at rest", path="relative_speed", given=speed["relative_speed"], allowed=allowed)
    from .sharing import sharing as run

    return run(drive.system, options, progress=progress)


VERBS = (
    Verb(
        run=sharing,
        gives=("sharing",),
        question="How do planets share the load?",
        line="Load-sharing coefficients by definition.",
        needs=f"{RESPONSE} torque",
        examples=({"cycles": 2},),
        in_report=60,
    ),
)
