"""Steady response over a range of speeds, linear contact, shaft orders included."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...engine.workers import each, import_results
from ...errors import ModelError
from ...system.system import Array, System, faces
from .mean_stability import MEAN_UNSTABLE, instability_warnings, unstable_speeds
from .measures import Layout, Signals, force_extremes, order_harmonics, sweep_measures
from .response import Block, FrameSpeed, Response, Truncation, respond_part, response, response_parts
from .speed_range import SpeedRange, speeds_of
from .steady import factor_warnings, tension_warnings
from .table import SweepTable, empty_table, sweep_dataset
from .waveform import force_signal, link_signal, motion_signal, whole_mesh_signal

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.run_folder import RunFolder

__all__ = ["sweep"]

_ORDERS = 100
_ACCEPTED = 100.0


def sweep(
    system: System,
    *,
    mesh_frequency: ArrayLike | None = None,
    relative_speed: ArrayLike | None = None,
    speed_range: SpeedRange | None = None,
    points: int | None = None,
    frame_speed: FrameSpeed = "kinematic",
    shaft_orders: bool = True,
    orders: int = 12,
    forces_alone: bool = False,
    tolerance: float = 1e-6,
    progress: Callable[[int, int], None] | None = None,
    compiled: bool | None = None,
    kept: RunFolder | None = None,
) -> xr.Dataset:
    """Mesh forces, bearing forces and motion over speed for linear contact, as docs/theory/response.md defines.

    With shaft orders the RMS is that of all time (Parseval), and the peak and the minimum are bounds over all
    relative phases, max over theta of f0 + sum |A_s|: teeth meet at discrete phases, so a bound may lie up to
    1 - cos(pi/z) of a line above what is reached, and with common tooth factors further.  Amplitudes likewise.
    Several mesh frequencies take all combinations of their phases too; the amplitude then adds the range of each.

    Parameters
    ----------
    mesh_frequency : (P,) of the first mesh [Hz], or relative_speed : (P,) speeds per operating speed.
    speed_range : where neither is given: ``operation`` (None), 5 to 130 % of the operating speed with the speeds at
        which mesh orders meet the modes; ``modes``, from a fifth of the lowest natural or operating frequency to 1.2
        times the highest.  points : speeds of the range, None as of `speeds_of`.
    frame_speed : whether the frame of the coordinates turns faster with the sweep (``kinematic``), as the train does,
        or gyroscopic and centripetal terms stay those of the operating speed (``operating``).
    shaft_orders : whether run-outs and other lines between the mesh orders count.
    orders : highest mesh order whose amplitude is reported, 1 to 100; shaft lines are reported around so many mesh
        orders, and combinations of mesh frequencies up to so many, at most 32 of each.
    forces_alone : only mesh forces are measured, and the motion at the mesh orders, ``displacement_harmonic`` [m],
        complex; other motion and link forces are nan.
    tolerance : relative residual of the harmonics kept [1]; the truncation is below 30 times that.
    progress : called with (points done, points) after every chunk; an exception in it ends the sweep.
    compiled : solve by numba; None leaves that to the size of the job, see `response`.
    kept : keeps the speeds that are done.

    Raises
    ------
    ModelError : no damping, no mesh frequency, torques out of balance, or an option out of range.
    A single speed that fails holds nan, and ``status`` says why.
    """
    if not 1 <= orders <= _ORDERS:
        raise ModelError("out of range", path="orders", given=orders, allowed=f"1 to {_ORDERS}")
    ready = response(system, frame_speed=frame_speed, compiled=compiled)
    speed = speeds_of(
        ready, mesh_frequency=mesh_frequency, relative_speed=relative_speed, speed_range=speed_range, points=points
    )
    ranged = mesh_frequency is None and relative_speed is None
    options: dict[str, Any] = {
        "frame_speed": frame_speed,
        "shaft_orders": shaft_orders,
        "orders": orders,
        "tolerance": tolerance,
    }
    options |= {"speed_range": speed_range or "operation"} if ranged else {}
    table = empty_table(
        ready.system, ready.lines, speed.size, orders=orders, shafts=shaft_orders, harmonics=forces_alone
    )
    cross = np.zeros(speed.size, dtype=np.int64)
    usable = np.isfinite(speed) & (speed > 0)
    table.status[~usable] = "speed is not a number above zero"
    unstable = np.zeros(speed.size, dtype=bool)
    unstable[usable] = unstable_speeds(ready, speed[usable])
    table.status[unstable] = MEAN_UNSTABLE
    usable &= ~unstable
    places, done = np.flatnonzero(usable), int((~usable).sum())

    def fill(_: int, solved: list[_Measured]) -> None:
        """Write the blocks of one part into the table."""
        nonlocal done
        for block in solved:
            block.fill(table, places[block.index])
            cross[places[block.index]] = block.truncation[-1]
            done += block.index.size
            if progress is not None:
                progress(done, speed.size)

    ready, parts = response_parts(ready, speed[usable], shaft_orders=shaft_orders)
    work = partial(
        _measured,
        ready,
        speed[usable],
        table.layout,
        tolerance=tolerance,
        shaft_orders=shaft_orders,
        forces_alone=forces_alone,
    )
    each(work, parts, arrived=fill, kept=None if kept is None else kept.part("speeds"), meanwhile=import_results)
    return sweep_dataset(
        table,
        ready.system,
        speed=speed,
        tone=float(ready.lines.tone),
        verb="sweep",
        options=options,
        warnings=[
            *ready.system.warnings,
            *instability_warnings(ready, speed[unstable]),
            *tension_warnings(system, table.minimum_force, table.values["dynamic_factor"]),
            *factor_warnings(system, table.values["dynamic_factor"]),
        ],
        further={"cross_order": ("speed", cross)} if len(ready.lines.tones) > 1 else None,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Measured:
    """Measures of one block of speeds.

    found : by name, speeds last, not finite where nothing was found.  minimum : smallest force of every mesh row (m, P)
        [N].  good : (P,) whether the residual is small enough; the other fields as of `Block`.
    """

    index: NDArray[np.int64]
    truncation: Truncation
    harmonics: int
    found: dict[str, NDArray[Any]]
    minimum: Array
    residual: Array
    good: NDArray[np.bool_]
    status: list[str]

    def fill(self, table: SweepTable, place: NDArray[np.int64]) -> None:
        """Write the measures at the speeds `place` (P,), nan where they did not converge."""
        table.store(place, self.found, self.good)
        table.minimum_force[:, place] = np.where(self.good, self.minimum, np.nan)
        table.values["residual"][place], table.harmonics[place] = self.residual, self.harmonics
        table.status[place] = self.status


def _measured(
    ready: Response,
    speed: Array,
    layout: Layout,
    part: tuple[NDArray[np.int64], Truncation],
    *,
    tolerance: float,
    shaft_orders: bool,
    forces_alone: bool,
) -> list[_Measured]:
    """Measures of one part of the speeds (P,), block by block."""
    blocks = respond_part(ready, speed, part, tolerance=tolerance, shaft_orders=shaft_orders)
    accepted = _ACCEPTED * tolerance
    return [_block_measures(ready, block, layout, accepted=accepted, forces_alone=forces_alone) for block in blocks]


def _block_measures(ready: Response, block: Block, layout: Layout, *, accepted: float, forces_alone: bool) -> _Measured:
    """Measures of one block; accepted : largest relative residual.  forces_alone : of the mesh forces only."""
    face = faces(ready.system.meshes)
    rows = force_signal(ready, block)
    signals = Signals(
        speed=block.speed,
        force=whole_mesh_signal(rows, face),
        motion=None if forces_alone else motion_signal(ready, block),
        links=link_signal(ready, block) if ready.system.links.name and not forces_alone else None,
    )
    with np.errstate(all="ignore"):  # a point that overflows is not finite, beside the others
        found: dict[str, NDArray[Any]] = {**sweep_measures(signals, layout)}
        if forces_alone:
            motion, first = motion_signal(ready, block), np.zeros(len(layout.radius), dtype=np.int64)
            found["displacement_harmonic"] = layout.radius[:, None, None] * order_harmonics(
                motion, first, layout.orders
            )
    status = [_status(*values, accepted) for values in zip(block.residual, block.uncertainty, strict=True)]
    minimum = force_extremes(rows, axis=ready.lines.axis)[0] if face.cut.any() else found["mesh_force_minimum"]
    return _Measured(
        index=block.index,
        truncation=block.truncation,
        harmonics=block.harmonics,
        found=found,
        minimum=minimum,
        residual=block.residual,
        good=np.array([text == "ok" for text in status]),
        status=status,
    )


def _status(residual: float, uncertainty: float, accepted: float) -> str:
    """Status of a speed from its relative residual and what a sharp resonance leaves uncertain."""
    if not np.isfinite(residual):
        return "not finite"
    if residual > accepted:
        return "not converged"
    return "ok" if uncertainty <= accepted else "resonance too sharp for double precision"
