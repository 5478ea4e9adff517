"""The verb efficiency."""

from typing import TYPE_CHECKING, Annotated, Literal

from ..errors import ModelError
from .record import Option, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source
    from ..questions.flanks.efficiency import Oil

# Viscosity [Pa s] and roughness [m] between which they may be those of oils and tooth flanks.
_RANGES = ((1e-4, 10.0, "0.1 mPa s to 10 Pa s"), (1e-8, 1e-4, "0.01 um to 100 um"))


@bounded
def efficiency(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    friction: Annotated[
        float | None,
        Option("Coefficient of friction of all meshes.", least=0, most=1, default="0.05, or by the oil"),
    ] = None,
    viscosity: Annotated[
        float | str | None,
        Option('Dynamic viscosity of the oil in the meshes [Pa s], or e.g. "20 mPa s".', above=0, default="not used"),
    ] = None,
    roughness: Annotated[
        float | str | None, Option('Mean Ra of the flanks [m], or e.g. "0.6 um".', above=0, default="not used")
    ] = None,
    sharing: Annotated[
        Literal["uniform", "contact"],
        Option("Load along the contact lines: uniform, or that of loaded tooth contact."),
    ] = "uniform",
) -> "xr.Dataset":
    """Power lost in the meshes, and efficiency of the train at its operating point.

    Sliding speed and load along the path of contact give the loss factor of every mesh, the power that it rolls in the
    frame of its carrier the loss. Bearings, seals and oil take more, which is not counted.

    Raises
    ------
    ModelError : the model or an option is wrong; no speed, torque or power, no width of helical teeth.
    """
    from ..engine.source import train_of
    from ..questions.flanks.efficiency import FRICTION
    from ..questions.flanks.efficiency import efficiency as run

    if sharing not in (choices := ("uniform", "contact")):
        raise ModelError("no such sharing", path="sharing", given=sharing, allowed=", ".join(choices))
    oil = _oil(friction, viscosity, roughness)
    train = train_of(source, overrides=overrides)
    return run(train, friction=FRICTION if friction is None else friction, oil=oil, sharing=sharing)


def _oil(friction: float | None, viscosity: float | str | None, roughness: float | str | None) -> "Oil | None":
    """Oil from viscosity [Pa s] and roughness [m], numbers or texts; None where friction is a number.

    Raises
    ------
    ModelError : one of the two alone, both ways at once, a text without its unit, a value that is not above 0.
    """
    if viscosity is None and roughness is None:
        return None
    for name, value in (("viscosity", viscosity), ("roughness", roughness)):
        if value is None:
            raise ModelError("is missing: friction by oil needs both", path=name, allowed="viscosity and roughness")
    if friction is not None:
        raise ModelError("a number and an oil", path="friction", given=friction, allowed="one of the two")
    from ..document.units import Bounds
    from ..document.written_numbers import stated
    from ..questions.flanks.efficiency import Oil

    read: dict[str, float] = {}
    for (name, kind, value), (least, most, words) in zip(
        (("viscosity", "viscosity", viscosity), ("roughness", "length", roughness)), _RANGES, strict=True
    ):
        read[name] = stated(value or 0.0, kind, name, bounds=Bounds(low=least, high=most))
        if not least <= read[name] <= most:  # a number of Python has no unit to read
            raise ModelError("out of range", path=name, given=value, allowed=words)
    return Oil(**read)


VERB = Verb(
    run=efficiency,
    gives=("efficiency",),
    drawing=True,
    in_report=35,
    examples=({}, {"viscosity": 0.02, "roughness": 0.6e-6}),
)
