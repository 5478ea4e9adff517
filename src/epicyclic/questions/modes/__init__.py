"""Natural frequencies, shapes, kinds and energies; the modal basis that every other analysis stands on.

Options of its verbs.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from ...options import Option, RelativeSpeed

FIGURES = {"campbell": ("campbell",), "modes": ("frequencies", "shapes", "energy", "campbell", "operating-range")}
"""Kind of result -> names of its figures."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModesOptions:
    """Options of the natural modes."""

    relative_speed: RelativeSpeed = 0.0
    damped: Annotated[bool, Option("Solve the damped problem.")] = False
    band: Annotated[
        float | str | None,
        Option(
            'Resonances at most this share from the operating speed alone, e.g. "20 %", or with natural frequencies '
            'in a range, e.g. "500..6000 Hz".',
            default="5 to 130 % of it, those within 20 % marked",
        ),
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CampbellOptions:
    """Options of the Campbell diagram."""

    relative_speeds: Annotated[
        Sequence[float] | None,
        Option("(s,) speeds per operating speed [1], in the order to follow.", flag=None, default="0 to 2"),
    ] = None
    damped: Annotated[bool, Option("Solve the damped problem.")] = False
