"""The verb stiffness."""

from typing import TYPE_CHECKING, Annotated

from .record import Option, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source


@bounded
def stiffness(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    samples: Annotated[int, Option("Phases of a mesh cycle.", least=1)] = 256,
) -> "xr.Dataset":
    """Mesh stiffness over a mesh cycle.

    Raises
    ------
    ModelError : the model is wrong, or a System is given, which has no drawing left.
    """
    from ..engine.source import train_of
    from ..questions.flanks.contact import stiffness as run

    return run(train_of(source, overrides=overrides), samples=samples)


VERB = Verb(run=stiffness, gives=("stiffness",), drawing=True, in_report=20)
