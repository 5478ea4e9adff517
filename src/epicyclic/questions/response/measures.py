"""Measures of a response at many speeds: pure functions of signals, whichever method solved for them.

A linear sweep, one with contact loss, or samples of an integration give `Signal`s (complex amplitudes and exact
frequencies; `spectra.signal_of_samples` makes one of samples); `sweep_measures` makes the variables of `table` of them.

With F(t) the force of a mesh and F_m its mean over time, the transmitted force,

    K_v = max F / F_m        RMS^2 = mean of (F - F_m)^2 = sum |A_f|^2 / 2        peak to peak = max F - min F

K_v is (F_m + dynamic increment) / F_m as in [iso6336, 6], for each mesh of a train; where the meshes of a pair carry
nothing together it is not defined.

Of one speed also the forces over the cycle of a mesh frequency: mesh orders, and an envelope for each other line.

For comparison plain harmonic superposition: every frequency alone on the mean system.  With dbar the mean gap,
K xbar = F, and dk the varying part of a mesh stiffness,

    Z(w) X = sum of (k0 + i w c) e B - dk dbar B,    force = k0 (dbar + dX) + dk dbar + c dX'

that is, products of varying stiffness and varying gap are left out.  This is the mean system with the errors
e - dbar dk / (k0 + i w c), so that one solver serves both (derived here).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from ...errors import ConvergenceError, ModelError
from ...statics.record import MeshGroup, least_load, link_factor, loaded_meshes, samples_per_cycle
from ...system.system import Array, ComplexArray, ErrorRows, Index, Line, System, faces
from .lattice import LineFrequencies, on_axis
from .response import Block, Response, require_stable_mean, respond, response
from .spectra import (
    Signal,
    Spectrum,
    alias_free_samples,
    envelopes,
    force_signal,
    force_spectrum,
    mesh_axis,
    motion_spectrum,
    peak,
    tone_waveform,
    torus_waveform,
    valley,
    whole_mesh_signal,
)

# Phases of each tone on the grid: least, by the number of tones.
_GRID = {1: 128, 2: 48, 3: 32}
# Directions, over half a turn, from which the largest length of a pair of rows is looked for, and steps from the best
# one: lengths of up to five random lines then lie within 3e-4 of those of 2000 directions (2e-3 from 18 directions).
_TOWARDS = np.array([[np.cos(angle), np.sin(angle)] for angle in np.arange(24) * (np.pi / 24)])
_TURNS = 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Layout:
    """Meaning of the rows of the signals.

    axis : (w,) the tone of each whole mesh.  radius : (n,) of the coordinates [m].
    translation : (nb, 3, n) displacement of the centre of every body per coordinate.
    pairs : (k, 2) link rows that are the two lateral directions of one link.  turn : (p,) of `LinkRows`.
    orders : highest mesh order reported.  frequencies : of the other lines reported, exact [Hz at the operating speed].
    groups : whole meshes of one pair and side.  rounding : a mesh force that is none [N].
    errors : whose transmission errors are reported.
    """

    axis: Index
    radius: Array
    translation: Array
    pairs: Index
    turn: Sequence[Fraction]
    orders: int
    frequencies: tuple[Fraction, ...]
    groups: Sequence[MeshGroup]
    rounding: float
    errors: ErrorRows


class Range(NamedTuple):
    """Extremes of the rows of a signal.

    low, high : smallest and largest value of every row (rows, P).  length : largest length of pairs of rows (pairs, P).
    """

    low: Array
    high: Array
    length: Array


def sweep_measures(
    layout: Layout,
    *,
    speed: Array,
    force: Signal,
    motion: Signal | None = None,
    links: Signal | None = None,
    errors: Signal | None = None,
) -> dict[str, Array]:
    """All measures by name: rows first, then orders or lines where there are, speeds last.

    Of a response at relative speeds (P,): forces of whole meshes [N], motion [m, rad], forces of links [N, N m], and
    transmission errors in the order of `ErrorRows` [m, rad]; what is None is not reported.

    Forces (rows, P) [N, N m], K_v [1] [iso6336, 6]; `mesh_force_order` (w, orders, P), `mesh_force_line` (w, L, P) [N];
    `amplitude` half the range of every coordinate [m]; accelerations [m/s2, rad/s2], of body centres (nb, P).
    """
    low, high = force_extremes(force, axis=layout.axis)
    average = mean(force)
    measures = {
        "mesh_force_mean": average,
        "mesh_force_rms": np.sqrt(mean_square(force)),
        "mesh_force_peak": high,
        "mesh_force_minimum": low,
        "mesh_force_peak_to_peak": high - low,
        "dynamic_factor": dynamic_factor(high, average, layout.groups, layout.rounding),
        "mesh_force_order": np.abs(order_harmonics(force, layout.axis, layout.orders)),
        "mesh_force_line": np.abs(line_harmonics(force, layout.frequencies)),
    }
    if motion is not None:
        span, square = ranges(motion), speed**2
        # accelerations are those in the frame of the coordinates
        measures |= {
            "amplitude": layout.radius[:, None] * (span.high - span.low) / 2,
            "acceleration_rms": square * np.sqrt(mean_square(motion, derivative=2)),
            "body_acceleration_rms": square * np.sqrt(_translation_square(motion, layout.translation)),
        }
    if links is not None:
        measures |= link_measures(links, layout.pairs, layout.turn)
    if errors is not None:
        measures |= _error_measures(errors, layout)
    return measures


def _error_measures(errors: Signal, layout: Layout) -> dict[str, Array]:
    """Range over all phases, RMS and mesh orders of the transmission errors, of shafts those of the first mesh."""
    span, axis = ranges(errors), np.zeros(len(errors.orders.amplitude), np.int64)
    axis[: 2 * layout.axis.size] = np.tile(layout.axis, 2)
    values = {
        "peak_to_peak": span.high - span.low,
        "rms": np.sqrt(mean_square(errors)),
        "order": np.abs(order_harmonics(errors, axis, layout.orders)),
    }
    return {
        f"transmission_error_{kind}_{name}": rows
        for name, measure in values.items()
        for kind, (_, rows) in layout.errors.by_kind(measure).items()
    }


def link_measures(links: Signal, pairs: Index, turn: Sequence[Fraction]) -> dict[str, Array]:
    """Measures of the link rows, (p, P), and of the lateral force of the links `pairs` (k, 2), (k, P) [N, N m].

    turn : (p,) of `LinkRows`.  The lateral force on a housing is constant where it stands still in the housing.
    """
    held = held_pairs(pairs, turn)
    standing = _standing_forces(links, pairs[held], [turn[row] for row in pairs[held, 0]])
    return link_statistics(ranges(links, pairs), mean(links), mean_square(links), pairs, held, standing)


def held_pairs(pairs: Index, turn: Sequence[Fraction]) -> list[int]:
    """Which pairs of link rows (k, 2) hold a turning frame in the housing; turn : (p,) of `LinkRows`."""
    return [pair for pair, row in enumerate(pairs[:, 0]) if turn and turn[row]]


def record_link_measures(force: Array, pairs: Index, turn: Sequence[Fraction]) -> dict[str, Array]:
    """The same of forces (p, T) over time; none of a lateral force is known to stand still in the housing."""
    length = np.hypot(*force[pairs.T]).max(axis=1, initial=0.0)
    span, held = Range(force.min(axis=1), force.max(axis=1), length), held_pairs(pairs, turn)
    return link_statistics(span, force.mean(axis=1), force.var(axis=1), pairs, held, np.zeros(len(held)))


def link_statistics(
    span: Range, average: Array, square: Array, pairs: Index, held: Sequence[int], standing: Array
) -> dict[str, Array]:
    """The measures of extremes, means (p, ..) and mean squares (p, ..) of the link rows.

    standing : (h, ..) length of the force of the pairs `held` that stands still in the housing [N].
    """
    x, y = pairs.T
    constant, varying = np.hypot(average[x], average[y]), square[x] + square[y]
    varying[held] = np.maximum(varying[held] + constant[held] ** 2 - standing**2, 0.0)
    constant[held] = standing
    most = np.maximum(span.high, -span.low)
    return {
        "link_force_factor": link_factor(most, average),
        "link_force_mean": average,
        "link_force_rms": np.sqrt(square),
        "link_force_peak": most,
        "link_force_peak_to_peak": span.high - span.low,
        "bearing_force_mean": constant,
        "bearing_force_rms": np.sqrt(varying),
        "bearing_force_peak": span.length,
    }


def _standing_forces(links: Signal, pairs: Index, turn: Sequence[Fraction]) -> Array:
    """Length (k, P) [N] of the part of lateral forces in turning frames that stands still in the housing.

    It is the part that turns against the frame: of F = Re((a_x, a_y) exp(i w t)), w the speed of the frame, that of
    size abs(a_x - i a_y) / 2; with + for a frame that turns backwards.

    pairs : (k, 2) link rows.  turn : (k,) of their frames, exact, not 0 [rev/s at the operating speed].
    """
    standing = np.zeros((len(pairs), links.values.shape[1]))
    for speed in set(turn):
        alike = [pair for pair, other in enumerate(turn) if other == speed]
        x, y = line_harmonics(links, [abs(speed)])[pairs[alike].T, 0]
        standing[alike] = np.abs(x - 1j * y if speed > 0 else x + 1j * y) / 2
    return standing


def dynamic_factor(largest: Array, transmitted: Array, groups: Sequence[MeshGroup], rounding: float) -> Array:
    """K_v = largest / mean force of a mesh [1] [iso6336, 6]; nan where it carries none, or pulls in the mean.

    Parameters
    ----------
    largest, transmitted : (m, P) [N].  groups : meshes of one pair and side.  rounding : a force that is none [N].
    """
    carried = loaded_meshes(transmitted, groups, most=largest, rounding=rounding)
    # of a loaded pair one branch may still carry nothing
    carried &= transmitted > least_load(transmitted, most=largest, rounding=rounding)
    return np.where(carried, largest, np.nan) / np.where(carried, transmitted, 1.0)


def mean(signal: Signal) -> Array:
    """Mean over all time, (rows, P), in the unit of the signal."""
    return np.asarray(signal.values[..., signal.line_frequencies.constant].real.sum(axis=-1))


def mean_square(signal: Signal, *, derivative: int = 0) -> Array:
    """Mean square over all time without the mean, by Parseval's theorem, (rows, P).

    Amplitudes of exactly equal frequency are one line.
    derivative : order of the time derivative, at relative speed 1; at speed s times s^(2 derivative).
    """
    lines = signal.line_frequencies
    omega = _line_omega(lines)
    weight = np.where(omega > 0, omega ** (2 * derivative), 0.0)
    return lines.power(signal.values, weight) / 2


def _line_omega(lines: LineFrequencies) -> Array:
    """|omega| of each distinct line, (F,) [rad/s]."""
    return np.abs(lines.omega)[lines.first]


def _translation_square(motion: Signal, translation: Array) -> Array:
    """Mean square of the acceleration of every body's centre, (nb, P) [m^2/s^4], at relative speed 1.

    translation : (nb, 3, n) of `Layout`.
    """
    values = motion.values
    nb, _, n = translation.shape
    used = np.flatnonzero(translation.any(axis=2))
    moved = (translation.reshape(-1, n)[used] @ values.reshape(n, -1)).reshape(used.size, *values.shape[1:])
    square = np.zeros((3 * nb, values.shape[1]))
    square[used] = motion.line_frequencies.power(moved, _line_omega(motion.line_frequencies) ** 4) / 2
    return np.asarray(square.reshape(nb, 3, -1).sum(axis=1))


def order_harmonics(signal: Signal, axis: Index, orders: int) -> ComplexArray:
    """One-sided harmonics of every row at multiples 1 .. orders of a tone, (rows, orders, P); 0 beyond those kept.

    axis : (rows,) the tone of each row.
    """
    points, amplitude = signal.orders.points, signal.orders.amplitude[:, :, 0]
    harmonics = np.zeros((amplitude.shape[0], orders, amplitude.shape[1]), complex)
    for tone in range(points.shape[1]):
        rows = np.flatnonzero(axis == tone)
        kept = np.flatnonzero(on_axis(points, tone) & (points[:, tone] > 0) & (points[:, tone] <= orders))
        harmonics[np.ix_(rows, points[kept, tone] - 1)] = amplitude[rows][..., kept].transpose(0, 2, 1)
    return harmonics


def line_harmonics(signal: Signal, frequencies: Sequence[Fraction]) -> ComplexArray:
    """One-sided amplitude at exact frequencies [Hz at the operating speed], (rows, L, P), harmonics of one added."""
    line_frequencies, amplitude = signal.line_frequencies, signal.values
    reported = line_frequencies.index_of(frequencies)
    wanted = np.full(line_frequencies.distinct.size + 1, -1)
    wanted[reported] = np.arange(len(reported))
    wanted[-1] = -1
    rows = np.flatnonzero(wanted[line_frequencies.line] >= 0)
    values = np.where(line_frequencies.negative[rows], amplitude[..., rows].conj(), amplitude[..., rows])
    harmonics = np.zeros((len(reported), *amplitude.shape[:2]), complex)
    np.add.at(harmonics, wanted[line_frequencies.line[rows]], np.moveaxis(values, -1, 0))
    return harmonics.transpose(1, 0, 2)


def force_extremes(force: Signal, *, axis: Index) -> tuple[Array, Array]:
    """Smallest and largest mesh force (m, P) [N] over the torus of the tone phases, all shaft lines at their worst.

    max over theta_1 .. theta_D of f + sum |A_s|: reached if the tones and lines take all combinations of phases.
    axis : (m,) the tone of each force.
    """
    value, lines = _phase_waveforms(force)
    if lines is None and value.ndim == 3:
        return valley(value), peak(value)
    reach = 0.0 if lines is None else np.abs(lines).sum(axis=2)
    return -_torus_maximum(axis, reach - value), _torus_maximum(axis, reach + value)


def _torus_maximum(tone: Index, values: Array) -> Array:
    """Largest value over the torus, (m, P, N_1, .., N_D) -> (m, P), refined along the tone of each mesh (m,)."""
    if values.ndim == 3:
        return peak(values)
    result = np.empty(values.shape[:2])
    for axis in range(values.ndim - 2):
        rows = tone == axis
        others = tuple(2 + other for other in range(values.ndim - 2) if other != axis)
        result[rows] = peak(values[rows].max(axis=others))
    return result


def ranges(signal: Signal, pairs: Index | None = None) -> Range:
    """Smallest and largest value of every row, shaft lines at their worst, and largest length of pairs of rows (k, 2).

    Over the phase of one tone exact but for the shaft lines, of which each takes its worst phase, the same one in both
    rows of a pair.  Several tones add their largest values, combinations and shaft lines the sum of their amplitudes:
    a bound.
    """
    pairs = np.zeros((0, 2), np.int64) if pairs is None else pairs
    if signal.orders.points.shape[1] > 1:
        return _tone_sum_range(signal, pairs)
    value, lines = _phase_waveforms(signal)
    length = _largest_length(value[pairs.T], None if lines is None else lines[pairs.T])
    if lines is None:
        return Range(low=valley(value), high=peak(value), length=length)
    reach = np.abs(lines).sum(axis=2)
    return Range(low=-peak(reach - value), high=peak(reach + value), length=length)


def _largest_length(value: Array, lines: ComplexArray | None) -> Array:
    """Largest length over the phase of the tone of v + sum over s of Re(a_s exp(i phi_s)), all phi_s free, (k, P).

    value : (2, k, P, N) of both rows v.  lines : (2, k, P, S, N) of both rows a_s.
    """
    size: Array = np.hypot(*value)
    if lines is None or not size.size:
        return peak(size)
    # Instants whose bound, each line along its longest axis, is below what the best one has along its v are skipped;
    # the neighbours of one that is not are looked at, for the parabola of the peak.
    x, y = value / np.where(size > 0, size, 1.0)
    least = size + np.abs(x[:, :, None] * lines[0] + y[:, :, None] * lines[1]).sum(axis=2)
    square_x, square_y = (row.real**2 + row.imag**2 for row in lines)
    product = lines[0].real * lines[1].real + lines[0].imag * lines[1].imag
    across = np.sqrt((square_x - square_y) ** 2 + 4 * product**2)
    most = size + np.sqrt(0.5 * (square_x + square_y + across)).sum(axis=2)
    near = most >= least.max(axis=2, keepdims=True)
    near |= np.roll(near, 1, axis=2) | np.roll(near, -1, axis=2)
    least[near] = _longest(value[:, near], np.moveaxis(lines, 3, 1)[:, :, near])
    return peak(least)


def _longest(value: Array, lines: ComplexArray) -> Array:
    """Largest length of v + sum over s of Re(a_s exp(i phi_s)) over all phases phi_s, (M,); derived here.

    It is the largest of h(u) = abs(u . v) + sum abs(u . a_s) over the unit directions u.  From the best of some
    directions on, u turns to the vector that the phases best along u give.  h never falls by that, so that the
    result is a length which phases reach.

    Parameters
    ----------
    value : (2, M) of both rows v.  lines : (2, S, M) of both rows a_s.
    """
    size = np.abs(_TOWARDS @ value) + np.abs(np.tensordot(_TOWARDS, lines, axes=1)).sum(axis=1)
    x, y = _TOWARDS[size.argmax(axis=0)].T
    for _ in range(_TURNS):
        sense = np.where(x * value[0] + y * value[1] < 0, -1.0, 1.0)
        along = x * lines[0] + y * lines[1]
        size = np.abs(along)
        phase = along.conj() / np.where(size > 0, size, 1.0)
        x, y = (sense * v + (a * phase).real.sum(axis=0) for v, a in zip(value, lines, strict=True))
        best: Array = np.hypot(x, y)
        x, y = (component / np.where(best > 0, best, 1.0) for component in (x, y))
    return best


def _phase_waveforms(signal: Signal) -> tuple[Array, ComplexArray | None]:
    """Values of the tones over the grid of their phases (rows, P, N_1, ..) and shaft lines there, None without.

    Shaft lines : (rows, P, S, N_1, ..).
    """
    counts = phase_grid(signal.orders)
    value: Array = torus_waveform(signal.orders, counts, signal.cross)[:, :, 0]
    return value, None if signal.lines is None else torus_waveform(signal.lines, counts, signal.cross)


def _tone_sum_range(signal: Signal, pairs: Index) -> Range:
    """Sums of the smallest and of the largest values of single tones, everything else at its worst: bounds.

    The length of a pair of rows (k, 2) is the largest such bound over its directions.
    """
    orders = signal.orders
    combined = np.count_nonzero(orders.points, axis=1) > 1
    rest = [orders.amplitude[..., combined]] + ([] if signal.lines is None else [signal.lines.amplitude])
    rest = [amplitude.reshape(*amplitude.shape[:2], -1) for amplitude in rest]
    # each tone alone over the grid of its phase, (rows, P, N), the mean in the first
    waves = [
        tone_waveform(orders, axis, np.arange(count) / count, mean=axis == 0)[:, :, 0]
        for axis, count in enumerate(phase_grid(orders))
    ]
    reach: Array = sum(np.abs(amplitude).sum(axis=2) for amplitude in rest)
    low, high = sum(map(valley, waves), start=-reach), sum(map(peak, waves), start=reach)
    reach = sum(np.abs(np.tensordot(_TOWARDS, amplitude[pairs.T], axes=1)).sum(axis=3) for amplitude in rest)
    along = [np.tensordot(_TOWARDS, wave[pairs.T], axes=1) for wave in waves]
    least, most = sum(map(valley, along), start=-reach), sum(map(peak, along), start=reach)
    return Range(low=low, high=high, length=peak(np.moveaxis(np.maximum(-least, most), 0, -1)))


def phase_grid(orders: Spectrum) -> list[int]:
    """Grid points of every tone's phase: enough for the harmonics of the tone, with one tone four times that."""
    points = orders.points
    D = points.shape[1]
    multiples = points[np.count_nonzero(points, axis=1) <= 1]
    least, times = _GRID.get(D, 16), 4 if D == 1 else 1
    return [max(least, times * (2 * int(np.abs(multiples[:, j]).max(initial=0)) + 1)) for j in range(D)]


