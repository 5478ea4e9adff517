"""Loaded tooth contact: of a pair alone and of all meshes of a train; relief, stiffness over the cycle, efficiency.

Options of its verbs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from ...options import ChosenSlices, Corner, Folder, LinearAt, LoadPoints, Misalignment, Of, Option, Tolerance, Turns

FIGURES = {
    "contact": ("faces", "factors", "flanks", "contact", "roots"),
    "efficiency": ("losses", "sliding"),
    "relief": ("relief", "relief-effect"),
    "stiffness": ("stiffness",),
}
"""Kind of result -> names of its figures."""


TOLERANCE = 0.01
"""Relative error by default: far below what models of teeth differ by."""
End = Literal["left", "right"]


@dataclass(frozen=True, slots=True, kw_only=True)
class StiffnessOptions:
    """Options of the mesh stiffness over a mesh cycle."""

    samples: Annotated[int, Option("Phases of a mesh cycle.", least=1)] = 256


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactOptions:
    """Options of tooth contact; what is of a mesh alone means nothing to a train, and the other way round.

    With samples or slices that are None, the corners of contact are among the instants.
    """

    mesh: Annotated[
        str | None,
        Option(
            "A mesh alone, main/sun-planet/2, or a pair, sun-planet, and not the train.",
            default="all meshes, in the equilibrium of the train",
            metavar="NAME",
        ),
    ] = None
    loads: Annotated[
        Sequence[float] | str | None,
        Option('Further loads, relative to the operating one: "0..1.5" or "0.5, 2".', default="0.1 to 1.5"),
    ] = None
    load_points: LoadPoints = None
    samples: Annotated[
        int | None,
        Option(
            "Even instants of a mesh cycle or turn.", least=1, most=100_000, default="doubled until the tolerance holds"
        ),
    ] = None
    slices: ChosenSlices = None
    tolerance: Annotated[
        float,
        Option(
            "Relative error where samples or slices are not given: of the largest load, and of K_gamma; of a mesh, of "
            "transmission error (peak to peak) and largest pressure."
        ),
    ] = TOLERANCE
    corner: Corner = False
    linear_at: LinearAt = None
    cycles: Annotated[
        int | None, Option("Length of the record in mesh cycles.", least=1, most=1_000_000, default="1")
    ] = None
    turns: Turns = None
    of: Of = None
    torque: Annotated[
        float | None,
        Option(
            'Of a mesh, on its first gear [N m], or e.g. "850 N m"; the loaded flank is that of operation.',
            least=0,
            most=1e9,
            default="as operated",
            reads="torque",
        ),
    ] = None
    misalignment: Annotated[
        float,
        Option(
            'Of a mesh, of its flanks [rad], or e.g. "0.1 mrad"; positive opens the right end.',
            default="0",
            reads="angle",
        ),
    ] = 0.0
    torque_end_a: Annotated[
        End | None, Option("Of a mesh, where torque leaves the first gear: it twists.", default="nowhere")
    ] = None
    torque_end_b: Annotated[End | None, Option("The same of the second gear.", default="nowhere")] = None
    pitch_error: Annotated[
        float,
        Option(
            'Of a mesh [m], or e.g. "10 um": gap of a pair of teeth and those after it over those before it.',
            default="0",
            reads="length",
        ),
    ] = 0.0
    profile_error: Annotated[
        float,
        Option(
            'Of a mesh, amplitude [m], or e.g. "8 um": a cosine over the mesh cycle, the teeth alike.',
            default="0",
            reads="length",
        ),
    ] = 0.0
    deviations: Annotated[bool, Option("Of a mesh: count the pitch and profile deviations of the file.")] = False
    cycle: Annotated[
        float | None,
        Option("Beginning of the mesh cycle that is analysed, with errors [mesh cycles].", default="the worst cycle"),
    ] = None
    profile_phase: Annotated[
        float | None,
        Option('Of --profile-error at the pitch point [rad], or e.g. "30 deg".', default="the worst", reads="angle"),
    ] = None

    def common(self) -> dict[str, Any]:
        """Options that a pair and a train have, by name, beside the loads."""
        return {name: getattr(self, name) for name in ("samples", "slices", "tolerance", "linear_at", "corner")}


@dataclass(frozen=True, slots=True, kw_only=True)
class ReliefOptions:
    """Options of the search for the best micro-geometry.

    A uniform face of spur teeth is one slice.  Where phases or slices are not given, the search takes few, and its best
    candidates are solved again with as many as the tolerance needs.
    """

    vary: Annotated[
        Mapping[str, object],
        Option(
            'tip_relief.amount="0..40 um", sun.tip_relief.length="0.5..3 mm", tip_relief.shape=linear,parabolic; '
            "without a gear on all flanks alike; one value is set. May be repeated.",
            metavar="[GEAR.]KEY=BOUNDS",
            accepts=Mapping[str, object] | Sequence[str],
            reads="settings",
        ),
    ]
    mesh: Annotated[
        str | Sequence[str] | None,
        Option("A mesh or pair; may be repeated.", default="every mesh with face widths", metavar="NAME"),
    ] = None
    torque: Annotated[
        float | None,
        Option(
            'On the first gear of the mesh [N m], or e.g. "850 N m".',
            least=0,
            most=1e9,
            default="as operated",
            reads="torque",
        ),
    ] = None
    objectives: Annotated[
        Sequence[Literal["lte", "load", "force_rms", "force_peak"]],
        Option("What is made least; several give a Pareto set. May be repeated."),
    ] = ("lte",)
    loads: Annotated[
        Sequence[float] | str, Option('Loads of lte and load, relative: "0.5..1.25" or "0.5, 1".', default="1")
    ] = (1.0,)
    load_points: Annotated[
        int | None, Option("Number of loads in a range (--loads).", least=1, most=1000, default="4")
    ] = None
    start: Annotated[
        float | None,
        Option(
            'Lowest mesh frequency of dynamic forces [Hz], e.g. "200 Hz".',
            default="a fifth of operating",
            reads="frequency",
        ),
    ] = None
    stop: Annotated[float | None, Option('Highest, e.g. "2 kHz".', default="1.2 of it", reads="frequency")] = None
    points: Annotated[int, Option("Number of speeds.", least=1, most=10_000)] = 30
    population: Annotated[int, Option("Candidates a generation.", least=4, most=100_000)] = 60
    generations: Annotated[int, Option("Generations.", least=1, most=100_000)] = 60
    seed: Annotated[int, Option("The same seed, the same search.", least=0)] = 1
    resume: Annotated[
        str | Path | None,
        Option(
            "Folder that keeps the search as it goes; gone on with if there. With -o there is one beside it.",
            metavar="DIR",
        ),
    ] = None
    folder: Folder = None
    pick: Annotated[
        int | None, Option("Number of the solution to take, from 0.", least=0, default="nearest to all best")
    ] = None
    samples: Annotated[
        int | None,
        Option("Even phases of a mesh cycle.", least=3, most=10_000, default="few, then doubled for the best"),
    ] = None
    slices: ChosenSlices = None
    tolerance: Tolerance = TOLERANCE
    misalignment: Misalignment = 0.0
    corner: Corner = False


@dataclass(frozen=True, slots=True, kw_only=True)
class EfficiencyOptions:
    """Options of losses in the meshes: friction is a number, or follows from an oil and the flanks."""

    friction: Annotated[
        float | None, Option("Coefficient of friction of all meshes.", least=0, most=1, default="0.05, or by the oil")
    ] = None
    viscosity: Annotated[
        float | None,
        Option(
            'Dynamic viscosity of the oil in the meshes [Pa s], or e.g. "20 mPa s".',
            least=1e-4,
            most=10,
            default="not used",
            reads="viscosity",
        ),
    ] = None
    roughness: Annotated[
        float | None,
        Option(
            'Mean Ra of the flanks [m], or e.g. "0.6 um".', least=1e-8, most=1e-4, default="not used", reads="length"
        ),
    ] = None
    sharing: Annotated[
        Literal["uniform", "contact"], Option("Load along the contact lines: uniform, or that of loaded tooth contact.")
    ] = "uniform"
