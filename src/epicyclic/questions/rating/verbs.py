"""The verbs life, load_factors and spectrum.

The verb life.

The verb load_factors.

The verb spectrum, whose source is a load history and no model.
"""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import ModelError
from ...options import ALL_CASES, Progress
from ...verbs.record import RESPONSE, Verb, takes
from . import EXAMPLE, LifeOptions, LoadFactorOptions, SpectrumOptions

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Drive, Overrides
    from ...rexs.export import RexsExport


@takes(LifeOptions, joint=True)
def life(drive: "Drive", options: LifeOptions, progress: Progress | None = None) -> "xr.Dataset":
    """Life of the rolling bearings that the drawing states by their parts, under static forces, over load cases.

    Forces count over the turns of all bodies, with weight, run-outs and the loads of the file, at rest or of the steady
    vibration.  All load cases are summed by their shares of the time.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : the model or an option is wrong; no bearing is stated by its parts; a train that does not turn.
    ConvergenceError : no equilibrium.
    """
    from .life import with_changes

    if not options.changes:
        return _lives(drive, options, {}, progress)
    return with_changes(_lives(drive, options, {}), partial(_lives, drive, options), progress)


def _lives(
    drive: "Drive", options: LifeOptions, changes: "Overrides", progress: Progress | None = None
) -> "xr.Dataset":
    """Lives of a drive with changes laid over its model, over its one point or all load cases."""
    from ...verbs.cases import duty_of
    from .life import life as run

    changed = drive.changed(changes) if changes else drive
    return run(duty_of(changed) or changed.train, options, progress=progress)


_EXAMPLES = ({"instants": 32, **EXAMPLE}, {"instants": 8, "forces": "steady", "changes": True, **EXAMPLE})


@takes(LoadFactorOptions, joint=True)
def load_factors(drive: "Drive", options: LoadFactorOptions, progress: Progress | None = None) -> "xr.Dataset":
    """What a gear rating asks: K_gamma, K_v, K_Hbeta and K_Halpha of every mesh, load cycles, equivalent torques.

    Of the operation, of one load case or, with all of them, by pair of gears, flank and case.

    Raises
    ------
    ModelError : the model or an option is wrong; no torque, a locked train.  ConvergenceError : no equilibrium.
    """
    from ...engine.points import outcomes
    from ...verbs.cases import case_names, over_cases
    from .load_factors import one_case, over_duty

    overrides = drive.overrides or {}
    if overrides.get("case") != ALL_CASES:
        return over_duty(one_case(drive.train, options), options)
    names = case_names(drive.source, overrides)
    found = outcomes(partial(_at, drive, options), names, long=True, progress=progress)
    of_case = dict(zip(names, found, strict=True))

    def known(_: object, *, overrides: "Overrides") -> "xr.Dataset":
        one = of_case[overrides["case"]]
        if one.value is None:
            assert one.error is not None
            raise one.error
        return one.value

    return over_duty(over_cases(known, drive.source, overrides, {}), options)


def _at(drive: "Drive", options: LoadFactorOptions, case: str) -> "xr.Dataset":
    """Load factors at one of the cases."""
    from .load_factors import case_factors

    return case_factors(type(drive)(drive.source, {**(drive.overrides or {}), "case": case}).train, options)


def _rexs(result: "xr.Dataset", path: Path) -> "RexsExport":
    """Write the train with its load cases and their factors as a REXS file."""
    from ...rexs.export import write_rexs

    return write_rexs(result, path)


@takes(SpectrumOptions)
def spectrum(drive: "Drive", options: SpectrumOptions) -> "xr.Dataset":
    """Load cases from a history of torque and speed: hours and revolutions by bins, cycles of the torque by rainflow.

    Parameters
    ----------
    source : a history in time or a table of bins, .csv or .xlsx; or its columns, heading with unit -> values.
    overrides : path of the model file -> value, of the train.

    Raises
    ------
    ModelError : the history, with its line, the train or an option is wrong.
    """
    from .load_spectrum import load_spectrum, read_load_history

    if options.train is None and drive.overrides:
        raise ModelError("go with a train", path="overrides", given=", ".join(drive.overrides), allowed="train")
    train = None if options.train is None else type(drive)(options.train, drive.overrides).train
    return load_spectrum(read_load_history(drive.source, options), train, options)


def _cases_text(result: "xr.Dataset") -> str:
    """The load cases as a fragment of a model file."""
    from .load_spectrum import cases_text

    return cases_text(result)


_READS = "A history in time or a table of bins (.csv, .xlsx): time [s], torque [kN m], speed [rpm]."
VERBS = (
    Verb(
        run=life,
        gives=("life",),
        question="How do the teeth carry it?",
        line="Life and load zones of rolling bearings, over load cases.",
        needs="equations speed balance rolling",
        drawing=True,
        in_report=64,
        examples=_EXAMPLES,
    ),
    Verb(
        run=load_factors,
        gives=("load_factors",),
        question="How do the teeth carry it?",
        line="K factors, load cycles and equivalent torques, for a gear rating.",
        needs=f"{RESPONSE} torque",
        drawing=True,
        examples=({}, {"flanks": "contact", "tolerance": 0.1}),
        writers=dict.fromkeys((".rexs", ".rexsj", ".rexsz"), _rexs),
    ),
    Verb(
        run=spectrum,
        gives=("spectrum",),
        question="Where do I begin?",
        line="Load cases from a history of torque and speed.",
        model_text=_cases_text,
        reads=_READS,
    ),
)
