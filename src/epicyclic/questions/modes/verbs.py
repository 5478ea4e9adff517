"""The verbs modes and campbell."""

from typing import TYPE_CHECKING

from ...errors import ModelError
from ...options import Progress
from ...verbs.options import SPEED_HINT, frequency_band, share
from ...verbs.record import Verb, takes
from . import CampbellOptions, ModesOptions

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Drive


@takes(ModesOptions)
def modes(drive: "Drive", options: ModesOptions) -> "xr.Dataset":
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

    band = options.band
    hertz = frequency_band(band, "band") if isinstance(band, str) and ".." in band else None
    width = None if band is None or hertz is not None else share(band, "band", most=1.0)
    result = modal(drive.system, relative_speed=options.relative_speed, damped=options.damped)
    return with_resonances(result, drive.system, band=width, hertz=hertz)


@takes(CampbellOptions, turning=True)
def campbell(drive: "Drive", options: CampbellOptions, progress: Progress | None = None) -> "xr.Dataset":
    """Natural frequencies over speed, standstill to twice the operating speed.

    Raises
    ------
    ModelError : the model is wrong, or says no speed; a speed that is not finite.
    """
    from .campbell import campbell as run

    if not drive.system.tones:
        raise ModelError("a Campbell diagram needs a speed", path="operation.speed", allowed=SPEED_HINT)
    speeds = options.relative_speeds
    if speeds is None:
        speeds = [2 * point / 40 for point in range(41)]
    return run(drive.system, relative_speeds=speeds, damped=options.damped, progress=progress)


VERBS = (
    Verb(
        run=modes,
        gives=("modes",),
        question="How does it vibrate?",
        line="Natural frequencies, kinds of modes, resonances near operation.",
        needs="equations inertia",
        in_report=40,
    ),
    Verb(
        run=campbell,
        gives=("campbell",),
        question="How does it vibrate?",
        line="Natural frequencies over speed.",
        needs="equations inertia speed",
        in_report=50,
    ),
)
