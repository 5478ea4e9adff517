"""What takes longer than a slider: jobs of verbs, each with a picture and a sentence."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import ModelError
from ..computing.frames import PageFrame
from .job_frames import bars, lines

if TYPE_CHECKING:
    import xarray as xr


__all__ = ["JOBS", "JobKind"]

Progress = Callable[..., None]
Options = Mapping[str, Any]
# Speeds of a sweep in which teeth part: bends show, and ren2021 takes some 10 s.
_SPEEDS = 60
# The search for a relief: generations and candidates that settle two variables to some hundredths of the best, in 10 s
# for one pair of ren2021; its tooth contact to a twentieth, as of the report.
_POPULATION, _GENERATIONS, _CONTACT = 16, 10, 0.05
# Relief is searched up to so many deflections of the teeth at the operating load, over these parts of a module.
_DEFLECTIONS, _LENGTHS = 3.0, (0.25, 1.0)
# A run-up over resonances, in mesh cycles at its mean speed, between these parts of the operating speed.
_CYCLES, _FROM, _TO = 300, 0.2, 1.2
_SHOWN = 2000  # points of a curve over time: the pane has some 500 pixels
_BARS = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class JobKind:
    """A job.  run(source, overrides, options, progress) -> (frame, Dataset); progress(share) or progress(done, of).

    A progress that raises ends the job.  takes : how long on the ready drive ren2021, two cores.
    """

    name: str
    label: str
    takes: str
    run: Callable[[Any, Mapping[str, object], Options, Progress], tuple[PageFrame, xr.Dataset]]


def _contact_loss(
    source: Any, overrides: Mapping[str, object], options: Options, progress: Progress
) -> tuple[PageFrame, xr.Dataset]:
    from ...verbs.sweep import sweep

    points = int(options.get("points", _SPEEDS))
    result = sweep(source, overrides=dict(overrides), contact_loss=True, points=points, progress=progress)
    speed = 100 * result["speed"].to_numpy()
    peak = 1e-3 * result["mesh_force_peak"].max("mesh")
    apart = result["contact_open"].max("mesh").max("direction").to_numpy() > 0
    at = int(np.abs(speed - 100).argmin())
    where = (
        f"teeth part from {speed[apart].min():.3g} to {speed[apart].max():.3g} %" if apart.any() else "no teeth part"
    )
    now = "" if not apart.any() else f", at operation {'too' if apart[at] else 'not'}"
    text = f"Between {speed[0]:.3g} and {speed[-1]:.3g} % of the operating speed {where}{now}."
    curves = [("run-up", peak.sel(direction="up")), ("coast-down", peak.sel(direction="down"))]
    labels: dict[str, Any] = {"x_label": "speed [% of operating]", "y_label": "largest mesh force [kN]"}
    return lines("contact_loss", "Contact loss over speed", text, x=speed, curves=curves, **labels), result


def _relief(
    source: Any, overrides: Mapping[str, object], options: Options, progress: Progress
) -> tuple[PageFrame, xr.Dataset]:
    from ...studies.source import system_of, train_of
    from ...verbs.relief import relief

    train = train_of(source, overrides=dict(overrides))
    largest = _DEFLECTIONS * _deflection(system_of(train))
    module = 1e3 * min(body.gear.module for body in train.bodies if body.gear is not None)
    low, high = (part * module for part in _LENGTHS)
    result = relief(
        source,
        overrides=dict(overrides),
        vary=[f"tip_relief.amount=0..{1e6 * largest:.3g} um", f"tip_relief.length={low:.3g}..{high:.3g} mm"],
        population=int(options.get("population", _POPULATION)),
        generations=int(options.get("generations", _GENERATIONS)),
        tolerance=_CONTACT,
        progress=progress,
    )
    before, after = float(result["objective_before"][0]), float(result["solution_objective"][0, 0])
    amount, length = (str(text) for text in result["solution_text"].to_numpy()[0])
    apply = json.loads(str(result.attrs["overrides"]))
    text = (
        f"Relieve all tips by {_rounded(amount)} over {_rounded(length)}: the transmission error under load falls from "
        f"{1e6 * before:.3g} to {1e6 * after:.3g} um peak to peak."
    )
    load = 100 * result["load_factor"].to_numpy()
    error = 1e6 * result["relieved_peak_to_peak"]
    curves = [
        (f"{_mesh(mesh)}, {words}", error.sel(state=state, relieved_mesh=mesh))
        for mesh in result["relieved_mesh"].to_numpy()
        for state, words in (("before", "as drawn"), ("after", "relieved"))
    ]
    more = {"apply": apply, "apply_label": "Grind this relief"}
    labels: dict[str, Any] = {"x_label": "load [% of operating]", "y_label": "transmission error, peak to peak [um]"}
    return lines("relief", "Tip relief", text, x=load, curves=curves, more=more, **labels), result


def _tolerance(
    source: Any, overrides: Mapping[str, object], options: Options, progress: Progress
) -> tuple[PageFrame, xr.Dataset]:
    from ...verbs.tolerance import tolerance

    more: dict[str, Any] = {"samples": int(options["samples"])} if "samples" in options else {}
    result = tolerance(source, overrides=dict(overrides), progress=progress, **more)
    edge = result["bin_edge"].to_numpy()
    share = result["system_histogram"] / result["system_histogram"].sum("bin")
    above = 100 * (1 - share.cumsum("bin"))
    names = {"mean-load": "mean-load (K_gamma)", "mean-load-turning": "largest while turning"}
    curves: list[tuple[str, Any]] = [(names.get(str(one), str(one)), above.sel(definition=one)) for one in result["definition"].to_numpy()]
    quantile = result["system_k_gamma_quantile"].sel(definition="mean-load").sel(probability=0.95, method="nearest")
    text = f"95 % of the trains stay below K_gamma {float(quantile):.3f}.{_largest_share(result)}"
    known = share.sum("definition").to_numpy() > 0
    last = int(np.flatnonzero(known)[-1]) + 2 if known.any() else None
    curves = [(label, curve.to_numpy()[:last]) for label, curve in curves]
    x = edge[1:][:last]
    labels: dict[str, Any] = {"x_label": "load-sharing coefficient [1]", "y_label": "trains above it [%]"}
    return lines("tolerance", "Tolerances", text, x=x, curves=curves, **labels), result


def _largest_share(result: xr.Dataset) -> str:
    """The tolerance that gives most of the variance of K_gamma, as a sentence."""
    if "sobol_total" not in result:
        return ""
    spread = np.nan_to_num(result["k_gamma_std"].sel(definition="mean-load").to_numpy())
    total = result["sobol_total"].sel(definition="mean-load").isel(pair=int(spread.argmax()))
    shares = np.nan_to_num(total.to_numpy())
    if not shares.size or not shares.max() > 0:
        return ""
    name = str(result["tolerance"].to_numpy()[int(shares.argmax())])
    return f" {name} gives {100 * shares.max():.0f} % of its variance."


def _transient(
    source: Any, overrides: Mapping[str, object], options: Options, progress: Progress
) -> tuple[PageFrame, xr.Dataset]:
    from ...studies.source import system_of
    from ...verbs.transient import transient

    system = system_of(source, overrides=dict(overrides))
    tones = [float(tone) for tone in system.tones if tone > 0]
    if not tones:
        raise ModelError("no speed to run up to", path="operation.speed", allowed="the speed of one member")
    cycles = float(options.get("cycles", _CYCLES))
    start, stop = _FROM * tones[0], _TO * tones[0]
    result = transient(system, cycles=cycles, mesh_frequency=(start, stop), progress=progress)
    time, force = result["time"].to_numpy(), 1e-3 * result["mesh_force"].to_numpy()
    step = max(1, -(-len(time) // _SHOWN))
    cut = len(time) // step * step
    # of every few instants the extremes, so that no peak is lost
    high = force.max(axis=0)[:cut].reshape(-1, step).max(axis=1)
    low = force.min(axis=0)[:cut].reshape(-1, step).min(axis=1)
    peak = int(force.max(axis=0).argmax())
    speed = 100 * float(result["relative_speed"].to_numpy()[peak])
    open_share = 100 * float(result["open_share"].max())
    apart = f"; teeth are apart for up to {open_share:.2g} % of the time" if open_share else "; no teeth part"
    text = (
        f"Run-up from {100 * _FROM:.0f} to {100 * _TO:.0f} %: largest mesh force {force.max():.3g} kN at {speed:.3g} %"
    )
    labels: dict[str, Any] = {"x_label": "time [s]", "y_label": "mesh force [kN]"}
    curves = [("largest of all meshes", high), ("smallest of all meshes", low)]
    return lines("transient", "Run-up", f"{text}{apart}.", x=time[:cut:step], curves=curves, **labels), result


def _contact(
    source: Any, overrides: Mapping[str, object], options: Options, progress: Progress
) -> tuple[PageFrame, xr.Dataset]:
    from ...verbs.contact import contact

    progress(0.05)
    mesh = options.get("mesh")
    result = contact(source, overrides=dict(overrides), mesh=mesh, tolerance=_CONTACT)
    load = result["mesh_load"].to_numpy()
    phase = result["mesh_phase"].to_numpy()
    order = np.argsort(phase)
    error = 1e6 * result["loaded_transmission_error"].to_numpy()
    error = error - error.mean(axis=1, keepdims=True)
    here = int(result.attrs.get("operating_load", _operating(load)))
    pressure = 1e-6 * float(result["largest_pressure"].isel(mesh_load=here).max())
    factor = float(result["face_factor"].isel(mesh_load=here).max())
    size = 1e6 * float(result["transmission_error_peak_to_peak"].isel(mesh_load=here))
    text = (
        f"At {1e-3 * load[here]:.3g} kN: transmission error {size:.3g} um peak to peak, largest pressure "
        f"{pressure:.0f} MPa, largest load over the face {factor:.2f} times its mean."
    )
    curves = [(f"{1e-3 * one:.3g} kN", error[place][order]) for place, one in enumerate(load)]
    labels: dict[str, Any] = {"x_label": "mesh cycle [1]", "y_label": "transmission error about its mean [um]"}
    strong = sorted({here, 0, len(load) - 1})
    return lines("contact", "Loaded contact", text, x=phase[order], curves=curves, strong=strong, **labels), result


def _operating(load: np.ndarray[Any, Any]) -> int:
    """Place of the operating load among the loads of `contact`, which go from a tenth to one and a half of it."""
    return int(np.abs(load - load.max() / 1.5).argmin())


def _stiffness(
    source: Any, overrides: Mapping[str, object], options: Options, progress: Progress
) -> tuple[PageFrame, xr.Dataset]:
    from ...verbs.stiffness import stiffness

    progress(0.1)
    result = stiffness(source, overrides=dict(overrides))
    values = 1e-9 * result["mesh_stiffness"]
    swing = float(((values.max("mesh_phase") - values.min("mesh_phase")) / values.mean("mesh_phase")).max())
    lead = result["phase_lead"].to_numpy() % 1
    alike = "all meshes of a pair are in phase" if np.ptp(lead) < 1e-6 else "the meshes are out of phase"
    text = f"Mesh stiffness varies by up to {100 * swing:.2g} % of its mean; {alike}."
    curves = [(_mesh(mesh), values.sel(mesh=mesh)) for mesh in result["mesh"].to_numpy()]
    labels: dict[str, Any] = {"x_label": "mesh cycle [1]", "y_label": "mesh stiffness [kN/um]"}
    x = result["mesh_phase"].to_numpy()
    return lines("stiffness", "Stiffness and phases", text, x=x, curves=curves, **labels), result


def _sensitivity(
    source: Any, overrides: Mapping[str, object], options: Options, progress: Progress
) -> tuple[PageFrame, xr.Dataset]:
    from ...verbs.sensitivity import sensitivity

    try:
        result = sensitivity(source, overrides=dict(overrides), of="force", progress=progress)
        place = int(np.flatnonzero(result["ranked_by"].to_numpy())[0])
        values = result["sensitivity"].isel(mesh=place).to_numpy()
        of = f"RMS of the dynamic force of {_mesh(result['mesh'].to_numpy()[place])}"
    except ModelError:  # no damping, torque or speed: the lowest natural frequency asks for less
        result = sensitivity(source, overrides=dict(overrides), of="frequency", progress=progress)
        place = int(np.flatnonzero(result["ranked_by"].to_numpy())[0])
        values = result["sensitivity"].isel(mode=place).to_numpy()
        of = f"natural frequency of mode {place + 1}"
    order = np.argsort(-np.abs(values))[:_BARS]
    rows = [(_path(str(result["path"].to_numpy()[i])), float(values[i])) for i in order]
    text = f"{rows[0][0]} moves the {of} most: {rows[0][1]:+.2g} % per per cent."
    return bars("sensitivity", "Sensitivity", text, x_label=f"{of} [% per %]", rows=rows), result


def _deflection(system: Any) -> float:
    """Largest mean deflection of a mesh at the operating load [m].

    Raises
    ------
    ModelError : no load, or one that nothing balances.
    """
    from ...analyses.sharing.tone_forces import mean_force
    from ...analyses.static.tangent import linear

    system = linear(system)
    stiffness = np.asarray(system.meshes.stiffness)
    largest = float(np.max(np.abs(mean_force(system)) / np.where(stiffness > 0, stiffness, np.inf), initial=0.0))
    if not largest > 0:
        raise ModelError("no load, so nothing to relieve", path="operation.torque", allowed="a torque")
    return largest


def _mesh(name: str) -> str:
    """``main/sun-planet/1/left`` as ``sun-planet 1 left``."""
    return " ".join(str(name).split("/")[1:])


def _path(path: str) -> str:
    """The last keys of a path, for a bar."""
    return ".".join(path.removeprefix("stages.").removeprefix("deviations.").split(".")[-3:])


def _rounded(text: str) -> str:
    """``14.948 um`` as ``14.9 um``."""
    number, _, unit = text.partition(" ")
    return f"{float(number):.3g} {unit}"


JOBS: Mapping[str, JobKind] = {
    one.name: one
    for one in (
        JobKind(name="contact", label="Loaded contact", takes="2 s", run=_contact),
        JobKind(name="relief", label="Tip relief", takes="15 s", run=_relief),
        JobKind(name="stiffness", label="Stiffness and phases", takes="1 s", run=_stiffness),
        JobKind(name="tolerance", label="Tolerances", takes="5 s", run=_tolerance),
        JobKind(name="contact_loss", label="Contact loss over speed", takes="10 s", run=_contact_loss),
        JobKind(name="transient", label="Run-up", takes="10 s", run=_transient),
        JobKind(name="sensitivity", label="Sensitivity", takes="2 s", run=_sensitivity),
    )
}
"""Jobs by name."""
