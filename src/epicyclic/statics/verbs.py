"""The verb static."""

from typing import TYPE_CHECKING

from ..options import Progress
from ..questions.rating import EXAMPLE
from ..verbs.record import Verb, takes
from . import StaticOptions

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Drive


@takes(StaticOptions)
def static(drive: "Drive", options: StaticOptions, progress: Progress | None = None) -> "xr.Dataset":
    """Static equilibrium over the record; the teeth can only push.

    Of a locked train angles from mid-backlash, play and torsional stiffness.  Of bearings that are stated by their
    parts load zone, stiffness, static safety and frequencies of defects.

    Raises
    ------
    ModelError : the model or an option is wrong, or a load that nothing holds.  ConvergenceError : no equilibrium.
    """
    from ..questions.rating.bearing_state import with_bearings
    from .static import static as run

    result = run(drive.system, options, progress=progress)
    if drive.drawing is None:
        return result
    of_links = (("link_row", "link_force"), ("group_row", "group_row_force"))
    forces = [zip(result[dim].values, result[name].values, strict=True) for dim, name in of_links if name in result]
    return with_bearings(result, drive.drawing, {str(row): force for own in forces for row, force in own})


VERBS = (
    Verb(
        run=static,
        gives=("static",),
        question="How do planets share the load?",
        line="Equilibrium under load, with teeth in contact or apart.",
        needs="equations balance",
        examples=({"cycles": 2}, {"cycles": 1, **EXAMPLE}),
    ),
)
