"""Load factors: what a gear rating asks of the dynamics, by pair of gears, flank and load case.

Options of its verb.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from ...options import Option, Tolerance

# Exponents of the torque in a sum of damage by pitting, of the materials that a rating tells apart [iso63366].
PITTING = {"case-hardened": 6.61, "through-hardened": 6.61, "nitrided": 5.709, "nitrocarburised": 15.715}


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadFactorOptions:
    """Options of the load factors.

    exponent : of the equivalent torque; None: that of pitting of the material.  life : time that shares are of [s].
    """

    flanks: Annotated[
        Literal["slices", "contact"], Option("K_Hbeta of the slices of meshes, or all of loaded tooth contact.")
    ] = "slices"
    tolerance: Tolerance = 0.01
    material: Annotated[
        Literal["case-hardened", "through-hardened", "nitrided", "nitrocarburised"],
        Option("Of the flanks, for the exponent."),
    ] = "case-hardened"
    exponent: Annotated[
        float | None,
        Option("Exponent of the equivalent torque.", above=0, most=100, default="6.61, 5.709 or 15.715 by material"),
    ] = None
    life: Annotated[
        float | None,
        Option('Time that all cases stand for [s], e.g. "20000 h".', above=0, default="their durations", reads="time"),
    ] = None
