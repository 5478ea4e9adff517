"""Mesh stiffness of one pair of gears: mean value of ISO 6336-1 [iso6336], and variation over a mesh cycle.

The variation is a relative Fourier series over the place sigma of the contact, as in `series`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..warning_codes import CodedText, coded
from .series import ComplexArray

__all__ = [
    "DEFAULT_HARMONICS",
    "LIMITS",
    "STEEL_MODULUS",
    "Limit",
    "contact_line_series",
    "face_average",
    "iso6336_mesh_stiffness",
    "iso6336_single_stiffness",
    "normal_from_transverse",
    "outside_limits",
]

Array = NDArray[np.float64]


# mean value, ISO 6336-1 ----------------------------------------------------------------------------------------------

STEEL_MODULUS = 206e9  # Young's modulus of the steel the coefficients below were fitted for [Pa]

# q' [mm um / N] = C1 + C2/z_n1 + C3/z_n2 + C4 x1 + C5 x1/z_n1 + C6 x2 + C7 x2/z_n2 + C8 x1^2 + C9 x2^2
# [iso6336, method B: minimum flexibility of a tooth pair].  Limits of validity: LIMITS.
_FLEXIBILITY = (0.04723, 0.15551, 0.25791, -0.00635, -0.11654, -0.00193, -0.24188, 0.00529, 0.00182)
_CORRECTION = 0.8  # C_M, from theory to measured solid discs
_PER_WIDTH = 1e9  # 1 N/(mm um) = 1e9 N/m per metre of width


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """Range of validity of a formula: lowest <= quantity <= highest; unit and source for the message."""

    quantity: str
    lowest: float
    highest: float
    source: str
    unit: str = ""


LIMITS: tuple[Limit, ...] = (
    Limit(quantity="sum of profile shifts", lowest=-0.5, highest=2.0, source="ISO 6336-1, c' of method B"),
    Limit(quantity="profile shift x1 - x2", lowest=0.0, highest=math.inf, source="ISO 6336-1, c' of method B"),
    Limit(quantity="helix angle", lowest=0.0, highest=30.0, unit="deg", source="ISO 6336-1, c_gamma"),
    Limit(quantity="transverse contact ratio", lowest=1.2, highest=math.inf, source="ISO 6336-1, c_gamma"),
    # Steel pairs lie between 10 and 25 N/(mm um); a value far outside is rather a wrong unit than a soft tooth.
    Limit(
        quantity="mesh stiffness per width",
        lowest=5.0,
        highest=50.0,
        unit="N/(mm um)",
        source="steel teeth, ISO 6336-1",
    ),
)


def outside_limits(values: Mapping[str, float]) -> tuple[CodedText, ...]:
    """Warnings for values outside `LIMITS`.

    values : name of the quantity in `LIMITS` -> value in the unit there; nan is not compared.
    """
    slack = 1e-9  # a sum of shifts typed as decimals may miss a limit by rounding
    return tuple(
        coded(
            "formula-outside-limits",
            f"{limit.quantity} {values[limit.quantity]:.4g} {limit.unit}".rstrip()
            + f" is outside {limit.lowest:g} .. {limit.highest:g} ({limit.source})",
        )
        for limit in LIMITS
        if limit.quantity in values
        and (values[limit.quantity] < limit.lowest - slack or values[limit.quantity] > limit.highest + slack)
    )


def iso6336_single_stiffness(
    teeth_a: int,
    teeth_b: int,
    pressure_angle: float,
    helix_angle: float,
    *,
    internal: bool = False,
    shift_a: float = 0.0,
    shift_b: float = 0.0,
    dedendum_a: float = 1.25,
    dedendum_b: float = 1.25,
    youngs_modulus_a: float = STEEL_MODULUS,
    youngs_modulus_b: float = STEEL_MODULUS,
) -> tuple[float, tuple[CodedText, ...]]:
    """Single stiffness c' of a tooth pair per face width, transverse [N/m^2], with warnings outside its limits.

    c' = C_M C_R C_B cos beta / q', C_M = 0.8, C_R = 1 (solid), z_n = z/(cos^2 beta_b cos beta), ring z_n = inf
    [iso6336].  Gear a has the index 1: the pinion of the standard, the gear nearer the sun of docs/conventions.md.
    Loads above 100 N per mm of face width are assumed.

    pressure_angle : normal [rad]; helix_angle [rad]; shift_*, dedendum_* (basic rack) : coefficients [1];
    youngs_modulus_* [Pa], scaled by 2 E_a E_b/(E_a + E_b) over that of steel.
    """
    beta = abs(helix_angle)
    squared = 1.0 - (math.sin(beta) * math.cos(pressure_angle)) ** 2  # cos^2 beta_b
    per_tooth_a = squared * math.cos(beta) / teeth_a
    per_tooth_b = 0.0 if internal else squared * math.cos(beta) / teeth_b
    flexibility = _flexibility(per_tooth_a, per_tooth_b, shift_a, shift_b)
    rack = 0.5 * (_rack_factor(dedendum_a, pressure_angle) + _rack_factor(dedendum_b, pressure_angle))
    modulus = 2.0 * youngs_modulus_a * youngs_modulus_b / (youngs_modulus_a + youngs_modulus_b) / STEEL_MODULUS
    stiffness = _PER_WIDTH * _CORRECTION * rack * modulus * math.cos(beta) / flexibility
    values = {
        "sum of profile shifts": shift_a + shift_b,
        # the standard numbers the pinion 1; a ring has no such order
        "profile shift x1 - x2": math.nan if internal else shift_a - shift_b,
        "helix angle": math.degrees(beta),
    }
    return stiffness, outside_limits(values)


def iso6336_mesh_stiffness(single_stiffness: float, contact_ratio: float) -> tuple[float, tuple[CodedText, ...]]:
    """Mean mesh stiffness c_gamma_alpha = c' (0.75 eps_alpha + 0.25) per face width [N/m^2], with warnings [iso6336].

    single_stiffness : c' [N/m^2].  contact_ratio : transverse [1].  In the transverse plane: see
    `normal_from_transverse`.
    """
    mean = single_stiffness * (0.75 * contact_ratio + 0.25)
    return mean, outside_limits({"transverse contact ratio": contact_ratio})


def normal_from_transverse(stiffness: float, base_helix_angle: float) -> float:
    """Stiffness along the tooth normal from that in the transverse plane, k = k_t / cos^2 beta_b [same unit].

    docs/conventions.md, Forces, stiffness, errors.  base_helix_angle : beta_b [rad].
    """
    return stiffness / math.cos(base_helix_angle) ** 2


def _flexibility(per_tooth_1: float, per_tooth_2: float, x1: float, x2: float) -> float:
    """Minimum flexibility q' of a tooth pair [mm um / N] [iso6336]; per_tooth : 1/z_n [1], x : profile shifts [1]."""
    terms = (1.0, per_tooth_1, per_tooth_2, x1, x1 * per_tooth_1, x2, x2 * per_tooth_2, x1**2, x2**2)
    return math.fsum(c * term for c, term in zip(_FLEXIBILITY, terms, strict=True))


