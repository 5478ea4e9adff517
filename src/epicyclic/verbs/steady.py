"""The verb steady."""

from typing import TYPE_CHECKING, Annotated, Literal

from .options import RelativeSpeed, ShaftTones
from .record import Option, Verb, bounded, given, refuse_without
from .speeds import relative, train_and_system

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source


@bounded
def steady(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    relative_speed: RelativeSpeed = 1.0,
    samples: Annotated[
        int | None, Option("Phases of a mesh cycle in the result of linear contact.", least=1, default="64")
    ] = None,
    method: Annotated[
        Literal["exact", "superposition"] | None,
        Option("Of linear contact: coupled, or every frequency alone on the mean system.", default="exact"),
    ] = None,
    contact_loss: Annotated[bool, Option("Teeth only push; they part and touch again.")] = False,
    shaft_orders: Annotated[
        bool | None, Option("With --contact-loss: count run-outs and other shaft orders.", default="yes")
    ] = None,
    shaft_tones: ShaftTones = None,
) -> "xr.Dataset":
    """Steady vibration at one speed.

    Raises
    ------
    ModelError : the model or an option is wrong; no damping, no speed.  ConvergenceError : no steady motion found.
    """
    refuse_without(contact_loss, "contact loss", shaft_orders=shaft_orders, shaft_tones=shaft_tones)
    refuse_without(not contact_loss, "linear contact", samples=samples, method=method)
    train, system = train_and_system(source, overrides)
    speed = relative(relative_speed, system, train)
    if contact_loss:
        from ..questions.contact_loss.steady import contact_steady

        options = given(shaft_orders=shaft_orders, shaft_tones=shaft_tones)
        return contact_steady(system, relative_speed=speed, **options)
    from ..questions.response.steady import steady as run

    return run(system, relative_speed=speed, **given(samples=samples, method=method))


VERB = Verb(run=steady, gives=("steady",), examples=({}, {"contact_loss": True}))
