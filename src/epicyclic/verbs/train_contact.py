"""The verb train_contact."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from .options import RANGE_LOADS, ChosenSlices, Corner, LinearAt, LoadPoints, Of, Turns
from .parsing import load_per_length, loads_of
from .record import Option, Progress, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source


@bounded
def train_contact(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    loads: Annotated[
        Sequence[float] | str | None,
        Option('Further torques, relative to the operating ones: "0..1.5" or "0.5, 2".', default="0.1 to 1.5"),
    ] = None,
    load_points: LoadPoints = None,
    cycles: Annotated[int | None, Option("Length of the record in mesh cycles.", least=1, most=1_000_000)] = 1,
    turns: Turns = None,
    of: Of = None,
    samples: Annotated[
        int | None,
        Option(
            "Even instants per mesh cycle or turn.", least=1, most=100_000, default="doubled until the tolerance holds"
        ),
    ] = None,
    slices: ChosenSlices = None,
    tolerance: Annotated[
        float,
        Option("Relative error of the largest load per length and of K_gamma, where instants or slices are not given."),
    ] = 0.01,
    corner: Corner = False,
    linear_at: LinearAt = None,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """Tooth contact of all meshes at once, in the equilibrium of the train: load along the faces, K_Hbeta, K_gamma.

    Every mesh is misaligned by its own tilt and twist, and branches and sides share the load as the train lets them.

    Raises
    ------
    ModelError : the model or an option is wrong; no torque, no face width.  ConvergenceError : no equilibrium.
    """
    factors = loads_of(loads, load_points, RANGE_LOADS)
    from ..engine.source import train_of
    from ..questions.flanks.train_contact import train_contact as run

    return run(
        train_of(source, overrides=overrides),
        cycles=cycles,
        turns=turns,
        of=of,
        samples=samples,
        slices=slices,
        tolerance=tolerance,
        linear_at=None if linear_at is None else load_per_length(linear_at, "linear_at"),
        corner=corner,
        progress=progress,
        **({} if factors is None else {"factors": factors}),
    )


VERB = Verb(
    run=train_contact, gives=("train_contact",), examples=({"samples": 4, "slices": 2, "loads": (1.0,)},), drawing=True
)
