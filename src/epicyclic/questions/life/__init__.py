"""Life: what the rolling bearings of a gearbox live under the forces that statics finds, over load cases.

Options of its verb.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from ...options import Option


@dataclass(frozen=True, slots=True, kw_only=True)
class LifeOptions:
    """Options of the life of bearings.

    instants : over which forces are taken, the next prime number from here on.
    """

    forces: Annotated[
        Literal["static", "steady"], Option("Forces at rest, or of the steady vibration with linear contact.")
    ] = "static"
    instants: Annotated[int, Option("Instants over the turns of all bodies.", least=8, most=20_000)] = 256
    changes: Annotated[
        bool,
        Option("Also with a larger clearance, a larger rating and a floating sun; one more run each."),
    ] = False


# A bearing by its parts in the examples of the verbs that show its state.
EXAMPLE_PARTS = {
    "type": "cylindrical roller",
    "rows": 2,
    "row_distance": "30 mm",
    "elements": 14,
    "element_diameter": "15 mm",
    "element_length": "24 mm",
    "pitch_diameter": "80 mm",
    "viscosity_ratio": 1.5,
    "contamination": 0.6,
}
EXAMPLE = {"overrides": {f"stages.main.planet.bearing.{key}": one for key, one in EXAMPLE_PARTS.items()}}
