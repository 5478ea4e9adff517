"""The command `epicyclic contact`: loaded tooth contact of one mesh.

Depends on: console, studies, imported when used.
"""

from __future__ import annotations

from typing import Annotated, Any

import typer

from ..errors import ModelError
from .console import reported
from .options import Json, Model, Output, Sets, run_verb

__all__ = ["contact"]


def contact(
    model: Model,
    sets: Sets = None,
    as_json: Json = False,
    output: Output = None,
    mesh: Annotated[
        str | None,
        typer.Option(
            "--mesh", metavar="NAME", help="A mesh, main/sun-planet/2, or a pair, sun-planet; else the first."
        ),
    ] = None,
    torque: Annotated[
        str | None, typer.Option("--torque", help='On the first gear of the mesh, e.g. "850 N m"; else as operated.')
    ] = None,
    loads: Annotated[
        str | None, typer.Option("--loads", help='Further loads, relative to the operating one: "0..1.5" or "0.5, 2".')
    ] = None,
    load_points: Annotated[
        int, typer.Option("--load-points", min=1, max=10_000, help="Number of loads in a range.")
    ] = 7,
    samples: Annotated[int, typer.Option("--samples", min=3, max=100_000, help="Phases of a mesh cycle.")] = 64,
    slices: Annotated[int, typer.Option("--slices", min=1, max=1000, help="Pieces of each face.")] = 20,
    misalignment: Annotated[
        str | None, typer.Option("--misalignment", help='Of the flanks, e.g. "0.1 mrad"; positive opens the right end.')
    ] = None,
    torque_end_a: Annotated[
        str | None, typer.Option("--torque-end-a", help="Where torque leaves the first gear: left or right; it twists.")
    ] = None,
    torque_end_b: Annotated[str | None, typer.Option("--torque-end-b", help="The same of the second gear.")] = None,
    train: Annotated[
        bool, typer.Option("--train", help="All meshes at once, in the train's own equilibrium; loads are torques.")
    ] = False,
    corner: Annotated[bool, typer.Option("--corner", help="Let tips bear beyond the path of contact.")] = False,
) -> None:
    """Teeth in contact: load over the flank, loaded transmission error, stiffness, at several loads.

    With --train every mesh of the train at once, misaligned by its own tilt and twist: load along the faces, K_Hbeta,
    K_gamma over torque.
    """
    options: dict[str, Any] = {"mesh": mesh, "torque": torque, "samples": samples, "slices": slices, "corner": corner}
    options["torque_ends"] = (torque_end_a, torque_end_b)
    if misalignment is not None:
        options["misalignment"] = misalignment
    if loads is not None:
        with reported():
            from ..studies.tooth_contact import factors_of

            options["factors"] = factors_of(loads, load_points)
    if train:
        with reported():
            options = _of_train(options)
    run_verb("train_contact" if train else "contact", model, sets, as_json, output, **options)


def _of_train(options: dict[str, Any]) -> dict[str, Any]:
    """Options that mean something for a whole train.

    Raises
    ------
    ModelError : one that belongs to a single mesh.
    """
    kept: dict[str, Any] = {
        name: options[name] for name in ("samples", "slices", "corner", "factors") if name in options
    }
    for name in ("mesh", "torque", "misalignment", "torque_ends"):
        if any(value is not None for value in _values(options.get(name))):
            raise ModelError("belongs to a single mesh", path=f"--{name.replace('_', '-')}", allowed="without --train")
    return kept


def _values(given: Any) -> tuple[Any, ...]:
    return given if isinstance(given, tuple) else (given,)
