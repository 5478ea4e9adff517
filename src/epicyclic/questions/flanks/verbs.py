"""The verbs stiffness, contact, relief and efficiency."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from ...errors import ModelError
from ...verbs.options import (
    RANGE_LOADS,
    ChosenSlices,
    Corner,
    Folder,
    LinearAt,
    LoadPoints,
    Misalignment,
    Of,
    Tolerance,
    Turns,
    ends,
    load_per_length,
    loads_of,
    settings,
)
from ...verbs.record import Option, Progress, Verb, bounded, given, refuse_without

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Overrides, Source
    from .efficiency import Oil


@bounded
def stiffness(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    samples: Annotated[int, Option("Phases of a mesh cycle.", least=1)] = 256,
) -> "xr.Dataset":
    """Mesh stiffness over a mesh cycle.

    Raises
    ------
    ModelError : the model is wrong, or a System is given, which has no drawing left.
    """
    from ...engine.source import train_of
    from .contact import stiffness as run

    return run(train_of(source, overrides=overrides), samples=samples)


@bounded
def contact(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    mesh: Annotated[
        str | None,
        Option(
            "A mesh alone, main/sun-planet/2, or a pair, sun-planet, and not the train.",
            default="all meshes, in the equilibrium of the train",
            metavar="NAME",
        ),
    ] = None,
    loads: Annotated[
        Sequence[float] | str | None,
        Option('Further loads, relative to the operating one: "0..1.5" or "0.5, 2".', default="0.1 to 1.5"),
    ] = None,
    load_points: LoadPoints = None,
    samples: Annotated[
        int | None,
        Option(
            "Even instants of a mesh cycle or turn.",
            least=1,
            most=100_000,
            default="doubled until the tolerance holds",
        ),
    ] = None,
    slices: ChosenSlices = None,
    tolerance: Annotated[
        float,
        Option(
            "Relative error where samples or slices are not given: of the largest load, and of K_gamma; of a mesh, of "
            "transmission error (peak to peak) and largest pressure."
        ),
    ] = 0.01,
    corner: Corner = False,
    linear_at: LinearAt = None,
    cycles: Annotated[
        int | None, Option("Length of the record in mesh cycles.", least=1, most=1_000_000, default="1")
    ] = None,
    turns: Turns = None,
    of: Of = None,
    torque: Annotated[
        float | str | None,
        Option('Of a mesh, on its first gear [N m], or e.g. "850 N m".', default="as operated"),
    ] = None,
    misalignment: Annotated[
        float | str | None,
        Option('Of a mesh, of its flanks [rad], or e.g. "0.1 mrad"; positive opens the right end.', default="0"),
    ] = None,
    torque_end_a: Annotated[
        Literal["left", "right"] | None,
        Option("Of a mesh, where torque leaves the first gear: it twists.", default="nowhere"),
    ] = None,
    torque_end_b: Annotated[
        Literal["left", "right"] | None, Option("The same of the second gear.", default="nowhere")
    ] = None,
    pitch_error: Annotated[
        float | str | None,
        Option(
            'Of a mesh [m], or e.g. "10 um": gap of a pair of teeth and those after it over those before it.',
            default="0",
        ),
    ] = None,
    profile_error: Annotated[
        float | str | None,
        Option('Of a mesh, amplitude [m], or e.g. "8 um": a cosine over the mesh cycle, the teeth alike.', default="0"),
    ] = None,
    deviations: Annotated[bool, Option("Of a mesh: count the pitch and profile deviations of the file.")] = False,
    cycle: Annotated[
        float | None,
        Option("Beginning of the mesh cycle that is analysed, with errors [mesh cycles].", default="the worst cycle"),
    ] = None,
    profile_phase: Annotated[
        float | str | None,
        Option('Of --profile-error at the pitch point [rad], or e.g. "30 deg".', default="the worst"),
    ] = None,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """Loaded tooth contact: load along the faces and in the roots, at several loads.

    Of all meshes at once, in the equilibrium of the train: every mesh is misaligned by its own tilt and twist, branches
    and sides share the load as the train lets them (K_Hbeta, K_gamma). Or of one mesh alone, under its torque:
    load over the flank, transmission error, stiffness.

    Raises
    ------
    ModelError : the model or an option is wrong; no torque, no face width; teeth that do not mesh.  ConvergenceError :
        no equilibrium.
    """
    of_mesh = {
        **given(torque=torque, misalignment=misalignment, torque_end_a=torque_end_a, torque_end_b=torque_end_b),
        **given(pitch_error=pitch_error, profile_error=profile_error, deviations=deviations or None),
        **given(cycle=cycle, profile_phase=profile_phase),
    }
    of_train = given(cycles=cycles, turns=turns, of=of)
    refuse_without(mesh is not None, "one mesh alone, which mesh names", **of_mesh)
    refuse_without(mesh is None, "all meshes, without mesh", **of_train)
    linear = None if linear_at is None else load_per_length(linear_at, "linear_at")
    factors = loads_of(loads, load_points, RANGE_LOADS)
    from ...document.units import stated
    from ...engine.source import train_of
    from .contact import ContactOptions

    quantities = dict(misalignment="angle", pitch_error="length", profile_error="length", profile_phase="angle")
    of_mesh |= {name: stated(of_mesh[name], kind, name) for name, kind in quantities.items() if name in of_mesh}
    train = train_of(source, overrides=overrides)
    kept = given(factors=factors, samples=samples, slices=slices, linear_at=linear)
    options = ContactOptions(**kept, tolerance=tolerance, corner=corner, **of_mesh, **of_train)
    if mesh is None:
        from .train_contact import train_contact

        return train_contact(train, options, progress=progress)
    if progress is not None:
        progress(0.05)
    from .pair_contact import pair_contact

    return pair_contact(train, mesh, options)


@bounded
def relief(
    source: "Source",
    *,
    vary: Annotated[
        Mapping[str, object] | Sequence[str],
        Option(
            'tip_relief.amount="0..40 um", sun.tip_relief.length="0.5..3 mm", tip_relief.shape=linear,parabolic; '
            "without a gear on all flanks alike; one value is set. May be repeated.",
            metavar="[GEAR.]KEY=BOUNDS",
        ),
    ],
    overrides: "Overrides | None" = None,
    mesh: Annotated[
        str | Sequence[str] | None,
        Option("A mesh or pair; may be repeated.", default="every mesh with face widths", metavar="NAME"),
    ] = None,
    torque: Annotated[
        float | str | None, Option('On the first gear of the mesh [N m], or e.g. "850 N m".', default="as operated")
    ] = None,
    objectives: Annotated[
        Sequence[Literal["lte", "load", "force_rms", "force_peak"]],
        Option("What is made least; several give a Pareto set. May be repeated."),
    ] = ("lte",),
    loads: Annotated[
        Sequence[float] | str, Option('Loads of lte and load, relative: "0.5..1.25" or "0.5, 1".', default="1")
    ] = (1.0,),
    load_points: Annotated[
        int | None, Option("Number of loads in a range (--loads).", least=1, most=1000, default="4")
    ] = None,
    start: Annotated[
        float | str | None,
        Option(
            'Lowest mesh frequency of dynamic forces [Hz], e.g. "200 Hz".',
            default="a fifth of operating",
        ),
    ] = None,
    stop: Annotated[float | str | None, Option('Highest, e.g. "2 kHz".', default="1.2 of it")] = None,
    points: Annotated[int, Option("Number of speeds.", least=1, most=10_000)] = 30,
    population: Annotated[int, Option("Candidates a generation.", least=4, most=100_000)] = 60,
    generations: Annotated[int, Option("Generations.", least=1, most=100_000)] = 60,
    seed: Annotated[int, Option("The same seed, the same search.", least=0)] = 1,
    resume: Annotated[
        str | Path | None,
        Option(
            "Folder that keeps the search as it goes; gone on with if there. With -o there is one beside it.",
            metavar="DIR",
        ),
    ] = None,
    folder: Folder = None,
    pick: Annotated[
        int | None, Option("Number of the solution to take, from 0.", least=0, default="nearest to all best")
    ] = None,
    samples: Annotated[
        int | None,
        Option("Even phases of a mesh cycle.", least=3, most=10_000, default="few, then doubled for the best"),
    ] = None,
    slices: ChosenSlices = None,
    tolerance: Tolerance = 0.01,
    misalignment: Misalignment = 0.0,
    corner: Corner = False,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """The best tip and root relief and lead modification of a mesh, or of all meshes of a train.

    One objective is searched by a genetic algorithm, several by NSGA-II. Ctrl-C ends the search with the best so far.

    Parameters
    ----------
    folder : keeps the search where `resume` names no other.

    Raises
    ------
    ModelError : the model, a name, bounds or a folder is wrong; a relief that does not fit its flank; no pymoo.
    """
    from .relief import relief as run

    factors = loads_of(loads, load_points, 4) or ()
    return run(
        source,
        overrides=overrides,
        vary=settings(vary, "vary"),
        mesh=mesh,
        torque=torque,
        objectives=objectives,
        factors=factors,
        speeds=ends(start, stop),
        speed_points=points,
        population=population,
        generations=generations,
        seed=seed,
        folder=folder if resume is None else resume,
        resume=resume is not None,
        pick=pick,
        samples=samples,
        slices=slices,
        tolerance=tolerance,
        corner=corner,
        misalignment=misalignment,
        progress=progress,
    )


def _model_text(result: "xr.Dataset") -> str:
    """The model with the relief found, as a model file."""
    from .relief import relief_model

    return relief_model(result)


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
    from ...engine.source import train_of
    from .efficiency import FRICTION
    from .efficiency import efficiency as run

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
    from ...document.units import Bounds, stated
    from .efficiency import Oil

    read: dict[str, float] = {}
    for (name, kind, value), (least, most, words) in zip(
        (("viscosity", "viscosity", viscosity), ("roughness", "length", roughness)), _RANGES, strict=True
    ):
        read[name] = stated(value or 0.0, kind, name, bounds=Bounds(low=least, high=most))
        if not least <= read[name] <= most:  # a number of Python has no unit to read
            raise ModelError("out of range", path=name, given=value, allowed=words)
    return Oil(**read)


VERBS = (
    Verb(run=stiffness, gives=("stiffness",), drawing=True, in_report=20),
    Verb(
        run=contact,
        gives=("contact",),
        examples=(
            {"samples": 4, "slices": 2, "loads": (1.0,)},
            {"mesh": "sun-planet", "samples": 8, "slices": 4},
        ),
        drawing=True,
        in_report=30,
    ),
    Verb(
        run=relief,
        gives=("relief",),
        examples=(
            {
                **{"mesh": "sun-planet", "vary": {"tip_relief.amount": "0..40 um", "tip_relief.length": "1..3 mm"}},
                **{"population": 4, "generations": 1, "samples": 8, "slices": 4},
            },
        ),
        drawing=True,
        model_text=_model_text,
    ),
    Verb(
        run=efficiency,
        gives=("efficiency",),
        drawing=True,
        in_report=35,
        examples=({}, {"viscosity": 0.02, "roughness": 0.6e-6}),
    ),
)
