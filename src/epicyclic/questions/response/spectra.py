"""What excites a System, and the spectra and waveforms of what answers.

The exact lines of a System are sorted into mesh orders and shaft orders.  Mesh forces, link forces and displacements of
a solved block have spectra, and waveforms over the tone phases.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...statics.record import require_free_balance
from ...system.system import Array, ComplexArray, Faces, Index, Line, System, faces
from ..modes.eigen import Modal
from .lattice import (
    Lattice,
    LineFrequencies,
    Point,
    bundle,
    integer_frequencies,
    line_frequencies,
    on_axis,
    product,
    to_complex,
    truncated_product,
)

if TYPE_CHECKING:
    from .balance import HarmonicSolution
    from .response import Block, Response


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shaft:
    """Lines that the mesh orders couple: their frequencies are a . f + frequency, or a . f - frequency.

    frequency : of the lowest of them [Hz] at the operating speed.
    members : (lattice point a, whether the second form holds, so that the conjugate counts, line).
    """

    frequency: Fraction
    members: tuple[tuple[Point, bool, Line], ...]

    @property
    def causes(self) -> tuple[str, ...]:
        """Paths of the model file that contribute to any of the lines, once each."""
        return tuple(dict.fromkeys(cause for _, _, line in self.members for cause in line.causes))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LineExcitation:
    """Lines by kind.

    tones : (D,) mesh frequencies [Hz] at the operating speed, that of the first mesh first, then those of links that
        pass a body.
    axis : (m,) index of the tone of each mesh row.  passing : (r,) the same of these links.
    mesh : (lattice point, line) of each line at an integer multiple of a tone, 0 included.  shaft : the others,
        grouped.
    """

    tones: tuple[Fraction, ...]
    axis: NDArray[np.int64]
    passing: NDArray[np.int64]
    mesh: tuple[tuple[Point, Line], ...]
    shaft: tuple[Shaft, ...]

    @property
    def tone(self) -> Fraction:
        """Mesh frequency of the first mesh [Hz] at the operating speed."""
        return self.tones[0]

    def stages(self, system: System) -> list[str]:
        """Stage of each tone, that of its first mesh, or link that passes a body, (D,)."""
        axes = [*self.axis.tolist(), *self.passing.tolist()]
        return [system.varying.of[axes.index(axis)] for axis in range(len(self.tones))]

    @property
    def mesh_tones(self) -> tuple[Fraction, ...]:
        """Those of the tones that meshes follow [Hz]."""
        return self.tones[: int(self.axis.max()) + 1]

    def names(self, system: System) -> list[str]:
        """Name of each tone (D,): ``mesh``, ``main mesh`` of several, ``main/ring/support/bolts passing``."""
        stages, count = self.stages(system), len(self.mesh_tones)
        meshes = ["mesh"] if count == 1 else [f"{stage} mesh" for stage in stages[:count]]
        return meshes + [f"{link} passing" for link in stages[count:]]

    def solved_together(self, *, shifted: bool) -> list[list[PlacedLine]]:
        """Groups of lines that share a solution: one of all mesh orders, or (`shifted`) one a shaft frequency.

        The line a . f - frequency, conjugated, is at -a around +frequency.
        """
        if not shifted:
            return [[(point, False, line) for point, line in self.mesh]]
        return [
            [(tuple(-a for a in point) if minus else point, minus, line) for point, minus, line in shaft.members]
            for shaft in self.shaft
        ]

    @property
    def highest(self) -> tuple[int, ...]:
        """Highest order of each tone at which a line stands, (D,)."""
        points = [point for point, _ in self.mesh]
        points += [point for shaft in self.shaft for point, _, _ in shaft.members]
        return tuple(max((abs(point[j]) for point in points), default=0) for j in range(len(self.tones)))


def excitation(system: System, modal: Modal) -> LineExcitation:
    """Sort the lines of a System into mesh orders and shaft orders; refuse a System without a steady response.

    Raises
    ------
    ModelError : no damping, or all of it zero; no mesh frequency; torques that do not balance.
    """
    system.require_turning()
    require_damping(system)
    tones, passing = mesh_tones(system), system.passing
    first = len(tones)
    tones += () if passing is None else passing.tones
    points = [(_multiple(tones, line.frequency), line) for line in system.lines]
    mean = system.force + sum((line.force[0].real for line in system.lines if line.frequency == 0), np.zeros(1))
    free = modal.shapes[:, modal.rigid]
    require_free_balance(free, mean, system, path="operation.torque", cure="loads in equilibrium")
    return LineExcitation(
        tones=tones,
        axis=np.array([tones.index(system.tones[i]) for i in system.meshes.tone], dtype=np.int64),
        passing=np.zeros(0, np.int64) if passing is None else first + passing.tone,
        mesh=tuple((point, line) for point, line in points if point is not None),
        shaft=_grouped(tones, [line for point, line in points if point is None]),
    )


def require_damping(system: System) -> None:
    """Raise ModelError where nothing damps: no damping is given, or all of it is zero."""
    if not (system.zeta or np.any(system.C) or np.any(system.meshes.damping)):
        problem = "only zero damping is given" if system.damped else "no damping is given"
        raise ModelError(
            f"{problem}, so the response never settles",
            path="damping",
            allowed='e.g. damping = { modal = "3 %" }',
        )


def mesh_tones(system: System) -> tuple[Fraction, ...]:
    """Mesh frequencies that meshes follow [Hz] at the operating speed, that of the first mesh first.

    Raises
    ------
    ModelError : there is none, or one is zero.
    """
    system.require_turning()
    tones = tuple(dict.fromkeys(system.tones[i] for i in system.meshes.tone)) if system.tones else ()
    if not tones or min(tones) <= 0:
        turns = any(system.body_turns)
        reason = ": the members of each stage turn as one" if turns else ""
        allowed = "members that turn against each other" if turns else "the speed of one member"
        raise ModelError(
            f"the response needs a mesh frequency above zero{reason}", path="operation.speed", allowed=allowed
        )
    return tones


def _multiple(tones: tuple[Fraction, ...], frequency: Fraction) -> Point | None:
    """Lattice point of least order at a multiple of one tone [Hz], None where the frequency is no multiple."""
    orders = [(frequency / tone, j) for j, tone in enumerate(tones)]
    whole = [(abs(order), int(order), j) for order, j in orders if order.denominator == 1]
    if not whole:
        return None
    _, order, axis = min(whole)
    return tuple(order if j == axis else 0 for j in range(len(tones)))


def _grouped(tones: tuple[Fraction, ...], lines: list[Line]) -> tuple[Shaft, ...]:
    """Group shaft lines that differ by, or add to, a multiple of a tone: they share one solution and one phase."""
    groups: dict[Fraction, list[tuple[Point, bool, Line]]] = {}
    for line in sorted(lines, key=lambda line: line.frequency):
        for base, members in groups.items():
            less, more = _multiple(tones, line.frequency - base), _multiple(tones, line.frequency + base)
            if less is not None or more is not None:
                members.append((less, False, line) if less is not None else (more or (), True, line))
                break
        else:
            groups[line.frequency] = [((0,) * len(tones), False, line)]
    return tuple(Shaft(frequency=base, members=tuple(members)) for base, members in groups.items())


PlacedLine = tuple[Point, bool, Line]
"""A line at a lattice point, and whether its conjugate counts there."""


def placed(
    points: Index,
    groups: Sequence[Sequence[PlacedLine]],
    shape: tuple[int, ...],
    value: Callable[[Line], ComplexArray],
) -> ComplexArray:
    """Sums (S, J, ..) over the lines of S groups at each lattice point (J, D) of what `value` (..) gives of a line."""
    places = {tuple(point): i for i, point in enumerate(points.tolist())}
    result = np.zeros((len(groups), len(points), *shape), complex)
    for number, lines in enumerate(groups):
        for point, conjugate, line in lines:
            own = value(line)
            result[number, places[point]] += own.conj() if conjugate else own
    return result


def line_excitation(
    system: System, lines: LineExcitation, speed: Array, lattice: Lattice
) -> tuple[ComplexArray, ComplexArray]:
    """Errors (m, P S, J) [m] and forces (P S, J, n) [N, N m] at the points of a lattice, speeds outermost.

    Of a mirrored lattice those of the mesh orders, S = 1, constant loads included; else of every shaft group.
    speed : (P,) relative to the operating speed.
    """
    groups, n = lines.solved_together(shifted=not lattice.mirrored), system.force.size
    error = placed(lattice.points, groups, (len(system.meshes.name),), lambda line: line.gap)
    parts = placed(lattice.points, groups, (3, n), lambda line: line.force)
    if lattice.mirrored:
        parts[0, 0, 0] += system.force
        error[0, 0], parts[0, 0] = error[0, 0].real, parts[0, 0].real
    force = np.tensordot(speed_powers(speed), parts, axes=(1, 2)).reshape(-1, len(lattice.points), n)
    return np.tile(error.transpose(2, 0, 1), (1, speed.size, 1)), force


def speed_powers(speed: Array) -> Array:
    """1, s and s^2 of relative speeds (P,), (P, 3): factors of the three parts of the force of a `Line`."""
    return np.stack([np.ones_like(speed), speed, speed**2], axis=1)


Values = NDArray[Any]  # real or complex


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spectrum:
    """One-sided amplitudes: value = Re sum_s exp(i w_s t) sum_a amplitude[..., s, a] exp(2 pi i a . theta).

    amplitude : (rows, P, S, K) complex; S = 1 without a shaft frequency.
    points : (K, D) lattice points a.  mirrored : a real signal, one of a and -a.
    """

    amplitude: ComplexArray
    points: Index
    mirrored: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Signal:
    """Rows at all their frequencies, whichever method solved for them; `measures` takes its numbers from it.

    orders : at the points of the tones, S = 1.  lines : around the shaft frequencies, None without.
    line_frequencies : of all harmonics, those of `orders` first, at the operating speed.
    cross : combinations of several tones beyond that cross order are left out of values over the phases.
    """

    orders: Spectrum
    lines: Spectrum | None
    line_frequencies: LineFrequencies
    cross: int = 0

    @property
    def values(self) -> ComplexArray:
        """Amplitudes (rows, P, R) in the order of the line frequencies."""
        rows, P = self.orders.amplitude.shape[:2]
        parts = [self.orders] if self.lines is None else [self.orders, self.lines]
        return np.concatenate([part.amplitude.reshape(rows, P, -1) for part in parts], axis=2)


class Envelopes(NamedTuple):
    """All harmonics but the multiples of one tone, gathered modulo that tone.

    rests : (R, D) orders of the other tones.  shaft : (R,) index of the shaft line, -1 of mesh orders.
    values : (rows, P, R, Nt) complex over the phase of the tone.
    """

    rests: Index
    shaft: Index
    values: ComplexArray


def force_spectrum(ready: Response, block: Block, *, shifted: bool) -> Spectrum:
    """Mesh force k(t) (B^T q - e) + c d/dt(B^T q - e) of every mesh row [N], truncated harmonics included.

    Amplitude (m, P, S, J + T); shifted : of the shaft orders.
    """
    solved = _solution(block, shifted=shifted)
    made, meshes = ready.kernel(block.truncation, shifted=shifted), ready.system.meshes
    gap = solved.gap
    force = to_complex(product(made, gap) + meshes.stiffness[:, None, None] * gap)
    if meshes.damping.any():
        force += 1j * meshes.damping[:, None, None] * solved.frequency * to_complex(gap)
    truncated = truncated_product(made, gap) if solved.truncated_force is None else solved.truncated_force
    return Spectrum(
        amplitude=_per_speed(np.concatenate([force, to_complex(truncated)], axis=2), block),
        points=np.concatenate([made.lattice.points, made.truncated]),
        mirrored=not shifted,
    )


def motion_spectrum(ready: Response, block: Block, *, shifted: bool) -> Spectrum:
    """Coordinates [m, rad], amplitude (n, P, S, J); shifted : of the shaft orders."""
    return _row_spectrum(ready, block, rows=ready.modal.shapes, shifted=shifted)


def _row_spectrum(ready: Response, block: Block, *, rows: Array, shifted: bool) -> Spectrum:
    """What rows (r, modes) make of the modal coordinates, amplitude (r, P, S, J)."""
    y = _solution(block, shifted=shifted).y
    P, _, J, n = y.shape
    values = (rows @ y.reshape(-1, n).T).reshape(len(rows), P, 2 * J)
    points = ready.kernel(block.truncation, shifted=shifted).lattice.points
    return Spectrum(amplitude=_per_speed(to_complex(values), block), points=points, mirrored=not shifted)


def strained(ready: Response, rows: Array) -> Array:
    """Rows (n, r) that a rigid motion does not strain, on the modal coordinates, (r, modes).

    What is left of rigid modes is rounding, which 1/omega^2 of a slow shaft order would blow up.
    """
    modal: Array = rows.T @ ready.modal.shapes
    modal[:, ready.modal.rigid] = 0.0
    return modal


def link_spectrum(ready: Response, block: Block, *, shifted: bool) -> Spectrum:
    """Force of every link row [N, N m], amplitude (p, P, S, J); shifted : of the shaft orders."""
    links, solved = ready.system.links, _solution(block, shifted=shifted)
    stretch = _row_spectrum(ready, block, rows=strained(ready, links.B), shifted=shifted).amplitude
    skew_force: ComplexArray | float = 0.0
    if links.skew.size:
        skew_force = ready.frame_factor(block.speed)[:, None, None] * np.tensordot(links.skew, stretch, axes=1)
    lattice = ready.kernel(block.truncation, shifted=shifted).lattice
    groups = ready.lines.solved_together(shifted=shifted)
    error = placed(lattice.points, groups, (len(links.name),), lambda line: line.link_gap)
    if not shifted:
        error[0, 0] = error[0, 0].real
    stretch -= error.transpose(2, 0, 1)[:, None]
    force = links.stiffness[:, None, None, None] * stretch
    if links.damping.any():
        omega = solved.frequency.reshape(stretch.shape[1:])
        force += 1j * links.damping[:, None, None, None] * omega * stretch
    force += skew_force
    if links.preload.size and not shifted:
        force[:, :, 0, 0] += links.preload[:, None]
    return Spectrum(amplitude=force, points=lattice.points, mirrored=not shifted)


def _solution(block: Block, *, shifted: bool) -> HarmonicSolution:
    """Solution of the mesh orders, or of the shaft orders (`shifted`)."""
    solved = block.shaft if shifted else block.mesh
    assert solved is not None
    return solved


def _per_speed(values: ComplexArray, block: Block) -> ComplexArray:
    """Amplitudes (rows, P S, K) as (rows, P, S, K)."""
    rows, count, K = values.shape
    return values.reshape(rows, block.speed.size, count // block.speed.size, K)


def force_signal(ready: Response, block: Block) -> Signal:
    """Force of every mesh row [N] at all frequencies, truncated ones included."""
    return _signal(ready, block, force_spectrum, truncated=True)


def motion_signal(ready: Response, block: Block) -> Signal:
    """Every coordinate [m, rad] at the frequencies kept."""
    return _signal(ready, block, motion_spectrum)


def error_signal(ready: Response, block: Block) -> Signal:
    """Every transmission error [m, rad], (2 w + s) rows, at the frequencies kept."""
    return row_signal(ready, block, ready.system.error_rows, strains=True)


def row_signal(ready: Response, block: Block, rows: Array, *, strains: bool) -> Signal:
    """Rows (n, r) of the coordinates at the frequencies kept; strains : as of `strained`."""
    modal = strained(ready, rows) if strains else rows.T @ ready.modal.shapes
    return _signal(ready, block, partial(_row_spectrum, rows=modal))


def link_signal(ready: Response, block: Block) -> Signal:
    """Force k (B^T q - e) + c d/dt(B^T q - e) + preload of every link row [N, N m] at the frequencies kept.

    Dampers to the housing in a turning frame act on the absolute velocity (docs/conventions.md, inertia in a turning
    frame): their part s skew B^T q is included.
    """
    return _signal(ready, block, link_spectrum)


def _signal(ready: Response, block: Block, spectrum: Callable[..., Spectrum], *, truncated: bool = False) -> Signal:
    """Signal of the spectrum of mesh orders, and of shaft orders where they were solved."""
    shafts = block.shaft is not None
    return Signal(
        orders=spectrum(ready, block, shifted=False),
        lines=spectrum(ready, block, shifted=True) if shafts else None,
        line_frequencies=ready.line_frequencies(block.truncation, shafts=shafts, truncated=truncated),
        cross=block.truncation[-1],
    )


def signal_of_samples(waves: Array, tone: Fraction) -> Signal:
    """Signal of samples (rows, P, Nt) over one cycle of a tone, Nt odd; tone : [Hz at the operating speed]."""
    count = waves.shape[-1]
    amplitude = np.fft.rfft(waves)[:, :, None] * (2 / count)
    amplitude[..., 0] /= 2
    if count % 2 == 0:
        amplitude[..., -1] /= 2
    points = np.arange(amplitude.shape[-1])[:, None]
    steps = integer_frequencies(points, [tone], [Fraction(0)], tone.denominator)
    return Signal(
        orders=Spectrum(amplitude=amplitude, points=points, mirrored=True),
        lines=None,
        line_frequencies=line_frequencies(steps.ravel(), tone.denominator),
    )


def whole_mesh_signal(rows: Signal, face: Faces) -> Signal:
    """Forces of whole meshes, the sum of those of their slices."""
    if len(face.first) == len(face.row):
        return rows
    lines = None if rows.lines is None else replace(rows.lines, amplitude=face.total(rows.lines.amplitude))
    return replace(rows, orders=replace(rows.orders, amplitude=face.total(rows.orders.amplitude)), lines=lines)


def mesh_axis(ready: Response) -> Index:
    """Tone of each whole mesh, (w,)."""
    return ready.lines.axis[faces(ready.system.meshes).first]


def tone_waveform(spectrum: Spectrum, axis: int, theta: Array, *, mean: bool = True) -> Values:
    """The multiples of one tone over its phase theta (Nt,) [cycles]: (rows, P, S, Nt), real of a real signal.

    mean : whether order 0 is one of them.
    """
    own = on_axis(spectrum.points, axis)
    if not mean:
        own &= spectrum.points[:, axis] != 0
    amplitude = spectrum.amplitude if own.all() else spectrum.amplitude[..., own]
    return _wave(amplitude, spectrum.points[own, axis], theta, real=spectrum.mirrored)


def _wave(amplitude: ComplexArray, orders: Index, theta: Array, *, real: bool) -> Values:
    """sum_a amplitude_a exp(2 pi i a theta), its real part where `real`.

    amplitude : (..., K).  orders : (K,).  theta : (Nt,) [cycles].  Returns (..., Nt).
    """
    angle = 2 * np.pi * np.outer(orders, theta)
    if not real:
        return np.asarray(amplitude @ np.exp(1j * angle))
    turns = np.stack([np.cos(angle), -np.sin(angle)], axis=1).reshape(-1, theta.size)
    # real and imaginary parts side by side as they lie in memory: one product of many rows
    both = np.ascontiguousarray(amplitude).view(float).reshape(-1, len(turns))
    return np.asarray((both @ turns).reshape(*amplitude.shape[:-1], theta.size))


def torus_waveform(spectrum: Spectrum, counts: Sequence[int], cross: int) -> Values:
    """Values over a grid of all tone phases, (rows, P, S, N_1, .., N_D), real of a real signal.

    counts : N_1 .. N_D.  cross : combinations beyond that cross order, below the truncation allowed, are left out.
    """
    D = len(counts)
    phases = [np.arange(count) / count for count in counts]
    if D == 1:
        return tone_waveform(spectrum, 0, phases[0])
    combined = (np.count_nonzero(spectrum.points, axis=1) > 1) & (np.abs(spectrum.points).sum(axis=1) <= cross)
    points = spectrum.points[combined]
    low, high = points.min(axis=0, initial=0), points.max(axis=0, initial=0)
    box: Values = np.zeros((*spectrum.amplitude.shape[:3], *(high - low + 1)), complex)
    box[(..., *(points - low).T)] = spectrum.amplitude[..., combined]
    for axis in range(D - 1, -1, -1):  # a sum over one axis after another
        orders, last = np.arange(low[axis], high[axis] + 1), spectrum.mirrored and axis == 0
        box = np.moveaxis(_wave(np.moveaxis(box, 3 + axis, -1), orders, phases[axis], real=last), -1, 3 + axis)
        # the multiples of this tone stand where the orders of the tones still to be summed are 0
        alone = box[(slice(None),) * 3 + tuple(-low[:axis])]
        own = tone_waveform(spectrum, axis, phases[axis], mean=axis == 0)
        alone += own.reshape(*own.shape, *(1,) * (D - 1 - axis))
    return box


def envelopes(spectrum: Spectrum, axis: int, theta: Array) -> Envelopes:
    """All harmonics but the multiples of one tone, modulo that tone, over its phase theta (Nt,) [cycles]."""
    points, D = spectrum.points, spectrum.points.shape[1]
    lines = bundle(Lattice(points=points, mirrored=spectrum.mirrored, own=()), axis)
    half = lines.take.shape[1] // 2
    padded = np.concatenate([spectrum.amplitude, np.zeros((*spectrum.amplitude.shape[:3], 1))], axis=3)
    picked = padded[..., lines.take]
    picked.imag *= lines.mirror
    values = _wave(picked, np.arange(-half, half + 1), theta, real=False)
    rests = lines.rests
    if not spectrum.mirrored:
        values = np.concatenate([tone_waveform(spectrum, axis, theta)[:, :, :, None], values], axis=3)
        rests = np.concatenate([np.zeros((1, D), np.int64), rests])
    S, R = values.shape[2:4]
    return Envelopes(
        rests=np.tile(rests, (S, 1)),
        shaft=np.repeat(np.full(1, -1) if spectrum.mirrored else np.arange(S), R),
        values=values.reshape(*values.shape[:2], S * R, theta.size),
    )


def combinations(
    points: Index, names: Sequence[str], tones: Sequence[Fraction], speed: float
) -> tuple[NDArray[np.object_], Array]:
    """Names (J,) and frequencies (J,) [Hz] of lattice points (J, D): ``+1 sun mesh -2 ring mesh``, ``mean``.

    names, tones : of D phases or more.  speed : relative.
    """
    every = points.tolist()
    labels = [" ".join(f"{a:+d} {name}" for a, name in zip(p, names, strict=False) if a) or "mean" for p in every]
    exact = [sum((a * f for a, f in zip(p, tones, strict=False)), Fraction(0)) for p in every]
    return np.array(labels, dtype=object), speed * np.array([float(f) for f in exact])


def alias_free_samples(ready: Response, harmonics: int) -> int:
    """Samples of a mesh cycle that hold so many harmonics of the force and their square without aliasing."""
    return 2 * (harmonics + int(ready.system.varying.wave.shape[1])) + 1


def peak(values: Array) -> Array:
    """Largest value of a periodic signal (..., Nt) -> (...), with a parabola through the largest sample."""
    return _vertex(values, np.argmax(values, axis=-1))


def valley(values: Array) -> Array:
    """Smallest value of a periodic signal (..., Nt) -> (...), as `peak`."""
    return _vertex(values, np.argmin(values, axis=-1))


def _vertex(values: Array, sample: Index) -> Array:
    """Extremum of the parabola through the sample (...) of (..., Nt) and its neighbours, (...)."""
    count = values.shape[-1]
    flat, start = values.reshape(-1), np.arange(0, values.size, count).reshape(sample.shape)
    before, top, after = (flat[start + (sample + step) % count] for step in (-1, 0, 1))
    bend = 2 * top - before - after
    with np.errstate(all="ignore"):
        rise = np.where(bend != 0, (after - before) ** 2 / (8 * bend), 0.0)
    return np.asarray(top + rise)


def lateral_pairs(system: System) -> Index:
    """Link rows x and y, or radial and tangential, of every link that has both, (k, 2)."""
    links = system.links
    row = {name: i for i, name in enumerate(links.name)}
    pairs = [
        (row[f"{link}/{first}"], row[f"{link}/{second}"])
        for link in dict.fromkeys(links.link)
        for first, second in (("x", "y"), ("radial", "tangential"))
        if f"{link}/{first}" in row and f"{link}/{second}" in row
    ]
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def link_labels(system: System) -> dict[Hashable, list[str]]:
    """Names of the link rows and of bearings, links of two lateral rows, as results hold them; no empty ones."""
    links = system.links
    labels: dict[Hashable, list[str]] = {"link_row": list(links.name)}
    labels["bearing"] = [links.link[x] for x in lateral_pairs(system)[:, 0]]
    return {dim: names for dim, names in labels.items() if names}
