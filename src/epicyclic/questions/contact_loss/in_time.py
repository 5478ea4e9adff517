"""The steady motion followed in time, where ripple parts teeth and no torus of its phases is solved.

The run is cut into stretches of whole mesh cycles, at least 24 cycles of the slowest line each, until the RMS of all
mesh forces of one stretch is that of the stretch before.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...errors import ConvergenceError, ModelError
from ...machine_code import numba_available
from ...statics.record import reference_tone
from ...statics.signals import error_waves
from ...system.system import Array, System, faces
from ...warning_codes import CodedText, coded
from ..response.measures import record_link_measures
from ..response.response import Response
from ..response.spectra import lateral_pairs, link_labels
from ..response.sweep_table import ROWS
from ..transient import TransientOptions
from ..transient.transient import transient
from .branch_set import Measures
from .rows import gap_rows_of, reported_links
from .shaft_orders import ShaftResponse
from .solutions import Stability

FOLLOWED, RATTLE = "followed in time", "teeth rattle, followed in time"
"""Status of a motion that a run in time has found."""
_CYCLES, _MOST, _SAMPLES = 24, 16, 64
# Change of the RMS of mesh forces per the largest from one stretch to the next that is none, and that is refused.
_SETTLED, _REFUSED = 0.005, 0.05


class SettledRun(NamedTuple):
    """The last stretch of a run.

    run : Dataset of `transient`.  cycles : of the mesh.  rms : (w,) of mesh forces [N].  change : of the RMS, from the
    stretch before, per the largest.  text : what parts teeth, and how far the run has settled.
    """

    run: Any
    cycles: int
    rms: Array
    change: float
    text: str

    def rattles(self, names: Sequence[str]) -> list[CodedText]:
        """`rattle_warnings` of whole meshes by their names."""
        run, mean = self.run, self.run.mesh_force.values[:, :-1].mean(axis=1)
        ends = run.mesh_force_minimum.values, run.mesh_force_peak.values
        return rattle_warnings(names, mean, ends, run.open_share.values, run.far_share.values)

    def ranges(self) -> dict[str, Any]:
        """Dimensions and values of the transmission errors' ranges, by the names of their variables."""
        peaks = [str(name) for name in self.run.data_vars if str(name).endswith("peak_to_peak")]
        return {name: (self.run[name].dims, self.run[name].values) for name in peaks}


def ripple_causes(causes: Iterable[Sequence[str]]) -> list[str]:
    """Ripples of torque or motion among the causes of every line, `operation.ripple` or that of a case."""
    return list(dict.fromkeys(cause for one in causes for cause in one if ".ripple." in cause))


def settled_run(system: System, speed: float, ripples: Sequence[str]) -> SettledRun:
    """The run at a relative speed until it has settled.

    Raises
    ------
    ConvergenceError : the motion does not settle, or there are no compiled steps.
    """
    causes = "; ".join(ripples)
    if not numba_available():
        raise ConvergenceError(
            f"{causes}: parts teeth, and the motion has to be followed in time, which takes minutes without numba: "
            'install "epicyclic[fast]", or transient shows it'
        )
    tone = float(reference_tone(system)) * speed
    slowest = min(float(line.frequency) for line in system.lines if line.frequency) * speed
    cycles = max(_CYCLES, math.ceil(_CYCLES * tone / slowest))
    rms, change = np.zeros(0), math.inf
    run: Any = "equilibrium"  # each stretch begins where the one before ends
    for _ in range(_MOST):
        options_of_run = TransientOptions(cycles=cycles, mesh_frequency=tone, samples=_SAMPLES, initial=run)
        try:
            run = transient(system, options_of_run)
        except ModelError as error:  # a slow ripple takes more cycles than a run may have
            text = f"{causes}: parts teeth, and {cycles} mesh cycles are too many to follow in time: {error}"
            raise ConvergenceError(text) from error
        before, rms = rms, run.mesh_force.values[:, :-1].std(axis=1)
        change = float(np.abs(rms - before).max() / (rms.max() or 1.0)) if before.size else math.inf
        if change <= _SETTLED or not np.isfinite(rms).all():
            break
    if not change <= _REFUSED:
        raise ConvergenceError(
            f"{causes}: parts teeth, and the motion followed in time does not settle: its RMS still changes by "
            f"{change:.2g} from one stretch of {cycles} mesh cycles to the next; transient shows it"
        )
    text = f"{causes}: parts teeth; followed in time over {cycles} mesh cycles, RMS settled to {change:.1g}"
    return SettledRun(run, cycles, rms, change, text)