TOLERANCE = 1e-8
# A residual above this is refused, whatever tolerance was asked for.
_ACCEPTED = 1e-4


class ShaftLine(NamedTuple):
    """Response at frequencies that are no multiples of the tone of its `Periodic`.

    frequency : exact [Hz at the operating speed].  causes : paths in the file; of another mesh frequency its stages.
    force : (m, Nt) A_s(theta) [N]; it adds Re(A_s(theta) exp(2 pi i s f t)) to the mesh force at relative speed s.
    displacement : (n, Nt) the same of every coordinate [m, rad].
    Lines whose frequencies differ by, or add to, a multiple of the mesh frequency stand together in one.
    """

    frequency: Fraction
    causes: tuple[str, ...]
    force: ComplexArray
    displacement: ComplexArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Periodic:
    """Steady response over the phase of one mesh frequency.

    tone : that mesh frequency [Hz at the operating speed].  relative_speed : s, speed per operating speed.
    theta : (Nt,) mesh phase, (tone s t) mod 1.
    force : (m, Nt) mesh force at multiples of the tone with its mean, k(t) (B^T q - e) + c d/dt(B^T q - e) [N].
    displacement : (n, Nt) [m, rad].  lines : all other frequencies, of shafts and of other tones.
    harmonics : kept.  residual : relative, truncation included.
    bound : (w,) largest force of every whole mesh over all relative phases of tones and lines, as of `steady` [N]; None
        with one tone, where it is the largest of force and lines.
    """

    tone: Fraction
    relative_speed: float
    theta: Array
    force: Array
    displacement: Array
    lines: tuple[ShaftLine, ...]
    harmonics: int
    residual: float
    bound: Array | None = None


