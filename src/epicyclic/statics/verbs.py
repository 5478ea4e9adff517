"""The verb static."""

from typing import TYPE_CHECKING

from ..options import Progress
from ..verbs.record import Verb, takes
from . import StaticOptions

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Drive


@takes(StaticOptions)
def static(drive: "Drive", options: StaticOptions, progress: Progress | None = None) -> "xr.Dataset":
    """Static equilibrium over the record; the teeth can only push.

    Of a locked train angles from mid-backlash, play and torsional stiffness.

    Raises
    ------
    ModelError : the model or an option is wrong, or a load that nothing holds.  ConvergenceError : no equilibrium.
    """
    from .static import static as run

    return run(drive.system, options, progress=progress)


VERBS = (Verb(run=static, gives=("static",), examples=({"cycles": 2},)),)
