"""The periodic response over a range of speeds, linear contact, shaft orders included."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import ModelError
from ...system.faces import faces
from ...system.system import Array, System
from .extremes import force_extremes, strokes
from .response import Block, FrameSpeed, Response, respond, response
from .steady import tension
from .waveform import force_spectrum, mean_square, mesh_axis, motion_spectrum, whole

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["sweep"]

_POINTS = 200
_ACCEPTED = 100.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Curves:
    """What a sweep fills in: of whole meshes (w, P) [N], lowest of every row (m, P), (n, P) [m], (P,)."""

    rms: Array
    peak: Array
    minimum: Array
    lowest: Array
    amplitude: Array
    residual: Array
    harmonics: NDArray[np.int64]
    cross: NDArray[np.int64]
    status: NDArray[np.object_]


def sweep(
    system: System,
    *,
    mesh_frequency: ArrayLike | None = None,
    relative_speed: ArrayLike | None = None,
    frame_speed: FrameSpeed = "kinematic",
    shaft_orders: bool = True,
    tolerance: float = 1e-6,
    progress: Callable[[int, int], None] | None = None,
    compiled: bool | None = None,
) -> xr.Dataset:
    """RMS, peak and minimum of every mesh force and amplitude of every coordinate over speed, for linear contact.

    With shaft orders the RMS is that of all time (Parseval), and the peak and the minimum are bounds over all
    relative phases, max over theta of f0 + sum |A_s|: teeth meet at discrete phases, so a bound may lie up to
    1 - cos(pi/z) of a line above what is reached, and with common tooth factors further.  Amplitudes likewise.
    Several mesh frequencies take all combinations of their phases too; the amplitude then adds the way of each.

    Parameters
    ----------
    mesh_frequency : (P,) of the first mesh [Hz], or relative_speed : (P,) speeds per operating speed; neither: 200
        mesh frequencies from a fifth of the lowest natural or operating frequency to 1.2 times the highest.
    frame_speed : whether the frame of the coordinates turns faster with the sweep (``kinematic``), as the train does,
        or gyroscopic and centripetal terms stay those of the operating speed (``operating``).
    shaft_orders : whether run-outs and other lines between the mesh orders count.
    tolerance : relative residual of the harmonics kept [1]; those dropped are below 30 times that.
    progress : called with (points done, points) after every chunk; an exception in it ends the sweep.
    compiled : solve by numba; None leaves that to the size of the job, see `response`.

    Raises
    ------
    ModelError : no damping, no mesh frequency, torques out of balance, or an option out of range.
    A single speed that fails holds nan, and ``status`` says why.
    """
    ready = response(system, frame_speed=frame_speed, compiled=compiled)
    speed = _speeds(ready, mesh_frequency, relative_speed)
    curves = _blank(system, speed.size)
    usable = np.isfinite(speed) & (speed > 0)
    curves.status[~usable] = "speed is not a number above zero"
    places, done = np.flatnonzero(usable), int((~usable).sum())
    for block in respond(ready, speed[usable], tolerance=tolerance, shaft_orders=shaft_orders):
        _fill(ready, block, places[block.index], curves, accepted=_ACCEPTED * tolerance)
        done += block.index.size
        if progress is not None:
            progress(done, speed.size)
    options = {"frame_speed": frame_speed, "shaft_orders": shaft_orders, "tolerance": tolerance}
    return _labelled(ready, speed, curves, options)


def _speeds(ready: Response, mesh_frequency: ArrayLike | None, relative_speed: ArrayLike | None) -> Array:
    if mesh_frequency is not None and relative_speed is not None:
        raise ModelError("give mesh_frequency or relative_speed, not both")
    tone = float(ready.lines.tone)
    if relative_speed is not None:
        return np.atleast_1d(np.asarray(relative_speed, dtype=float))
    if mesh_frequency is not None:
        return np.atleast_1d(np.asarray(mesh_frequency, dtype=float)) / tone
    natural = np.sqrt(ready.modal.squared[ready.modal.squared > 0]) / (2 * np.pi)
    if not natural.size:
        return np.array([1.0])
    return np.linspace(0.2 * min(tone, natural[0]), 1.2 * max(tone, natural[-1]), _POINTS) / tone


def _blank(system: System, count: int) -> _Curves:
    m, n = len(faces(system.meshes).name), system.force.size
    return _Curves(
        rms=np.full((m, count), np.nan),
        peak=np.full((m, count), np.nan),
        minimum=np.full((m, count), np.nan),
        lowest=np.full((len(system.meshes.name), count), np.nan),
        amplitude=np.full((n, count), np.nan),
        residual=np.full(count, np.nan),
        harmonics=np.zeros(count, dtype=np.int64),
        cross=np.zeros(count, dtype=np.int64),
        status=np.full(count, "", dtype=object),
    )


def _fill(ready: Response, block: Block, place: NDArray[np.int64], curves: _Curves, *, accepted: float) -> None:
    """Write the curves of one block, nan where it found no answer."""
    face = faces(ready.system.meshes)
    rows, motion = (find(ready, block, shifted=False) for find in (force_spectrum, motion_spectrum))
    line_rows, moving = None, None
    if block.shaft is not None:
        line_rows, moving = (find(ready, block, shifted=True) for find in (force_spectrum, motion_spectrum))
    force, lines = whole(rows, face), None if line_rows is None else whole(line_rows, face)
    low, high = force_extremes(ready, block, force, lines, axis=mesh_axis(ready))
    lowest = force_extremes(ready, block, rows, line_rows, axis=ready.lines.axis)[0] if face.cut.any() else low
    square = mean_square(ready, block, [force] if lines is None else [force, lines])
    good = block.residual <= accepted
    curves.residual[place], curves.harmonics[place] = block.residual, block.harmonics
    curves.cross[place] = block.kept[-1]
    curves.status[place] = [_status(value, accepted) for value in block.residual]
    for target, values in (
        (curves.rms, np.sqrt(square)),
        (curves.peak, high),
        (curves.minimum, low),
        (curves.lowest, lowest),
        (curves.amplitude, ready.system.dofs.radius[:, None] * strokes(ready, block, motion, moving)),
    ):
        target[:, place] = np.where(good, values, np.nan)


def _status(residual: float, accepted: float) -> str:
    if not np.isfinite(residual):
        return "not finite"
    return "ok" if residual <= accepted else "not converged"


def _labelled(ready: Response, speed: Array, curves: _Curves, options: dict[str, Any]) -> xr.Dataset:
    from ...results import dataset

    system = ready.system
    several = {"cross_order": ("speed", curves.cross)} if len(ready.lines.tones) > 1 else {}
    return dataset(
        {
            **several,
            "mesh_force_rms": (("mesh", "speed"), curves.rms),
            "mesh_force_peak": (("mesh", "speed"), curves.peak),
            "mesh_force_minimum": (("mesh", "speed"), curves.minimum),
            "amplitude": (("dof", "speed"), curves.amplitude),
            "status": ("speed", curves.status),
            "harmonics": ("speed", curves.harmonics),
            "residual": ("speed", curves.residual),
        },
        {
            "mesh": list(faces(system.meshes).name),
            "dof": list(system.dofs.names),
            "speed": speed,
            "mesh_frequency": ("speed", speed * float(ready.lines.tone)),
        },
        verb="sweep",
        options=options,
        provenance=system.provenance,
        warnings=[*system.warnings, *tension(system, curves.lowest)],
        units={"speed": "1"},  # relative to the operating speed, not the rpm of `check`
    )