def periodic(
    system: System, *, relative_speed: float = 1.0, samples: int | None = None, tolerance: float = TOLERANCE
) -> Periodic:
    """Steady response of the linear-contact system at one speed, over the mesh cycle of the first mesh.

    Parameters
    ----------
    relative_speed : speed per operating speed, above zero.
    samples : of a mesh cycle; None takes as many as the harmonics need, 64 at least, in a multiple of the branches.
    tolerance : relative residual of the harmonics kept; the truncation is below 30 times that.  Lines of other tones
        that add up to less than it are left out.

    Raises
    ------
    ModelError : no damping, no mesh frequency, torques out of balance, or a speed not above zero.
    ConvergenceError : no solution; the speed lies on the edge of a parametric instability.
    """
    ready, block = solve_speed(system, relative_speed, tolerance)
    return _over_phase(ready, block, 0, samples, tolerance)


def periodic_by_tone(
    system: System, *, relative_speed: float = 1.0, samples: int | None = None, tolerance: float = TOLERANCE
) -> tuple[Periodic, ...]:
    """The steady response over the cycle of each mesh frequency, that of the first mesh first; as `periodic`."""
    ready, block = solve_speed(system, relative_speed, tolerance)
    return tuple(_over_phase(ready, block, axis, samples, tolerance) for axis in range(len(ready.lines.mesh_tones)))


