"""The verb track."""

from typing import TYPE_CHECKING, Annotated

from .record import Option, Progress, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source


@bounded
def track(
    source: "Source",
    *,
    over: Annotated[str, Option("The number that is moved, PATH[2] for an entry of a list.", metavar="PATH")],
    overrides: "Overrides | None" = None,
    start: Annotated[
        float | str | None,
        Option('First value, as the file says it: "1e8 N/m".', default="half of it"),
    ] = None,
    stop: Annotated[float | str | None, Option("Last value.", default="twice")] = None,
    points: Annotated[int, Option("Values to begin with; more where modes meet.", least=3, most=10_000)] = 41,
    modes: Annotated[int | None, Option("How many modes, from the lowest.", least=1, default="all")] = None,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """Natural frequencies along a number of the model, each mode followed; where they cross and where they veer.

    Raises
    ------
    ModelError : the model is wrong; a path that is no number, an empty range, a value the model cannot have.
    """
    from ..engine.source import train_of
    from ..questions.parameters.loci import track as run

    return run(
        train_of(source, overrides=overrides),
        over=over,
        start=start,
        stop=stop,
        points=points,
        modes=modes,
        progress=progress,
    )


VERB = Verb(
    run=track, gives=("track",), examples=({"over": "stages.main.sun.support.radial", "points": 5},), drawing=True
)
