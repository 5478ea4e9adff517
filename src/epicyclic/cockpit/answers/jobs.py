"""Jobs of the page: what takes longer than a lever waits, each with its label, its defaults and its result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...document.tables import PlainTable
from ...errors import ModelError
from .job_results import (
    JobFrame,
    contact_frame,
    contact_loss_frame,
    sensitivity_frame,
    stiffness_frame,
    tolerance_frame,
    transient_frame,
)

if TYPE_CHECKING:
    import xarray as xr

Source = PlainTable | Path
Progress = Callable[..., None]
Result = tuple[JobFrame, "xr.Dataset"]

# Length of a tip relief that is searched, in modules: from the tip to the highest point of single contact at most.
_LENGTHS = (0.1, 0.7)
# Amounts that are searched, per first estimate.
_AMOUNTS = 2.0
# Candidates and generations of the quick search: two variables and one objective need no more.
_POPULATION, _GENERATIONS = 12, 8
# Loads whose largest transmission error is made least, relative: of one alone the search would fit it and no other.
_LOADS = (0.75, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class JobKind:
    """A kind of job.

    name, label : of the page.  about : what it does by default, in a sentence.  seconds : on ren2021, about; a train
        of several stages or planets may take minutes.
    options : name -> what it means; a job refuses others.
    run : (source, overrides, options, progress) -> frame and Dataset; progress is called with the share done 0..1 or
        with (done, of), and may raise to end the job.  Raises ModelError, ConvergenceError as its verb.
    """

    name: str
    label: str
    about: str
    seconds: float
    options: Mapping[str, str]
    run: Callable[[Source, Mapping[str, object], Mapping[str, Any], Progress], Result]


def _known(name: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Options of a job.

    Raises
    ------
    ModelError : one that it does not have.
    """
    for key, value in options.items():
        if key not in JOBS[name].options:
            allowed = ", ".join(JOBS[name].options) or "none"
            raise ModelError("no such option", path=f"{name}.{key}", given=value, allowed=allowed)
    return dict(options)


def _contact_loss(source: Source, overrides: Mapping[str, object], options: Mapping[str, Any], go: Progress) -> Result:
    from ...questions.response.verbs import sweep

    chosen = {"points": 60, "shaft_orders": False, **_known("contact_loss", options)}
    result = sweep(source, overrides=dict(overrides), contact_loss=True, progress=go, **chosen)
    return contact_loss_frame(result), result


def _relief(source: Source, overrides: Mapping[str, object], options: Mapping[str, Any], go: Progress) -> Result:
    from ...questions.flanks.verbs import relief
    from ...train.resolution import load
    from .answers import estimates_of
    from .job_results import relief_frame

    chosen = _known("relief", options)
    train = load(source, dict(overrides))
    estimates = estimates_of(train)
    if not estimates:
        raise ModelError("no tooth is loaded", path="operation.torque", allowed="face widths, and a torque of a member")
    one = max(estimates, key=lambda found: found.amount)
    high, (short, long) = _AMOUNTS * one.amount * 1e6, (share * one.module * 1e3 for share in _LENGTHS)
    vary = {"tip_relief.amount": f"0..{high:.3g} um", "tip_relief.length": f"{short:.3g}..{long:.3g} mm"}
    stage, pair = one.pair.split(".")[1], one.pair.rpartition(".")[2]
    mesh = pair if len(train.planets) == 1 else next(m.name for m in train.meshes if m.pair == one.pair)
    settings = {
        "mesh": mesh,
        "vary": vary,
        "loads": _LOADS,
        "population": _POPULATION,
        "generations": _GENERATIONS,
        **chosen,
    }
    result = relief(source, overrides=dict(overrides), progress=go, **settings)
    return relief_frame(result, f"{pair} of {stage}" if len(train.planets) > 1 else pair), result


def _tolerance(source: Source, overrides: Mapping[str, object], options: Mapping[str, Any], go: Progress) -> Result:
    from ...questions.tolerance.verbs import tolerance
    from ...train.resolution import load

    chosen = {"samples": 16_384, "effects": "shares", **_known("tolerance", options)}
    result = tolerance(source, overrides=dict(overrides), progress=go, **chosen)
    return tolerance_frame(load(source, dict(overrides)), result), result