def _over_phase(ready: Response, block: Block, axis: int, samples: int | None, tolerance: float) -> Periodic:
    """A solved block (P = 1) over the phase of the tone of one axis."""
    harmonics, meshes, tones = block.truncation[axis], ready.system.meshes, mesh_axis(ready)
    if samples is None:
        least = max(64, alias_free_samples(ready, harmonics))
        samples = samples_per_cycle(meshes, np.flatnonzero(tones == axis), least)
    theta = np.arange(samples) / samples
    force, motion = force_spectrum(ready, block, shifted=False), motion_spectrum(ready, block, shifted=False)
    lines = _other_lines(ready, force, motion, axis, theta)
    if block.shaft is not None:
        shaft_force, shaft_motion = (find(ready, block, shifted=True) for find in (force_spectrum, motion_spectrum))
        lines += _other_lines(ready, shaft_force, shaft_motion, axis, theta)
    bound = None
    if len(ready.lines.tones) > 1:
        every = whole_mesh_signal(force_signal(ready, block), faces(meshes))
        bound = force_extremes(every, axis=tones)[1][:, 0]
    return Periodic(
        tone=ready.lines.tones[axis],
        relative_speed=float(block.speed[0]),
        theta=theta,
        force=tone_waveform(force, axis, theta)[:, 0, 0].real,
        displacement=tone_waveform(motion, axis, theta)[:, 0, 0].real,
        lines=tuple(_significant(ready, lines, tolerance)),
        harmonics=harmonics,
        residual=float(block.residual[0]),
        bound=bound,
    )


