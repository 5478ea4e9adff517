"""The verbs stiffness, contact, relief and efficiency."""

from dataclasses import replace
from typing import TYPE_CHECKING

from ...options import RANGE_LOADS, Progress
from ...verbs.options import loads_of
from ...verbs.record import Verb, model_in, nondefault, refuse_without, takes
from . import ContactOptions, EfficiencyOptions, ReliefOptions, StiffnessOptions

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Drive


@takes(StiffnessOptions)
def stiffness(drive: "Drive", options: StiffnessOptions) -> "xr.Dataset":
    """Mesh stiffness over a mesh cycle.

    Raises
    ------
    ModelError : the model is wrong, or a System is given, which has no drawing left.
    """
    from .contact_resolution import stiffness as run

    return run(drive.train, options)


_OF_MESH = (
    *("torque", "misalignment", "torque_end_a", "torque_end_b", "pitch_error", "profile_error", "deviations"),
    *("cycle", "profile_phase"),
)
_OF_TRAIN = ("cycles", "turns", "of")


@takes(ContactOptions)
def contact(drive: "Drive", options: ContactOptions, progress: Progress | None = None) -> "xr.Dataset":
    """Loaded tooth contact: load along the faces and in the roots, at several loads.

    Of all meshes at once, in the equilibrium of the train: every mesh is misaligned by its own tilt and twist, branches
    and sides share the load as the train lets them (K_Hbeta, K_gamma). Or of one mesh alone, under its torque:
    load over the flank, transmission error, stiffness.

    Raises
    ------
    ModelError : the model or an option is wrong; no torque, no face width; teeth that do not mesh.  ConvergenceError :
        no equilibrium.
    """
    refuse_without(options.mesh is not None, "one mesh alone, which mesh names", **nondefault(options, *_OF_MESH))
    refuse_without(options.mesh is None, "all meshes, without mesh", **nondefault(options, *_OF_TRAIN))
    options = replace(options, loads=loads_of(options.loads, options.load_points, RANGE_LOADS))
    train = drive.train
    if options.mesh is None:
        from .train_contact import train_contact

        return train_contact(train, options, progress=progress)
    if progress is not None:
        progress(0.05)
    from .pair_contact import pair_contact

    return pair_contact(train, options)


@takes(ReliefOptions)
def relief(drive: "Drive", options: ReliefOptions, progress: Progress | None = None) -> "xr.Dataset":
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

    options = replace(options, loads=loads_of(options.loads, options.load_points, 4) or ())
    return run(drive, options, progress=progress)


@takes(EfficiencyOptions)
def efficiency(drive: "Drive", options: EfficiencyOptions) -> "xr.Dataset":
    """Power lost in the meshes, and efficiency of the train at its operating point.

    Sliding speed and load along the path of contact give the loss factor of every mesh, the power that it rolls in the
    frame of its carrier the loss. Bearings, seals and oil take more, which is not counted.

    Raises
    ------
    ModelError : the model or an option is wrong; no speed, torque or power, no width of helical teeth.
    """
    from .efficiency import efficiency as run

    return run(drive.train, options)


VERBS = (
    Verb(
        run=stiffness,
        gives=("stiffness",),
        question="How do the teeth carry it?",
        line="Mesh stiffness over the mesh cycle.",
        drawing=True,
        in_report=20,
    ),
    Verb(
        run=contact,
        gives=("contact",),
        question="How do the teeth carry it?",
        line="Load over all faces, stress in the roots; --mesh: one pair, its error too.",
        needs="equations torque teeth balance",
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
        question="Which number do I change?",
        line="Tip relief and lead modification that are best.",
        needs="torque any_teeth",
        examples=(
            {
                **{"mesh": "sun-planet", "vary": {"tip_relief.amount": "0..40 um", "tip_relief.length": "1..3 mm"}},
                **{"population": 4, "generations": 1, "samples": 8, "slices": 4},
            },
        ),
        drawing=True,
        model_text=model_in("relieved_model"),
    ),
    Verb(
        run=efficiency,
        gives=("efficiency",),
        question="How do the teeth carry it?",
        line="Power lost in the meshes, efficiency, self-locking.",
        needs="flow contact_lines",
        drawing=True,
        in_report=35,
        examples=({}, {"viscosity": 0.02, "roughness": 0.6e-6}),
    ),
)