def response_in_time(ready: Response, speed: float, ripples: Sequence[str]) -> ShaftResponse:
    """The motion at a relative speed with shaft orders, as a run in time has it; where there is none, why."""
    system = ready.system
    try:
        found = settled_run(system, speed, ripples)
    except ConvergenceError as error:
        return ShaftResponse(status=str(error))
    run, names = found.run, faces(system.meshes).name
    linear = reported_links(ready)[0].links.name == system.links.name  # rows of laws are not in a run
    links = {**(_links(system, run) if linear else {}), **found.ranges()}
    measures = Measures(
        rms=found.rms,
        highest=run.mesh_force_peak.values,
        lowest=run.mesh_force_minimum.values,
        open=run.open_share.values,
        amplitude=np.ptp(run.displacement.values, axis=1) / 2,
        flank=np.full(gap_rows_of(ready).count, np.nan),
        links={name: values for name, (_, values) in links.items()},
    )
    status = RATTLE if found.rattles(names) else FOLLOWED
    return ShaftResponse(status=status, measures=measures, residual=found.change)


def followed_in_time(system: System, speed: float, ripples: Sequence[str], options: dict[str, Any]) -> xr.Dataset:
    """The Dataset of `contact_steady`, of the last stretch of the run; ``residual`` is the change of its RMS.

    Raises
    ------
    ConvergenceError : as of `settled_run`.
    """
    from ...results.dataset import dataset

    found = settled_run(system, speed, ripples)
    run, cycles, _, change, text = found
    names, force = faces(system.meshes).name, run.mesh_force.values[:, :-1]
    folded, along = force.reshape(len(force), cycles, _SAMPLES), ("mesh", "mesh_phase")
    open_share, far_share = run.open_share.values, run.far_share.values
    said: list[CodedText] = json.loads(str(run.attrs["warnings"]))  # those of the system too
    notes = [coded("followed-in-time", text), *found.rattles(names)]
    return dataset(
        {
            "mesh_force": (along, folded.mean(axis=1)),
            "mesh_force_least": (along, folded.min(axis=1)),
            "mesh_force_most": (along, folded.max(axis=1)),
            "mesh_force_rms": ("mesh", found.rms),
            "mesh_force_bound": ("mesh", run.mesh_force_peak.values),
            "mesh_force_minimum": ("mesh", run.mesh_force_minimum.values),
            "open_share": ("mesh", open_share),
            "far_share": ("mesh", far_share),
            "contact_lost": ("mesh", open_share + far_share > 0),
            "amplitude": ("dof", np.ptp(run.displacement.values, axis=1) / 2),
            **_links(system, run),
            **_errors(system, run, cycles),
            **found.ranges(),
            **judged(FOLLOWED, None, residual=change, dropped=np.nan),
        },
        {
            "mesh": list(names),
            **link_labels(system),
            "dof": list(system.dofs.names),
            **({"shaft": list(system.errors.shaft)} if system.errors.shaft else {}),
            "mesh_phase": np.arange(_SAMPLES) / _SAMPLES,
            "mesh_frequency": float(reference_tone(system)) * speed,
        },
        verb="steady",
        options={**options, "cycles": cycles},
        provenance=system.provenance,
        warnings=[*said, *notes],
    )


def rattle_warnings(
    names: Sequence[str], mean: Array, ends: tuple[Array, Array], open_share: Array, far_share: Array
) -> list[CodedText]:
    """A warning of the meshes (w,) that part and whose mean force is below half the range of its ends (w,) [N]."""
    least, most = ends
    light = (np.abs(mean) < (most - least) / 2) & (open_share + far_share > 0)
    if not light.any():
        return []
    which = ", ".join(name for name, less in zip(names, light, strict=True) if less)
    shares = f"apart for up to {open_share[light].max():.2g} of the time"
    if far_share[light].any():
        shares += f", on the far flank for up to {far_share[light].max():.2g}"
    return [coded("teeth-rattle", f"the mean load is below the ripple: the teeth of {which} rattle, {shares}")]


def judged(status: str, stability: Stability | None, *, residual: float, dropped: float) -> dict[str, Any]:
    """Variables of how a steady motion was found and whether it is stable; None: not known."""
    return {
        "status": ((), status if stability is None or stability.stable else "unstable"),
        "instability": ((), "" if stability is None else stability.kind or "stable"),
        "largest_multiplier": ((), np.nan if stability is None else abs(stability.multiplier)),
        "multiplier_error": ((), np.nan if stability is None else stability.error),
        "residual": ((), residual),
        "residual_dropped": ((), dropped),
    }


def _errors(system: System, run: xr.Dataset, cycles: int) -> dict[str, Any]:
    """Transmission errors over the mesh phase, mean over the cycles of a run."""
    waves = system.error_rows.T @ (run.displacement.values / system.dofs.radius[:, None])
    folded = waves[:, :-1].reshape(len(waves), cycles, _SAMPLES).mean(axis=1)
    return error_waves(system.errors, folded, "mesh_phase")


def _links(system: System, run: xr.Dataset) -> dict[str, Any]:
    """Measures of the linear links over a run, those of two lateral rows as bearings."""
    measures = record_link_measures(run.link_force.values[:, :-1], lateral_pairs(system), system.links.turn)
    return {name: (ROWS[name], values) for name, values in measures.items() if values.size}
