"""The verb sharing."""

from typing import TYPE_CHECKING, Annotated, Literal

from .options import Cycles, Of, RelativeSpeed, Samples, Turns
from .record import Option, Progress, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ..studies.source import Overrides, Source

__all__ = ["VERB", "sharing"]


@bounded
def sharing(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    method: Annotated[
        Literal["steady", "superposition", "static"], Option("Vibrating, every frequency alone, or at rest.")
    ] = "steady",
    cycles: Cycles = None,
    turns: Turns = None,
    of: Of = None,
    samples: Samples = None,
    relative_speed: RelativeSpeed = 1.0,
    stored_cycles: Annotated[
        int | None, Option("Mesh cycles of the forces kept in the result.", least=1, default="at most 64")
    ] = None,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """Load-sharing coefficients, each by its named definition.

    Raises
    ------
    ModelError : the model or an option is wrong; no load; no damping.  ConvergenceError : the method did not converge.
    """
    from ..analyses.sharing.sharing import sharing as run
    from ..studies.source import system_of

    return run(
        system_of(source, overrides=overrides),
        method=method,
        cycles=cycles,
        turns=turns,
        of=of,
        samples=samples,
        relative_speed=relative_speed,
        stored_cycles=stored_cycles,
        progress=progress,
    )


VERB = Verb(run=sharing, gives=("sharing",), examples=({"cycles": 2},), in_report=60)