def _other_lines(ready: Response, force: Spectrum, motion: Spectrum, axis: int, theta: Array) -> list[ShaftLine]:
    """All harmonics but the multiples of one tone, a line for each combination of the others and each shaft line.

    theta : (Nt,) phase of the tone [cycles].
    """
    pushed, moved = envelopes(force, axis, theta), envelopes(motion, axis, theta)
    known = {(s, *rest): i for i, (s, rest) in enumerate(zip(moved.shaft.tolist(), moved.rests.tolist(), strict=True))}
    stages = [f"{stage} mesh" for stage in ready.system.meshes.stage]
    words = stages + [f"{link} passing" for link in ready.system.varying.of[len(stages) :]]
    followers = list(zip([*ready.lines.axis.tolist(), *ready.lines.passing.tolist()], words, strict=True))
    lines = []
    for i, (s, rest) in enumerate(zip(pushed.shaft.tolist(), pushed.rests.tolist(), strict=True)):
        frequency = sum((a * tone for a, tone in zip(rest, ready.lines.tones, strict=True)), Fraction(0))
        if s >= 0:
            shaft = ready.lines.shaft[s]
            frequency, causes = frequency + shaft.frequency, shaft.causes
        else:
            causes = tuple(dict.fromkeys(word for tone, word in followers if rest[tone]))
        force_wave, wave = pushed.values[:, 0, i], np.zeros((moved.values.shape[0], theta.size), complex)
        if (s, *rest) in known:
            wave = moved.values[:, 0, known[s, *rest]]
        if frequency < 0:  # Re z = Re conj z
            frequency, force_wave, wave = -frequency, force_wave.conj(), wave.conj()
        lines.append(ShaftLine(frequency=frequency, causes=causes, force=force_wave, displacement=wave))
    return lines


