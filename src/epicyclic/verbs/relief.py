"""The verb relief."""

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from .options import ChosenSlices, Corner, Folder, Misalignment, Tolerance
from .parsing import ends, loads_of, settings
from .record import Option, Progress, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source

RECORD = "search.json"
"""Record of a search in the folder that keeps it."""


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
            "Record of the search, written as it goes; gone on with if there. With -o there is one beside it.",
            metavar="FILE",
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
    folder : keeps the record of the search where `resume` names no other.

    Raises
    ------
    ModelError : the model, a name, bounds or a record is wrong; a relief that does not fit its flank; no pymoo.
    """
    from ..questions.flanks.relief import relief as run

    keeping: AbstractContextManager[None] = nullcontext()
    if folder is not None:
        from ..engine.run_folder import open_folder

        keeping = open_folder(Path(folder), verb="relief", model=(), options={}, resume=resume is not None)
        resume = Path(folder) / RECORD if resume is None else resume
    factors = loads_of(loads, load_points, 4) or ()
    with keeping:
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
            resume=resume,
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
    from ..questions.flanks.relief import relief_model

    return relief_model(result)


VERB = Verb(
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
)
