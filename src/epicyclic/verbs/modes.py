"""The verb modes."""

from typing import TYPE_CHECKING, Annotated

from .options import RelativeSpeed
from .record import Option, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ..studies.source import Overrides, Source

__all__ = ["VERB", "modes"]


@bounded
def modes(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    relative_speed: RelativeSpeed = 0.0,
    damped: Annotated[bool, Option("Solve the damped problem.")] = False,
) -> "xr.Dataset":
    """Natural frequencies, kinds, shapes and energy shares.

    Raises
    ------
    ModelError : the model is wrong; mass or inertia missing; no damping where it is asked for.
    """
    from ..analyses.modes.modal import modal
    from ..studies.source import system_of

    return modal(system_of(source, overrides=overrides), relative_speed=relative_speed, damped=damped)


VERB = Verb(run=modes, gives=("modes",), in_report=40)
