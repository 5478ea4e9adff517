"""Mesh forces over a record as a mesh-order part and a few slow shaft lines, exact at every instant; derived here.

    F_m(c, theta) = mean_m(theta) + Re sum_s A_ms(theta) exp(2 pi i ratio_s c),    t = (c + theta) / f_mesh

with the cycle number c and the phase theta in the cycle.  A record of many cycles is then one matrix product.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...statics.equilibrium import Compliance, Values, closed_approach, closed_force, require_balance, require_forces
from ...statics.quasi_static import HeldTrain
from ...statics.record import mesh_stiffness, turn_fraction
from ...system.gaps import flanks
from ...system.system import Array, ComplexArray, System

if TYPE_CHECKING:
    from ...questions.response.periodic import Periodic

__all__ = ["Waves", "cycle_forces", "far_waves", "force_bound", "line_phases", "periodic_waves", "static_waves"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Waves:
    """Mesh forces of a whole record.

    mean : (m, Nt) [N].  ratios : (L,) line frequency per mesh frequency, exact.
    amplitude : (L, m, Nt) complex [N], the turning of the line within the cycle included.
    """

    mean: Array
    ratios: tuple[Fraction, ...]
    amplitude: ComplexArray

    @property
    def samples(self) -> int:
        """Instants per mesh cycle."""
        return int(self.mean.shape[1])

    def subset(self, meshes: NDArray[np.int64]) -> Waves:
        """The same of some of the meshes (m_j,)."""
        return replace(self, mean=self.mean[meshes], amplitude=self.amplitude[:, meshes])


def periodic_waves(solution: Periodic) -> Waves:
    """Waves of the periodic response, forces (m, Nt) [N]; lines off the mesh orders keep their exact frequency."""
    ratios = tuple(line.frequency / solution.tone for line in solution.lines)
    m, Nt = solution.force.shape
    amplitude = np.zeros((len(ratios), m, Nt), dtype=complex)
    for s, (ratio, line) in enumerate(zip(ratios, solution.lines, strict=True)):
        amplitude[s] = line.force * np.exp(2j * np.pi * float(ratio) * solution.theta)
    return Waves(mean=np.asarray(solution.force), ratios=ratios, amplitude=amplitude)


def static_waves(system: System, flexible: Compliance, tone: Fraction, samples: int) -> Waves:
    """Waves (m, Nt) [N] of the static solution with all meshes closed: at each phase it is linear in the lines.

    Raises
    ------
    ModelError : a load works on a free motion.
    ConvergenceError : forces on a body do not balance.
    """
    k = mesh_stiffness(system, tone, np.arange(samples), samples)
    require_balance(flexible.free, system.force[None], system)
    for line in system.lines:
        require_balance(flexible.free, np.array([line.force[0].real, line.force[0].imag]), system)

    left, size = np.zeros(samples), np.zeros(samples)

    def solved(gap: Values, load: Values) -> Values:
        """Forces (Nt, m) [N] under errors (Nt, m) [m] and loads (Nt, n) [N, N m]."""
        force, missed, largest = closed_force(flexible, k, gap, load)
        np.add(left, missed, out=left)
        if load.any():
            np.maximum(size, largest, out=size)
        return force

    found = _summed(system, tone, samples, solved, [line.gap for line in system.lines], np.zeros(k.shape[1]))
    if size.any():
        require_forces(left, size)
    return found


def far_waves(system: System, train: HeldTrain, tone: Fraction, samples: int) -> Waves | None:
    """Waves of how far the far flanks reach beyond first touch with all loaded flanks closed, (c, Nt) [m].

    None where there are none, or where none touches at any phases of the lines.
    """
    far = system.far_flanks
    c, m = far.mesh.size, len(system.meshes.name)
    if train.both is None:
        return None
    k = np.hstack([mesh_stiffness(system, tone, np.arange(samples), samples), np.zeros((samples, c))])
    flexible = train.both
    phases = np.zeros((samples, max(1, len(system.tones))))
    if tone in system.tones:
        phases[:, system.tones.index(tone)] = np.arange(samples) / samples
    touch = flanks(system).at(phases).touch[:, m:]

    def solved(gap: Values, load: Values) -> Values:
        """Gaps (Nt, c) [m] of the far flanks under errors (Nt, m + c) [m] and loads (Nt, n) [N, N m]."""
        reach: Values = closed_approach(flexible, k, gap, load @ flexible.gap_of_force.T)[:, m:] - gap[:, m:]
        return reach

    opening = np.concatenate([np.zeros(m), system.meshes.backlash[far.mesh]])
    found = _summed(system, tone, samples, solved, [system.flank_gaps(line) for line in system.lines], opening)
    found = replace(found, mean=found.mean - touch.T)
    return found if np.any(force_bound(found) > 0) else None


def _summed(
    system: System,
    tone: Fraction,
    samples: int,
    solved: Callable[[Values, Values], Values],
    gaps: Sequence[ComplexArray],
    still: Array,
) -> Waves:
    """Waves of what is linear in errors and loads: solved (errors (Nt, r), loads (Nt, n)) -> (Nt, ..).

    Parameters
    ----------
    gaps : errors (r,) of every line [m].  still : (r,) further constant errors [m].
    """
    theta = np.arange(samples) / samples
    mean = solved(np.tile(still, (samples, 1)), np.tile(system.force, (samples, 1)))
    ratios, amplitude = [], []
    for line, gap in zip(system.lines, gaps, strict=True):
        ratio = line.frequency / tone
        turning = np.exp(2j * np.pi * float(ratio) * theta)[:, None]
        value = solved(turning * gap, turning * line.force[0])
        if ratio.denominator == 1:
            mean = mean + value.real
        else:
            ratios.append(ratio)
            amplitude.append(value.T)
    shape = (len(ratios), *mean.T.shape)
    return Waves(mean=mean.T, ratios=tuple(ratios), amplitude=np.array(amplitude, dtype=complex).reshape(shape))


def cycle_forces(waves: Waves, phases: Array) -> Array:
    """Mesh forces (cycles, m, Nt) [N] in cycles that start with given line phases (cycles, L) [turns]."""
    m, Nt = waves.mean.shape
    flat = waves.amplitude.reshape(len(waves.ratios), m * Nt)
    angle = 2 * np.pi * phases
    turning = np.hstack([np.cos(angle), -np.sin(angle)])
    return (turning @ np.vstack([flat.real, flat.imag])).reshape(-1, m, Nt) + waves.mean


def line_phases(ratios: Sequence[Fraction], cycles: NDArray[np.int64]) -> Array:
    """Phase of each line at the start of each cycle, (cycles, L) [turns], exact."""
    return np.array([turn_fraction(ratio, cycles) for ratio in ratios]).reshape(len(ratios), len(cycles)).T


def force_bound(waves: Waves) -> Array:
    """Upper bound of the mesh forces over all shaft phases: max over the cycle of mean + sum |A|, (m,) [N].

    Phases are discrete and may be tied by common factors of tooth numbers, so it need not be reached.
    """
    largest: Array = np.max(waves.mean + np.sum(np.abs(waves.amplitude), axis=0), axis=1)
    return largest
