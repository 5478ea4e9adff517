"""The verb static."""

from typing import TYPE_CHECKING

from ..verbs.options import Cycles, Of, Samples, Turns
from ..verbs.record import Progress, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source


@bounded
def static(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    cycles: Cycles = None,
    turns: Turns = None,
    of: Of = None,
    samples: Samples = None,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """Static equilibrium over the record; the teeth can only push.

    Raises
    ------
    ModelError : the model or an option is wrong, or a load that nothing holds.  ConvergenceError : no equilibrium.
    """
    from ..engine.source import system_of
    from .static import static as run

    return run(
        system_of(source, overrides=overrides), cycles=cycles, turns=turns, of=of, samples=samples, progress=progress
    )


VERBS = (Verb(run=static, gives=("static",), examples=({"cycles": 2},)),)