def _rack_factor(dedendum: float, pressure_angle: float) -> float:
    """Basic rack factor C_B of one gear [1] [iso6336]; a pair has the mean of both."""
    return (1.0 + 0.5 * (1.2 - dedendum)) * (1.0 - 0.02 * (20.0 - math.degrees(pressure_angle)))


# variation over a mesh cycle -----------------------------------------------------------------------------------------

# Kept by default.  A spur series falls as 1/l only, so no number makes the rest negligible: 12 orders hold 95 % of the
# variance of a spur mesh (what is dropped has an RMS of 5 .. 8 % of the mean stiffness, above the modes that matter in
# a usual sweep); from an overlap ratio of 0.25 on the dropped part is below 0.4 % of the mean.
DEFAULT_HARMONICS = 12


def contact_line_series(
    limits: tuple[float, float], overlap_ratio: float, *, harmonics: int = DEFAULT_HARMONICS
) -> ComplexArray:
    """Relative series v_l (L,) [1] of a mesh stiffness proportional to the length of the contact lines [maatar1996].

    One pair is in contact over a window of width eps_alpha centred between the limits.  A helical face convolves it
    with a window of width eps_beta centred on mid-face: v_l = 2 sinc(l eps_alpha) sinc(l eps_beta)
    exp(-2 pi i l centre).  The mean length is eps_alpha b / cos beta_b.

    limits : (sigma_min, sigma_max) of `geometry.contact_limits`; overlap_ratio [1], 0 for spur teeth.
    """
    order = np.arange(1, harmonics + 1)
    size = 2.0 * np.sinc(order * (limits[1] - limits[0]))
    return face_average(size * np.exp(-1j * np.pi * order * (limits[0] + limits[1])), overlap_ratio)


def face_average(series: ComplexArray, overlap_ratio: float) -> ComplexArray:
    """Series (L,) [1] averaged over a helical face from that of a narrow slice, v_l sinc(l eps_beta) [maatar1996]."""
    order = np.arange(1, np.size(series) + 1)
    return np.asarray(series * np.sinc(order * overlap_ratio), dtype=np.complex128)
