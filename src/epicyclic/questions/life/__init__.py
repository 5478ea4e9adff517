"""Life: what the rolling bearings of a gearbox live under the forces that statics finds, over load cases.

Options of its verb.
"""

from dataclasses import dataclass
from typing import Annotated

from ...options import Option


@dataclass(frozen=True, slots=True, kw_only=True)
class LifeOptions:
    """Options of the life of bearings.  instants : of a turn of the slowest body, over which forces are taken."""

    instants: Annotated[int, Option("Instants of a turn of the slowest body.", least=8, most=20_000)] = 256
