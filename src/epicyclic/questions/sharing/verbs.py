"""The verb sharing."""

from typing import TYPE_CHECKING, Annotated, Literal

from ...errors import ModelError
from ...verbs.options import MOST_SPEED, Cycles, Limit, Of, Samples, Turns, relative, train_and_system
from ...verbs.record import Option, Progress, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Overrides, Source


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
    relative_speed: Annotated[
        float | str | None,
        Option(
            'Speed per operating speed, or e.g. "20 Hz", "50 rpm", "50 %"; of a train that vibrates.',
            least=0,
            most=MOST_SPEED,
            default="1",
        ),
    ] = None,
    stored_cycles: Annotated[
        int | None,
        Option("Mesh cycles of the forces kept in the result.", least=1, most=1_000_000, default="at most 64"),
    ] = None,
    limit: Limit = None,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """Load-sharing coefficients, each by its named definition.

    Raises
    ------
    ModelError : the model or an option is wrong; no load; no damping.  ConvergenceError : the method did not converge.
    """
    if method == "static" and relative_speed is not None:
        raise ModelError("moves nothing at rest", path="relative_speed", given=relative_speed, allowed="another method")
    from .sharing import sharing as run

    train, system = train_and_system(source, overrides)
    return run(
        system,
        method=method,
        cycles=cycles,
        turns=turns,
        of=of,
        samples=samples,
        relative_speed=1.0 if relative_speed is None else relative(relative_speed, system, train),
        stored_cycles=stored_cycles,
        limit=limit,
        progress=progress,
    )


VERBS = (Verb(run=sharing, gives=("sharing",), examples=({"cycles": 2},), in_report=60),)
