"""What moves an answer: derivatives, a number of the model over its values, several trains beside each other.

Options of its verbs.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

from ...limits import RESONANCE_BAND
from ...options import MOST_SPEED, Option

FIGURES = {"compare": ("compared",), "detune": (), "sensitivity": ("sensitivity",), "track": ("track",)}
"""Kind of result -> names of its figures."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SensitivityOptions:
    """Options of what moves a natural frequency or a mesh force."""

    of: Annotated[
        Literal["frequency", "force"], Option("Natural frequencies, or the RMS of the dynamic mesh forces.")
    ] = "frequency"
    mode: Annotated[int | None, Option("Rank by this mode, from 1.", default="lowest elastic")] = None
    mesh: Annotated[str | None, Option("Rank by this mesh, e.g. main/sun-planet/1.", default="largest force")] = None
    paths: Annotated[
        Sequence[str] | None,
        Option(
            "A number of the model, PATH[2] for an entry of a list; may be repeated.", default="all that move something"
        ),
    ] = None
    mesh_frequency: Annotated[
        float | None,
        Option('Mesh frequency for forces [Hz], e.g. "0.6 kHz".', default="operating speed", reads="frequency"),
    ] = None
    harmonic: Annotated[
        int | None, Option("Amplitude of this mesh order in place of the RMS.", least=1, most=1_000_000, default="RMS")
    ] = None
    relative_speed: Annotated[
        float | None,
        Option(
            'Speed per operating speed, or e.g. "20 Hz", "50 rpm", "50 %"; gyroscopic terms for frequencies.',
            least=0,
            most=MOST_SPEED,
            default="standstill; of forces 1",
            reads="relative speed",
        ),
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackOptions:
    """Options of natural frequencies along a number of the model."""

    over: Annotated[str, Option("The number that is moved, PATH[2] for an entry of a list.", metavar="PATH")]
    start: Annotated[
        float | str | None, Option('First value, as the file says it: "1e8 N/m".', default="half of it")
    ] = None
    stop: Annotated[float | str | None, Option("Last value.", default="twice")] = None
    points: Annotated[int, Option("Values to begin with; more where modes meet.", least=3, most=10_000)] = 41
    modes: Annotated[int | None, Option("How many modes, from the lowest.", least=1, default="all")] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class DetuneOptions:
    """Options of what moves a resonance away from operation."""

    mode: Annotated[int | None, Option("Move a resonance of this mode, from 1.", least=1, default="strongest")] = None
    order: Annotated[int | None, Option("Move a resonance of this mesh order.", least=1, default="strongest")] = None
    relative_speed: Annotated[
        float,
        Option(
            'Speed that the resonance is to leave, per operating speed, or e.g. "20 Hz", "50 rpm", "50 %".',
            above=0,
            most=MOST_SPEED,
            reads="relative speed",
        ),
    ] = 1.0
    band: Annotated[
        float,
        Option('Distance from that speed that is enough, per speed, or e.g. "20 %".', above=0, most=0.9, reads="share"),
    ] = RESONANCE_BAND
    changes: Annotated[int, Option("Changes that are computed, those of the least size.", least=1, most=100)] = 4
