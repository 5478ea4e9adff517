"""What a train is, and what each analysis still asks of it; its linear system as matrices, and the options of that."""

from dataclasses import dataclass

from ...options import RelativeSpeed

FIGURES = {"check": ("front", "section", "members", "orders", "phases", "stiffness"), "matrices": ()}
"""Kind of result -> names of its figures."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MatricesOptions:
    """Options of the matrices of the mean linear system."""

    relative_speed: RelativeSpeed = 1.0