def _transient(source: Source, overrides: Mapping[str, object], options: Mapping[str, Any], go: Progress) -> Result:
    from ...questions.transient.verbs import transient

    chosen = {"cycles": 50.0, **_known("transient", options)}
    result = transient(source, overrides=dict(overrides), progress=go, **chosen)
    return transient_frame(result), result


def _contact(source: Source, overrides: Mapping[str, object], options: Mapping[str, Any], go: Progress) -> Result:
    from ...questions.flanks.verbs import contact
    from ...train.resolution import load

    chosen = {"loads": (0.5, 1.0, 1.25), **_known("contact", options)}
    show = chosen.pop("show", "error")
    go(0.05)
    result = contact(source, overrides=dict(overrides), **chosen)
    stage = len(load(source, dict(overrides)).planets) > 1
    return contact_frame(result, show=str(show), stage=stage), result


def _stiffness(source: Source, overrides: Mapping[str, object], options: Mapping[str, Any], go: Progress) -> Result:
    from ...questions.flanks.verbs import stiffness

    go(0.05)
    result = stiffness(source, overrides=dict(overrides), **_known("stiffness", options))
    return stiffness_frame(result), result


def _sensitivity(source: Source, overrides: Mapping[str, object], options: Mapping[str, Any], go: Progress) -> Result:
    from ...questions.sensitivity.verbs import sensitivity

    result = sensitivity(source, overrides=dict(overrides), progress=go, **_known("sensitivity", options))
    return sensitivity_frame(result), result


_KINDS = (
    JobKind(
        name="contact",
        label="Contact and LTE",
        about="Loaded teeth of the first mesh at 50, 100 and 125 % of the operating load.",
        seconds=0.5,
        options={
            "mesh": "a mesh or a pair",
            "loads": "relative to the operating one",
            "samples": "phases of a mesh cycle",
            "slices": "along the face",
            "show": "error: over the mesh cycle; load: along the face",
        },
        run=_contact,
    ),
    JobKind(
        name="relief",
        label="Relief",
        about="Tip relief with the least transmission error at 75 and 100 % load, 12 candidates, 8 generations.",
        seconds=3,
        options={
            "mesh": "a mesh or a pair",
            "vary": "bounds by key",
            "objectives": "lte, load, force_rms, force_peak",
            "loads": "relative to the operating one",
            "population": "candidates of a generation",
            "generations": "number of them",
        },
        run=_relief,
    ),
    JobKind(
        name="stiffness",
        label="Stiffness and phases",
        about="Mesh stiffness of every mesh over one mesh cycle, each with its phase.",
        seconds=0.1,
        options={"samples": "phases of a mesh cycle"},
        run=_stiffness,
    ),
    JobKind(
        name="tolerance",
        label="Tolerance",
        about="K_gamma of 16384 trains drawn from the tolerances, and the share of each tolerance in its variance.",
        seconds=1,
        options={"samples": "number of trains", "limit": "K_gamma whose exceedance is counted", "seed": "of the draws"},
        run=_tolerance,
    ),
    JobKind(
        name="contact_loss",
        label="Contact loss",
        about="Run-up and coast-down over 60 speeds and the resonances, teeth part and touch again, no shaft orders.",
        seconds=2,
        options={
            "points": "number of speeds",
            "shaft_orders": "whether they count",
            "start": "lowest speed",
            "stop": "highest speed",
        },
        run=_contact_loss,
    ),
    JobKind(
        name="transient",
        label="Transient",
        about="50 mesh cycles from the equilibrium at the operating speed, teeth that part.",
        seconds=1,
        options={
            "cycles": "mesh cycles",
            "start": "mesh frequency at the beginning",
            "stop": "and at the end",
            "torque_step": "FACTOR@TIME",
            "torque_ramp": "time in which the torques grow",
        },
        run=_transient,
    ),
    JobKind(
        name="sensitivity",
        label="Sensitivity",
        about="Per cent of the lowest natural frequency per per cent of each number of the model.",
        seconds=2,
        options={"of": "frequency or force", "mode": "number of the mode", "mesh": "name of the mesh"},
        run=_sensitivity,
    ),
)
JOBS: Mapping[str, JobKind] = {kind.name: kind for kind in _KINDS}
"""Name -> job, in the order of the page."""