def _significant(ready: Response, lines: list[ShaftLine], tolerance: float) -> list[ShaftLine]:
    """The lines without the smallest ones, as long as these add up to less than the tolerance in every signal."""
    if len(ready.lines.tones) == 1 or not lines:
        return lines
    radius = ready.system.dofs.radius[:, None]
    force = np.array([np.abs(line.force).max(axis=1) for line in lines])
    moved = np.array([np.abs(radius * line.displacement).max(axis=1) for line in lines])
    size = np.zeros(len(lines))
    for signal in (force, moved):
        size = np.maximum(size, (signal / max(float(signal.max()), np.finfo(float).tiny)).max(axis=1))
    order = np.argsort(size)
    needless = set(order[np.cumsum(size[order]) < tolerance].tolist())
    return [line for i, line in enumerate(lines) if i not in needless]


def solve_speed(system: System, relative_speed: float, tolerance: float) -> tuple[Response, Block]:
    """Solve one speed; arguments and errors as of `periodic`."""
    if not (math.isfinite(relative_speed) and relative_speed > 0):
        raise ModelError("out of range", path="relative_speed", given=relative_speed, allowed="a number above zero")
    ready = response(system)
    require_stable_mean(ready, float(relative_speed))
    block = next(respond(ready, np.array([float(relative_speed)]), tolerance=tolerance))
    if not block.residual[0] <= max(_ACCEPTED, 100 * tolerance):
        frequency = float(ready.lines.tone) * relative_speed
        raise ConvergenceError(
            f"no periodic response found at {frequency:.6g} Hz mesh frequency (residual {block.residual[0]:.2g}): "
            "try a slightly different speed or more damping"
        )
    if block.uncertainty[0] > _ACCEPTED:
        raise ConvergenceError(
            f"at {float(ready.lines.tone) * relative_speed:.6g} Hz mesh frequency a resonance is so sharp that double "
            "precision cannot tell the response: try a slightly different speed or more damping"
        )
    return ready, block


