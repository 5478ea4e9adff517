"""Results of verbs as frames of jobs: what the page says and draws of each."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...results.ties import largest, ranked
from ...show.series import label
from ...show.tolerance_labels import scattering_pair
from ...train.train import Train
from .answer import Answer, answer, number, per_cent
from .halved import halved_tolerance
from .job_frame import JobFrame, bars, job_frame, lines, mesh_words

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "contact_frame",
    "contact_loss_frame",
    "sensitivity_frame",
    "stiffness_frame",
    "tolerance_frame",
    "tolerance_shares",
    "transient_frame",
]

# Rows of bars that are read, and seen without scrolling.
_MOST = 10
# Share of the variance of K_gamma from which one tolerance is the one to talk about; part of the largest share from
# which the next one is named beside it: the draws do not tell them apart.
_HALF, _AS_LARGE = 0.5, 0.9

Array = NDArray[np.float64]


def contact_loss_frame(result: xr.Dataset) -> JobFrame:
    """Largest and least force of any mesh over speed, run-up and coast-down, and where teeth part."""
    shafts = bool(json.loads(result.attrs["options"]).get("shaft_orders"))
    relative = np.asarray(result["speed"].values, dtype=float)
    peak = result["mesh_force_peak"].transpose("direction", "mesh", "speed").values
    least = result["mesh_force_minimum"].transpose("direction", "mesh", "speed").values
    parted = result["contact_open"].transpose("direction", "mesh", "speed").values.max(axis=1) > 0
    unit, scale = _force_unit(peak)
    with np.errstate(all="ignore"):
        up, down, low = np.nanmax(peak[0], axis=0), np.nanmax(peak[-1], axis=0), np.nanmin(least[0], axis=0)
    curves = {
        "largest, run-up": up * scale,
        "largest, coast-down": down * scale,
        "least, run-up": low * scale,
    }
    drawn = lines("speed [% of operation]", f"mesh force [{unit}]", 100 * relative, curves)
    at = largest(up)
    orders = "with shaft orders" if shafts else "mesh orders alone"
    text = (
        f"Largest force {number(float(up[at]) * scale, 4)} {unit} at {per_cent(float(relative[at]))} of the speed "
        f"({orders})"
    )
    if parted.any():
        places = relative[parted.any(axis=0)]
        text += f"; teeth part from {per_cent(float(places[0]))} to {per_cent(float(places[-1]))}"
        both = parted[0] != parted[-1]
        text += ", not at the same speeds up and down." if both.any() else "."
    else:
        text += "; no tooth loses contact."
    return job_frame("contact_loss", "Teeth that part", text + _unsolved(result), drawn)


def _unsolved(result: xr.Dataset) -> str:
    """How many speeds have no motion."""
    failed = int((result["status"].values != "ok").sum()) if "status" in result else 0
    return f" {failed} points have no motion." if failed else ""


def _force_unit(force: Array) -> tuple[str, float]:
    most = float(np.nanmax(np.abs(force), initial=0.0))
    return ("kN", 1e-3) if most >= 1e3 else ("N", 1.0)


def transient_frame(result: xr.Dataset) -> JobFrame:
    """Forces of all meshes over time."""
    names = [str(name) for name in result["mesh"].values]
    words = mesh_words(names)
    force = result["mesh_force"].transpose("mesh", "time").values
    unit, scale = _force_unit(force)
    time = np.asarray(result["time"].values, dtype=float)
    ms, word = (1e3, "ms") if time[-1] < 1 else (1.0, "s")
    curves = {words[row]: scale * force[row] for row in range(len(names))}
    drawn = lines(f"time [{word}]", f"mesh force [{unit}]", ms * time, curves)
    peak = result["mesh_force_peak"].values
    at = largest(peak)
    lost = int((result["open_share"].values > 0).sum())
    text = (
        f"Largest force {number(float(peak[at]) * scale, 4)} {unit} in {words[at]} after "
        f"{number(ms * float(result['mesh_force_peak_time'].values[at]))} {word}; "
        + (f"{lost} of {len(names)} meshes lose contact." if lost else "no mesh loses contact.")
    )
    return job_frame("transient", "Motion over time", text, drawn)


def contact_frame(result: xr.Dataset, *, show: str = "error", stage: bool = False) -> JobFrame:
    """Loaded transmission error over the mesh cycle at every load, or the largest load along the face.

    stage : whether the stage of the mesh is named.
    """
    loads = np.asarray(result["mesh_load"].values, dtype=float)
    operating = int(np.abs(loads - float(result.attrs["force"])).argmin())
    swing = 1e6 * result["transmission_error_peak_to_peak"].values
    largest = 1e-3 * result["largest_load_per_length"].transpose("side", "mesh_load").values[:, operating]
    factor = result["face_factor"].transpose("side", "mesh_load").values[:, operating]
    if show == "load":
        length = result["load_per_length"].transpose("side", "width", "mesh_phase").values.max(axis=2) / 1e3
        curves = {str(side): length[row] for row, side in enumerate(result["side"].values)}
        x = np.asarray(result["width"].values, dtype=float)
        drawn = lines("place along the face [1]", "largest load [N/mm]", x, curves)
    else:
        error = 1e6 * result["loaded_transmission_error"].transpose("mesh_load", "mesh_phase").values
        share = loads / float(result.attrs["force"])
        curves = {f"{100 * share[row]:.0f} % load": error[row] - error[row].mean() for row in range(len(loads))}
        x = np.asarray(result["mesh_phase"].values, dtype=float)
        drawn = lines("mesh cycle [1]", "error about its mean [µm]", x, curves)
    text = (
        f"{label(str(result.attrs['mesh']), stage=stage)} at {number(float(loads[operating]) / 1e3, 4)} kN: "
        f"transmission error {number(float(swing[operating]))} µm peak to peak, largest load "
        f"{number(float(np.nanmax(largest)))} N/mm, face-load factor {number(float(np.nanmax(factor)))}."
    )
    return job_frame("contact", "Loaded tooth contact", text, drawn)


def stiffness_frame(result: xr.Dataset) -> JobFrame:
    """Mesh stiffness over one mesh cycle, each mesh at its phase."""
    names = [str(name) for name in result["mesh"].values]
    words = mesh_words(names)
    history = 1e-9 * result["mesh_stiffness"].transpose("mesh", "mesh_phase").values
    curves = {words[row]: history[row] for row in range(len(names))}
    x = np.asarray(result["mesh_phase"].values, dtype=float)
    drawn = lines("mesh cycle [1]", "mesh stiffness [N/nm]", x, curves)
    swing = np.ptp(history, axis=1) / history.mean(axis=1)
    most = largest(swing)
    leads = sorted({f"{float(one):.3g}" for one in result["phase_lead"].values}, key=float)
    phases = ", ".join(leads[:6]) + (" ..." if len(leads) > 6 else "")
    text = (
        f"{words[most]} varies most, {per_cent(float(swing[most]))} of its mean "
        f"{number(float(history[most].mean()))} N/nm peak to peak; phases {phases} mesh cycles."
    )
    return job_frame("stiffness", "Mesh stiffness and phases", text, drawn)


def sensitivity_frame(result: xr.Dataset) -> JobFrame:
    """Per cent per per cent of the ranked mode or mesh, the largest first."""
    dim = "mode" if "mode" in result["sensitivity"].dims else "mesh"
    targets = result["ranked_by"].values.astype(bool)
    values = result["sensitivity"].transpose("path", dim).values[:, targets]
    size = np.nan_to_num(np.abs(values)).argmax(axis=1)
    value = np.nan_to_num(values[np.arange(len(values)), size])
    order = ranked(np.abs(value))[:_MOST]
    paths = [str(path) for path in result["path"].values]
    drawn = bars("per cent per per cent", [_short_path(paths[i]) for i in order], value[order])
    subject = str(result.attrs.get("subject", ""))
    text = f"Of {subject}: "
    if len(order):
        text += f"{_short_path(paths[order[0]])} moves it most, {number(float(value[order[0]]))} % per per cent."
    else:
        text += "no number of the model moves it."
    return job_frame("sensitivity", "Sensitivity", text, drawn)


def _short_path(path: str) -> str:
    """``sun support radial`` of ``stages.main.sun.support.radial``."""
    words = path.split(".")
    return " ".join(words[2:] if words[0] == "stages" and len(words) > 2 else words).replace("_", " ")


def tolerance_frame(train: Train, result: xr.Dataset) -> JobFrame:
    """Shares of the tolerances in the variance of K_gamma of the pair that scatters most; the answer on errors."""
    names = [str(name) for name in result["tolerance"].values]
    total = tolerance_shares(result)
    order = np.argsort(-total, kind="stable")[:_MOST]
    words = [_entry_words(names[i], train) for i in order]
    drawn = bars("total effect in the variance of K_gamma [%]", words, 100 * total[order])
    quantile = result["system_k_gamma_quantile"].sel(definition="mean-load")
    at = float(quantile["probability"].values[-1])
    known = {float(p): float(v) for p, v in zip(quantile["probability"].values, quantile.values, strict=True)}
    most = 0.99 if 0.99 in known else at
    limit, above = (
        float(result["limit"].values[0]),
        float(result["system_exceedance"].sel(definition="mean-load").values[0]),
    )
    text = (
        f"K_gamma stays below {known[most]:.3f} in {100 * most:g} % of {int(result.attrs['samples'])} trains; "
        f"{per_cent(above)} are above {limit:g}. What is drawn stands in place of the numbers of the model."
    )
    change = halved_tolerance(train, names[order[0]]) if len(order) else {}
    found = _tolerance_answer(train, names, total, tolerance_shares(result, "sobol_first"), order, change)
    return job_frame(
        "tolerance", "Tolerances", text, drawn, apply=change, apply_label="Halve the first", answers=[found]
    )


def tolerance_shares(result: xr.Dataset, name: str = "sobol_total") -> Array:
    """Shares of the variance of K_gamma (mean-load) (tolerance,) [1], of the pair that scatters most.

    The numbers that the verb `tolerance` prints.  name : ``sobol_total``, with interactions; ``sobol_first``, alone.
    """
    one = result.sel(definition="mean-load")
    pair = scattering_pair(one)
    share: Array = np.nan_to_num(one[name].isel(pair=pair).transpose("tolerance").values)
    return np.clip(share, 0.0, None)


def _tolerance_answer(
    train: Train, names: Sequence[str], total: Array, alone: Array, order: NDArray[np.int64], change: dict[str, Any]
) -> Answer:
    first = int(order[0])
    share = float(total[first])
    text = (
        f"of the variance of K_gamma among trains of this drawing involves the tolerance of "
        f"{_entry_words(names[first], train)} with its interactions ({100 * float(alone[first]):.0f} % alone)"
    )
    if len(order) > 1 and total[order[1]] >= _AS_LARGE * share > 0:
        text += f"; {100 * float(total[order[1]]):.0f} % that of {_entry_words(names[int(order[1])], train)}"
    return answer(
        "error",
        f"{text}.",
        figure=f"{100 * share:.0f} %",
        level="warn" if share >= _HALF else "good",
        apply=change,
        apply_label="Halve this tolerance",
        evidence="tolerance",
        job="tolerance",
    )


def _entry_words(entry: str, train: Train) -> str:
    """``planet position`` of ``deviations.main.planet.position``."""
    path, _, part = entry.partition(" ")
    words = path.split(".")[1:]
    if len(train.planets) == 1:
        words = [word for word in words if word not in train.planets]
    text = " ".join(word for word in words if word != "meshes").replace("_", " ")
    return f"{text} ({part})" if part else text
