"""The verb contact."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from .options import RANGE_LOADS, ChosenSlices, Corner, LinearAt, LoadPoints, Misalignment, Tolerance
from .parsing import load_per_length, loads_of
from .record import Option, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source


@bounded
def contact(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    mesh: Annotated[
        str | None,
        Option("A mesh, main/sun-planet/2, or a pair, sun-planet.", default="the first", metavar="NAME"),
    ] = None,
    torque: Annotated[
        float | str | None,
        Option('On the first gear of the mesh [N m], or e.g. "850 N m".', default="as operated"),
    ] = None,
    loads: Annotated[
        Sequence[float] | str | None,
        Option('Further loads, relative to the operating one: "0..1.5" or "0.5, 2".', default="0.1 to 1.5"),
    ] = None,
    load_points: LoadPoints = None,
    samples: Annotated[
        int | None,
        Option("Even phases of a mesh cycle.", least=3, most=100_000, default="doubled until the tolerance holds"),
    ] = None,
    slices: ChosenSlices = None,
    tolerance: Tolerance = 0.01,
    misalignment: Misalignment = 0.0,
    torque_end_a: Annotated[
        str | None, Option("Where torque leaves the first gear: left or right; it twists.", default="nowhere")
    ] = None,
    torque_end_b: Annotated[str | None, Option("The same of the second gear.", default="nowhere")] = None,
    corner: Corner = False,
    linear_at: LinearAt = None,
    pitch_error: Annotated[
        float | str,
        Option('Pitch error [m], or e.g. "10 um": gap of a pair of teeth and those after it over those before it.'),
    ] = 0.0,
    profile_error: Annotated[
        float | str,
        Option('Amplitude [m], or e.g. "8 um", of a profile error: a cosine over the mesh cycle, the teeth alike.'),
    ] = 0.0,
    deviations: Annotated[bool, Option("Count the pitch and profile deviations of the file.")] = False,
    cycle: Annotated[
        float | None,
        Option("Beginning of the mesh cycle that is analysed, with errors [mesh cycles].", default="the worst cycle"),
    ] = None,
    profile_phase: Annotated[
        float | str | None,
        Option('Of --profile-error at the pitch point [rad], or e.g. "30 deg".', default="the worst"),
    ] = None,
) -> "xr.Dataset":
    """Loaded tooth contact of one mesh: load over the flank, transmission error, stiffness, at several loads.

    Raises
    ------
    ModelError : the model or an option is wrong; no torque, no face width; teeth that do not mesh.
    """
    factors = loads_of(loads, load_points, RANGE_LOADS)
    from ..engine.source import train_of
    from ..questions.flanks.contact import FACTORS
    from ..questions.flanks.contact import contact as run
    from ..questions.flanks.contact_resolution import tooth_errors

    return run(
        train_of(source, overrides=overrides),
        mesh=mesh,
        torque=torque,
        samples=samples,
        slices=slices,
        tolerance=tolerance,
        linear_at=None if linear_at is None else load_per_length(linear_at, "linear_at"),
        corner=corner,
        misalignment=misalignment,
        torque_ends=(torque_end_a, torque_end_b),
        errors=tooth_errors(
            pitch=pitch_error, profile=profile_error, deviations=deviations, cycle=cycle, phase=profile_phase
        ),
        factors=FACTORS if factors is None else factors,
    )


VERB = Verb(run=contact, gives=("contact",), examples=({"samples": 8, "slices": 4},), drawing=True, in_report=30)
