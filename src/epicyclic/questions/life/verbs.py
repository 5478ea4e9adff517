"""The verb life."""

from functools import partial
from typing import TYPE_CHECKING

from ...options import Progress
from ...verbs.record import Verb, takes
from . import EXAMPLE, LifeOptions

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Drive, Overrides


@takes(LifeOptions, joint=True)
def life(drive: "Drive", options: LifeOptions, progress: Progress | None = None) -> "xr.Dataset":
    """Life of the rolling bearings that the drawing states by their parts, under static forces, over load cases.

    Forces count over the turns of all bodies, with weight, run-outs and the loads of the file, at rest or of the steady
    vibration.  All load cases are summed by their shares of the time.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : the model or an option is wrong; no bearing is stated by its parts; a train that does not turn.
    ConvergenceError : no equilibrium.
    """
    from .life import with_changes

    if not options.changes:
        return _lives(drive, options, {}, progress)
    return with_changes(_lives(drive, options, {}), partial(_lives, drive, options), progress)


def _lives(
    drive: "Drive", options: LifeOptions, changes: "Overrides", progress: Progress | None = None
) -> "xr.Dataset":
    """Lives of a drive with changes laid over its model, over its one point or all load cases."""
    from ...verbs.cases import duty_of
    from .life import life as run

    changed = drive.changed(changes) if changes else drive
    return run(duty_of(changed) or changed.train, options, progress=progress)


_EXAMPLES = ({"instants": 32, **EXAMPLE}, {"instants": 8, "forces": "steady", "changes": True, **EXAMPLE})

VERBS = (Verb(run=life, gives=("life",), drawing=True, in_report=64, examples=_EXAMPLES),)
