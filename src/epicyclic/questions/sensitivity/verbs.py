"""The verb sensitivity."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Literal

from ...verbs.options import MOST_SPEED, frequency, relative
from ...verbs.record import Option, Progress, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Overrides, Source


@bounded
def sensitivity(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    of: Annotated[
        Literal["frequency", "force"], Option("Natural frequencies, or the RMS of the dynamic mesh forces.")
    ] = "frequency",
    mode: Annotated[int | None, Option("Rank by this mode, from 1.", default="lowest elastic")] = None,
    mesh: Annotated[str | None, Option("Rank by this mesh, e.g. main/sun-planet/1.", default="largest force")] = None,
    paths: Annotated[
        Sequence[str] | None,
        Option(
            "A number of the model, PATH[2] for an entry of a list; may be repeated.",
            default="all that move something",
        ),
    ] = None,
    mesh_frequency: Annotated[
        float | str | None,
        Option('Mesh frequency for forces [Hz], e.g. "0.6 kHz".', default="operating speed"),
    ] = None,
    harmonic: Annotated[
        int | None, Option("Amplitude of this mesh order in place of the RMS.", least=1, most=1_000_000, default="RMS")
    ] = None,
    relative_speed: Annotated[
        float | str | None,
        Option(
            'Speed per operating speed, or e.g. "20 Hz", "50 rpm", "50 %"; gyroscopic terms for frequencies.',
            least=0,
            most=MOST_SPEED,
            default="standstill; of forces 1",
        ),
    ] = None,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """Which number of the model moves a natural frequency or a mesh force most: percent per percent, ranked.

    Raises
    ------
    ModelError : the model is wrong; a path that is no number; options that do not go together; no damping or speed.
    """
    from ...engine.source import system_of, train_of
    from .sensitivity import sensitivity as run

    train = train_of(source, overrides=overrides)
    if isinstance(relative_speed, str):
        relative_speed = relative(relative_speed, system_of(train), train)
    return run(
        train,
        of=of,
        mode=mode,
        mesh=mesh,
        paths=paths,
        mesh_frequency=None if mesh_frequency is None else frequency(mesh_frequency, "mesh_frequency"),
        relative_speed=relative_speed,
        harmonic=harmonic,
        progress=progress,
    )


VERBS = (
    Verb(
        run=sensitivity,
        gives=("sensitivity",),
        examples=({"paths": ("stages.main.sun.mass",)}, {"of": "force", "paths": ("stages.main.sun.mass",)}),
        drawing=True,
    ),
)
