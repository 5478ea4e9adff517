"""The verb load_factors."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ...options import ALL_CASES, Progress
from ...verbs.record import Verb, takes
from . import LoadFactorOptions

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Drive, Overrides
    from ...rexs.export import RexsExport


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


VERBS = (
    Verb(
        run=load_factors,
        gives=("load_factors",),
        drawing=True,
        examples=({}, {"flanks": "contact", "tolerance": 0.1}),
        writers=dict.fromkeys((".rexs", ".rexsj", ".rexsz"), _rexs),
    ),
)
