"""The command `epicyclic transient`: motion over time, stopped and continued.

Depends on: console, studies, terminal, imported when used.
"""

from __future__ import annotations

import re
import shutil
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from ..errors import ModelError
from .console import complain, frequency, reported, seconds
from .options import Json, Model, Output, Sets, run_verb

__all__ = ["transient"]


class Method(StrEnum):
    """How `transient` integrates."""

    rk4 = "rk4"
    dop853 = "dop853"
    radau = "radau"


class Contact(StrEnum):
    """What the teeth do."""

    unilateral = "unilateral"
    linear = "linear"


def transient(
    model: Model,
    sets: Sets = None,
    as_json: Json = False,
    output: Output = None,
    duration: Annotated[
        str | None, typer.Option("--duration", help='Length of the run, e.g. "0.5 s".', show_default="100 mesh cycles")
    ] = None,
    cycles: Annotated[int | None, typer.Option("--cycles", min=1, help="Length in mesh cycles instead.")] = None,
    begin: Annotated[
        str | None,
        typer.Option("--from", help='Mesh frequency at the beginning, e.g. "20 Hz".', show_default="operating"),
    ] = None,
    end: Annotated[str | None, typer.Option("--to", help="Mesh frequency at the end; a straight ramp between.")] = None,
    torque: Annotated[
        Path | None, typer.Option("--torque", metavar="FILE", help="Torques over time: CSV, time [s], sun [N m], ...")
    ] = None,
    torque_step: Annotated[
        str | None, typer.Option("--torque-step", metavar="FACTOR@TIME", help='E.g. "1.5@0.2 s", of all torques.')
    ] = None,
    torque_ramp: Annotated[
        str | None, typer.Option("--torque-ramp", help="Time in which all torques grow from zero: a start-up.")
    ] = None,
    start: Annotated[
        str, typer.Option("--start", help="equilibrium, rest, or the .nc file of a run, which goes on from its end.")
    ] = "equilibrium",
    samples: Annotated[
        int, typer.Option("--samples", min=1, help="Instants per mesh cycle at the highest speed.")
    ] = 32,
    decimate: Annotated[int, typer.Option("--decimate", min=1, help="Keep every so many of them.")] = 1,
    contact: Annotated[
        Contact, typer.Option("--contact", help="Teeth that part, or a linear model.")
    ] = Contact.unilateral,
    method: Annotated[Method, typer.Option("--method", help="Fixed steps, or scipy's variable ones.")] = Method.rk4,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue a run that was stopped; needs the same -o and options.")
    ] = False,
) -> None:
    """Motion over time: start-up, torque steps and histories, speed ramps through resonance."""
    with reported():
        options: dict[str, Any] = {
            "duration": None if duration is None else seconds(duration, "--duration"),
            "cycles": cycles,
            "mesh_frequency": _ends(begin, end),
            "torque": torque,
            "torque_step": None if torque_step is None else _step(torque_step),
            "torque_ramp": None if torque_ramp is None else seconds(torque_ramp, "--torque-ramp"),
        }
        folder = _folder(output, resume)
    options |= {"start": start, "samples": samples, "decimate": decimate, "resume": resume, "folder": folder}
    try:
        run_verb("transient", model, sets, as_json, output, contact=contact.value, method=method.value, **options)
    except typer.Exit as stopped:
        if stopped.exit_code == 130 and folder is not None and any(folder.glob("*.npy")):
            complain(f"what is done is kept in {folder}; the same command with --resume continues it")
        raise
    if folder is not None:
        shutil.rmtree(folder, ignore_errors=True)


def _ends(begin: str | None, end: str | None) -> float | tuple[float, float] | None:
    first, last = (
        None if text is None else frequency(text, option) for text, option in ((begin, "--from"), (end, "--to"))
    )
    if last is None or first is None:
        if last is not None:
            raise ModelError("needs --from too", path="--to", allowed="both ends of a ramp, or --from alone")
        return first
    return first, last


def _step(text: str) -> tuple[float, float]:
    found = re.fullmatch(r"\s*([+-]?[0-9.]+(?:[eE][+-]?\d+)?)\s*@(.+)", text)
    try:
        factor = float(found[1]) if found else None
    except ValueError:
        factor = None
    if found is None or factor is None:
        raise ModelError("not a torque step", path="--torque-step", given=text, allowed='FACTOR@TIME, e.g. "1.5@0.2 s"')
    return factor, seconds(found[2], "--torque-step")


def _folder(output: Path | None, resume: bool) -> Path | None:
    """Where what is done is kept while a run that is written to a file goes on."""
    if output is None:
        if resume:
            raise ModelError("needs the file of the run that was stopped", path="--resume", allowed="-o FILE.nc")
        return None
    return output.with_name(output.name + ".parts") if output.absolute().parent.is_dir() else None
