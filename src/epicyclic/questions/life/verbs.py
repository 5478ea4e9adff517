"""The verb life."""

from typing import TYPE_CHECKING

from ...verbs.record import Verb, takes
from . import LifeOptions

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr

    from ...engine.source import Drive


@takes(LifeOptions, joint=True)
def life(drive: "Drive", options: LifeOptions, progress: "Callable[[float], None] | None" = None) -> "xr.Dataset":
    """Life of the rolling bearings that the drawing states by their parts, under static forces, over load cases.

    Forces count over a turn of the slowest body, with weight, run-outs and the loads of the file.  All load cases are
    summed by their shares of the time.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : the model or an option is wrong; no bearing is stated by its parts; a train that does not turn.
    ConvergenceError : no equilibrium.
    """
    from ...verbs.cases import duty_of
    from .life import life as run

    return run(duty_of(drive) or drive.train, options, progress=progress)


EXAMPLE_PARTS = {
    "type": "cylindrical roller",
    "rows": 2,
    "row_distance": "0.1 m",
    "elements": 17,
    "element_diameter": "40 mm",
    "element_length": "80 mm",
    "pitch_diameter": "240 mm",
    "viscosity_ratio": 1.5,
    "contamination": 0.6,
}
_EXAMPLE = {
    "instants": 32,
    "overrides": {f"stages.main.planet.bearing.{key}": one for key, one in EXAMPLE_PARTS.items()},
}

VERBS = (Verb(run=life, gives=("life",), drawing=True, in_report=64, examples=(_EXAMPLE,)),)
