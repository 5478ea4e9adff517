"""Linear periodic response of a System at many speeds: chunks, harmonics raised until what is dropped is small."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..system.system import Array, System
from .basis import Modal, modal_form
from .excitation import Excitation, excitation, mesh_rows, shaft_rows
from .harmonic import Kernel, Rows, Solved, kernel, solve
from .linear import linearised

__all__ = ["Block", "FrameSpeed", "Response", "respond", "response"]

FrameSpeed = Literal["kinematic", "operating"]
Index = NDArray[np.int64]

# Doubles in one batch of modal rows: small enough to stay in the cache with the operator's copies of it.
_BATCH = 40_000
# Forces converge with the square of what is dropped in their RMS, and directly in their waveform.
_DROPPED = 100.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Response:
    """A System ready to be solved at any speed.  frame_speed : whether G, Kg follow the speed or stay."""

    system: System
    modal: Modal
    lines: Excitation
    frame_speed: FrameSpeed = "kinematic"
    kernels: dict[tuple[int, bool], Kernel] = field(default_factory=dict)

    @property
    def omega(self) -> float:
        """Angular mesh frequency at the operating speed [rad/s]."""
        return 2 * np.pi * float(self.lines.tone)

    def kernel(self, harmonics: int, *, shifted: bool) -> Kernel:
        """The convolution matrices for so many harmonics, made once."""
        key = (harmonics, shifted)
        if key not in self.kernels:
            self.kernels[key] = kernel(self.system, harmonics, shifted=shifted)
        return self.kernels[key]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Block:
    """Solved points.

    index : (P,) place of each point among the speeds asked for.  speed : (P,) relative.
    harmonics : kept in all of them.  mesh : mesh orders.
    shaft : shaft orders, points outermost, None without lines.  residual : (P,) whole relative residual.
    """

    index: Index
    speed: Array
    harmonics: int
    mesh: Solved
    shaft: Solved | None
    residual: Array


def response(system: System, *, frame_speed: FrameSpeed = "kinematic") -> Response:
    """Prepare a System for its periodic response; tangents at the mean load stand for the laws of links.

    Raises
    ------
    ModelError : no damping; no or several mesh frequencies; torques that do not balance.
    """
    if frame_speed not in ("kinematic", "operating"):
        raise ModelError("unknown choice", path="frame_speed", given=frame_speed, allowed="kinematic, operating")
    system = linearised(system)
    modal = modal_form(system)
    return Response(system=system, modal=modal, lines=excitation(system, modal), frame_speed=frame_speed)


def respond(ready: Response, speed: Array, *, tolerance: float, shaft_orders: bool = True) -> Iterator[Block]:
    """Solve every relative speed (P,), in blocks as they come out.

    The number of harmonics starts at the smallest that holds the excitation and grows until the forces on the
    harmonics dropped, an exact residual, are below 100 x tolerance of the dynamic part.
    """
    start = np.full(speed.size, max(8, ready.lines.highest))
    limit = 4 * np.maximum(start, _rule(ready, speed))
    waiting = list(_chunks(ready, np.arange(speed.size), start, shaft_orders=shaft_orders))
    while waiting:
        index, harmonics = waiting.pop(0)
        final = harmonics >= limit[index]
        with np.errstate(all="ignore"):  # a point that overflows ends as not finite, beside the others
            block = _block(ready, index, speed[index], harmonics=harmonics, tolerance=tolerance)
            block, poor = _sorted(block, final, tolerance)
            if shaft_orders and ready.lines.shaft and block.index.size:
                block = _with_shaft(ready, block, tolerance=tolerance)
                block, _ = _sorted(block, final[~poor], tolerance)
        again = np.setdiff1d(index, block.index)
        if block.index.size:
            yield block
        if again.size:
            more = np.minimum(limit[again], harmonics + max(4, harmonics // 2))
            waiting[:0] = _chunks(ready, again, more, shaft_orders=shaft_orders)


def _sorted(block: Block, final: NDArray[np.bool_], tolerance: float) -> tuple[Block, NDArray[np.bool_]]:
    """The points that dropped little (or may not keep more), and which of them did not."""
    poor = (_tails(block) > _DROPPED * tolerance) & ~final
    return (_select(block, ~poor) if poor.any() else block), poor


def _rule(ready: Response, speed: Array) -> Index:
    """Harmonics that reach beyond the highest mode, 1.7 f_highest / f."""
    highest = float(np.sqrt(ready.modal.squared.max(initial=0.0)))
    with np.errstate(all="ignore"):
        wanted = np.ceil(1.7 * highest / (ready.omega * np.abs(speed)))
    count: Index = np.nan_to_num(np.clip(wanted, 8, 400), nan=8.0).astype(np.int64)
    return count


def _chunks(ready: Response, index: Index, harmonics: Index, *, shaft_orders: bool) -> Iterator[tuple[Index, int]]:
    lines = len(ready.lines.shaft) if shaft_orders else 0
    for value in np.unique(harmonics):
        same = index[harmonics == value]
        rows = max(2 * (value + 1), 2 * (2 * value + 1) * lines)
        size = max(1, _BATCH // (rows * ready.modal.squared.size))
        yield from ((part, int(value)) for part in np.array_split(same, -(-same.size // size)))


def _block(ready: Response, index: Index, speed: Array, *, harmonics: int, tolerance: float) -> Block:
    mesh = _solve(ready, speed, harmonics=harmonics, tolerance=tolerance, shifted=False)
    residual = np.maximum(mesh.residual, mesh.dropped)
    return Block(index=index, speed=speed, harmonics=harmonics, mesh=mesh, shaft=None, residual=residual)


def _with_shaft(ready: Response, block: Block, *, tolerance: float) -> Block:
    shaft = _solve(ready, block.speed, harmonics=block.harmonics, tolerance=tolerance, shifted=True)
    worst = np.maximum(shaft.residual, shaft.dropped).reshape(block.speed.size, -1).max(axis=1)
    return replace(block, shaft=shaft, residual=np.maximum(block.residual, worst))


def _solve(ready: Response, speed: Array, *, harmonics: int, tolerance: float, shifted: bool) -> Solved:
    excite = shaft_rows if shifted else mesh_rows
    error, force = excite(ready.system, ready.lines, speed, harmonics=harmonics)
    count = len(ready.lines.shaft) if shifted else 1
    lines = 2 * np.pi * np.array([float(shaft.frequency) for shaft in ready.lines.shaft]) if shifted else np.zeros(1)
    frame = speed if ready.frame_speed == "kinematic" else np.ones_like(speed)
    rows = Rows(
        omega=np.repeat(ready.omega * speed, count),
        shift=np.outer(speed, lines).ravel(),
        frame=np.repeat(frame, count),
        error=error,
        force=force,
    )
    return solve(ready.system, ready.modal, ready.kernel(harmonics, shifted=shifted), rows, tolerance=tolerance)


def _tails(block: Block) -> Array:
    """What the worst of a point's solutions dropped, (P,)."""
    if block.shaft is None:
        return block.mesh.dropped
    worst: Array = np.maximum(block.mesh.dropped, block.shaft.dropped.reshape(block.speed.size, -1).max(axis=1))
    return worst


def _select(block: Block, keep: NDArray[np.bool_]) -> Block:
    def pick(solved: Solved) -> Solved:
        mine = np.repeat(keep, solved.residual.size // keep.size)
        return Solved(
            y=solved.y[mine],
            gap=solved.gap[:, mine],
            frequency=solved.frequency[mine],
            residual=solved.residual[mine],
            dropped=solved.dropped[mine],
            calls=solved.calls,
        )

    return Block(
        index=block.index[keep],
        speed=block.speed[keep],
        harmonics=block.harmonics,
        mesh=pick(block.mesh),
        shaft=None if block.shaft is None else pick(block.shaft),
        residual=block.residual[keep],
    )