def superposed(system: System, relative_speed: float) -> System:
    """The System of constant mesh stiffness whose steady response is the superposition at one relative speed.

    Raises
    ------
    ModelError, ConvergenceError : as of `periodic`, for the mean.
    """
    meshes = system.meshes
    static = replace(system, meshes=replace(meshes, variation=np.zeros((len(meshes.name), 0), complex)))
    mean = periodic(
        replace(static, lines=tuple(line for line in system.lines if line.frequency == 0)),
        relative_speed=relative_speed,
    )
    gap = mean.force.mean(axis=1) / meshes.stiffness
    extra: dict[Fraction, ComplexArray] = {}
    for number in np.unique(meshes.tone):
        rows = meshes.tone == number
        for order in range(1, meshes.variation.shape[1] + 1):
            frequency = system.tones[number] * order
            omega = 2 * np.pi * float(frequency) * relative_speed
            # the error that acts as this harmonic of dk dbar
            force = meshes.stiffness * meshes.variation[:, order - 1] * gap
            error = -force / (meshes.stiffness + 1j * omega * meshes.damping)
            extra[frequency] = extra.get(frequency, np.zeros(len(gap), complex)) + np.where(rows, error, 0.0)
    lines = [replace(line, gap=line.gap + extra.get(line.frequency, 0.0)) for line in system.lines]
    known = {line.frequency for line in lines}
    no_link_error, no_force = np.zeros(len(system.links.name), complex), np.zeros((3, len(system.force)), complex)
    lines += [
        Line(frequency=frequency, gap=error, link_gap=no_link_error, force=no_force, causes=("mesh stiffness",))
        for frequency, error in extra.items()
        if frequency not in known and error.any()
    ]
    return replace(static, lines=tuple(sorted(lines, key=lambda line: line.frequency)))
