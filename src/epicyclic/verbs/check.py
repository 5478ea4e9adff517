"""The verb check."""

from typing import TYPE_CHECKING

from .record import Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source


@bounded
def check(source: "Source", *, overrides: "Overrides | None" = None) -> "xr.Dataset":
    """Speeds, torques, geometry, phases; every derived value and where it came from.

    Raises
    ------
    ModelError : the model is wrong, or a System is given, which has no drawing left.
    """
    from ..engine.source import train_of
    from ..questions.check.check import check as run

    return run(train_of(source, overrides=overrides))


VERB = Verb(run=check, gives=("check",), drawing=True, in_report=10)
