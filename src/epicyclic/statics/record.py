"""Records of a train that turns slowly, and loads along motions that nothing holds.

Of these it is told which member moves, in which direction, and how much (derived here).  The motions without stiffness
are the null space N of the mean stiffness; a load F works on them with w = N'F.  Holding the coordinates D takes the
reactions with N_D' reactions = w, if there are any.  A turning train is such a motion too, but torques in equilibrium
do not work on it; a helical gear that can slide along its axis is another, a screw.

Instants of a record are counted in exact fractions of a mesh cycle, and the excitation lines are evaluated at them.
Where a mesh carries no load in the mean, load sharing and dynamic factor are not defined.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import gcd, lcm
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..engine.plan import MOST_NUMBERS, require_memory
from ..errors import ModelError
from ..system.gaps import flanks
from ..system.system import Array, ComplexArray, Line, MeshRows, System, elastic_rows, faces, free_motions
from ..warning_codes import CodedText, code_of, coded

# Part of the work that reactions may leave: the null space has an error of 1e-10, radii that are printed one of 1e-4.
_WORK_LEFT = 1e-6
# Load that counts, per the largest: torques written with six digits leave 1e-6 of themselves.
_SMALL = 1e-5
# Torques balanced in the input leave rounding on a rigid mode, 1e-13 of the sum of magnitudes; a wrong one far more.
_LEFT_OVER = 1e-9
_OF_SEVERAL = (
    "a direction that one of several bearings names, by a key or by parts without a stated radial, is 0 "
    "in those that do not name it, and rigid in the first where none does"
)
# Mean force of a link per its largest one that is rounding.
_NO_MEAN = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Unheld:
    """A coordinate that nothing holds against a load.

    name : of the coordinate, ``main/sun/z``.  load : along it [N, N m].
    """

    name: str
    load: float

    @property
    def key(self) -> str:
        """Path of the key of the model file that holds it: ``stages.main.sun.support.z``."""
        *body, direction = self.name.split("/")
        group = {"x": "radial", "y": "radial", "z": "z"}.get(direction, "tilt")
        if len(body) == 1:
            return f"bodies.{body[0]}.support.{group}"
        carried = any(part.isdigit() for part in body)
        return f"stages.{body[0]}.{body[1]}.{'bearing' if carried else 'support'}.{group}"

    def __str__(self) -> str:
        """Body, direction and load in words."""
        body, _, direction = self.name.rpartition("/")
        if direction == "z":
            return f"the thrust of {abs(self.load) / 1e3:.4g} kN on {body}"
        if direction in ("x", "y"):
            return f"the force of {abs(self.load) / 1e3:.4g} kN along {direction} on {body}"
        return f"the moment of {abs(self.load):.4g} N m about {direction[1:]} on {body}"


def unheld(free: Array, force: Array, names: Sequence[str]) -> tuple[Unheld, ...]:
    """Coordinates whose holding would take the load along free motions, as few as possible.

    Parameters
    ----------
    free : (n, r) motions without stiffness.  force : (n,) load [N, N m].  names : of the n coordinates.

    Returns
    -------
    Coordinates with their loads; none where the load balances, and where it is a torque about the axes that does not.
    """
    work = free.T @ force
    size = float(np.max(np.abs(force), initial=0.0))
    if not free.size or not np.linalg.norm(work) > _SMALL * size * float(np.max(np.abs(free))):
        return ()
    turns = np.array([name.endswith("/rz") for name in names])
    carried = np.array([any(part.isdigit() for part in name.split("/")) for name in names])
    if _reactions(free, work, turns, most=1):
        return ()
    reactions = _reactions(free, work, ~turns & ~carried) or _reactions(free, work, ~turns)
    return tuple(Unheld(name=names[i], load=load) for i, load in reactions.items())


def unheld_error(coordinates: Sequence[Unheld], system: System) -> ModelError:
    """What to raise where coordinates are not held against the load; there is at least one."""
    problem = f"nothing takes {', '.join(map(str, coordinates))}"
    loose = [key.rsplit(".", 1) for key in dict.fromkeys(coordinate.key for coordinate in coordinates)]
    places = [(seat, [f"{seat}.{name}" for name in system.bearings.get(seat, ())], key) for seat, key in loose]
    keys = [f"{place}.{key}" for seat, named, key in places for place in named or [seat]]
    if (seat := loose[0][0]) in system.bearings:
        return ModelError(problem, path=seat, allowed=f"a stiffness in one of {', '.join(keys)}: {_OF_SEVERAL}")
    allowed = f"a stiffness in {', '.join(keys)}, or no such key: a direction that is not named is rigid"
    return ModelError(problem, path=keys[0], given=0, allowed=allowed)


def contradicting_radii(system: System) -> str:
    """What the train says of base radii that miss the teeth, "" where they do not: no torque balances on such radii."""
    return "; ".join(text for text in system.warnings if code_of(text) == "base-radius-far")


def require_free_balance(free: Array, load: Array, system: System, *, path: str, cure: str) -> None:
    """Refuse a load (n,) that works on a rigid mode, a column of `free` (n, r): nothing would hold the train in place.

    Raises
    ------
    ModelError : the work on a rigid mode is more than rounding.
    """
    work, size = np.abs(free.T @ load), np.abs(free).T @ np.abs(load)
    if not np.any(work > _LEFT_OVER * size):
        return
    if coordinates := unheld(free, load, system.dofs.names):
        raise unheld_error(coordinates, system)
    worst = int(np.argmax(work / np.where(size > 0, size, 1.0)))
    name = system.dofs.names[int(np.argmax(np.abs(free[:, worst] * system.dofs.radius)))]
    raise ModelError(
        f"the external torques and forces do not balance on the free motion of {name}: "
        f"{work[worst] / size[worst]:.3g} of them is left over",
        path=path,
        allowed="; ".join(filter(None, (cure, contradicting_radii(system)))),
    )


def standing_load(system: System) -> Array:
    """Load (n,) [N, N m] that stands still in the frame of its stage: torques, gravity and lines that do not turn."""
    return standing_excitation(system)[-len(system.force) :]


def unheld_warnings(system: System, free: Array) -> list[CodedText]:
    """Warning of a mean load that works on motions without stiffness (n, r), one text at most."""
    force = standing_load(system)
    if not force.any():
        return []
    coordinates = unheld(free, force, system.dofs.names)
    return [coded("load-not-held", str(unheld_error(coordinates, system)))] if coordinates else []


def _reactions(free: Array, work: Array, offered: NDArray[np.bool_], most: int | None = None) -> dict[int, float]:
    """Reaction of each coordinate, out of those offered (n,), that together take the work (r,); empty without any.

    One coordinate after the other, that which the rest of the work is closest to in direction.
    """
    length = np.linalg.norm(free, axis=1)
    usable = np.flatnonzero(offered & (length > _WORK_LEFT * float(np.max(length, initial=0.0))))
    chosen: list[int] = []
    rest = np.asarray(work)
    while usable.size and len(chosen) < (most or free.shape[1]):
        along = np.abs(free[usable] @ rest) / length[usable]
        chosen.append(int(usable[int(np.argmax(along))]))
        reaction = np.linalg.lstsq(free[chosen].T, work, rcond=None)[0]
        rest = np.asarray(work - free[chosen].T @ reaction)
        if np.linalg.norm(rest) <= _WORK_LEFT * np.linalg.norm(work):
            return dict(zip(chosen, map(float, reaction), strict=True))
        usable = usable[~np.isin(usable, chosen)]
    return {}


MeshGroup = NDArray[np.int64]
"""Indices of meshes that share a load, one per branch; slices of a mesh count once."""

# Forces are solved to a relative residual of 1e-9 and better: one that changes by less than this part stands still.
_CONSTANT = 1e-8
# The product of two numbers below this stays exact in int64.
_EXACT_PRODUCT = 2**31
# A mean force below this part of the largest force is none: responses are solved to a relative residual of 1e-6, so
# that what is left of the balance of an idle gear is not known to be above zero.
_NONE = 1e-6


class RecordExcitation(NamedTuple):
    """Stiffness, errors and load at T instants.

    stiffness, far_stiffness : (T, m), (T, c) of the loaded and the far flanks, tangents where they have laws [N/m].
    gap : (T, m + R) errors of the meshes and the rows of groups [m].
    far_gap : (T, c) errors and backlash of the far flanks [m].
    force : (T, n) generalised force at rest [N, N m].  link_gap : (T, p) of the linear links [m, rad].
    phases : (T, tones) of the mesh frequencies [turns].
    """

    stiffness: Array
    far_stiffness: Array
    gap: Array
    far_gap: Array
    force: Array
    link_gap: Array
    phases: Array

    def at(self, chosen: NDArray[np.int64] | slice) -> RecordExcitation:
        """The same at the instants `chosen` (t,)."""
        return RecordExcitation(*(values[chosen] for values in self))


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """Instants of so many units of time, mesh cycles or turns.

    unit : frequency of what is counted, exact [Hz].  name : what that is, ``mesh cycles``.
    count : units of the record.  samples : instants per unit.
    period : units after which all lines and mesh stiffnesses are as they were.  period_name : what that is.
    spread : whether the units are spread over the period, as of `spread_cycles`; else they stand in a row from 0 on.
    """

    unit: Fraction
    name: str
    count: int
    samples: int
    period: int
    period_name: str = "common period"
    spread: bool = False

    @property
    def instants(self) -> int:
        """Number of instants."""
        return self.count * self.samples

    @property
    def units(self) -> NDArray[np.int64]:
        """Which units these are, rising (count,)."""
        return spread_cycles(self.period, self.count) if self.spread else np.arange(self.count, dtype=np.int64)

    @property
    def index(self) -> NDArray[np.int64]:
        """The instants in parts 1 / samples of a unit (T,)."""
        return (self.units[:, None] * self.samples + np.arange(self.samples)).ravel()

    @property
    def options(self) -> dict[str, object]:
        """Length and instants per unit, as results state them: of mesh cycles by the name of the option."""
        return {"cycles" if self.name == "mesh cycles" else self.name: self.count, "samples": self.samples}

    def warnings(self, least: Array, most: Array) -> list[CodedText]:
        """A warning where the record is shorter than the period and any force changes in it by more than rounding.

        least, most : extremes of forces over the record (m,) [N, N m].
        """
        largest = np.max(np.abs([least, most]), initial=0.0)
        if self.count >= self.period or not np.max(most - least, initial=0.0) > _CONSTANT * largest:
            return []
        option = "--turns" if self.name.startswith("turns") else "--cycles"
        text = f"record of {self.count} {self.name} is shorter than the {self.period_name} of {self.period}"
        return [coded("short-record", f"{text}; {option} takes more of it")]


def spread_cycles(period: int, count: int) -> NDArray[np.int64]:
    """At most `count` mesh cycles of a hunting period, rising, at phases of all lines as even as may be, (c,).

    Of one line of frequency p/q per mesh frequency the mesh cycles 0, d, 2 d ... take every phase in turn where d and q
    share no factor.  The step d is the first from an even division of the period on that shares no factor with the
    period, so that the cycles are even in time and the phases of every line are too, whatever the tooth numbers (a step
    that divides the period would leave some lines at one phase).  Derived here.
    """
    if period <= count:
        return np.arange(period, dtype=np.int64)
    step = -(-period // count)
    while gcd(step, period) > 1:  # next to any number there is a coprime one within a few steps
        step += 1
    # Python's integers: period times count may be beyond 64 bits
    return np.array(sorted(place * step % period for place in range(count)), dtype=np.int64)


def period_name(system: System, mesh_cycles: bool = True) -> str:
    """What the period of a record is, counted in mesh cycles or in others."""
    if len(system.tones) > 1:
        shafts = any(line.frequency not in (0, *system.tones) for line in system.lines)
        return f"common period of the mesh frequencies{' and shaft orders' if shafts else ''}"
    return "hunting period" if mesh_cycles else "common period"


def reference_tone(system: System) -> Fraction:
    """Frequency the record is counted in: of the first mesh [Hz]; 1 Hz (time in cycles) where no speed is given."""
    if not system.tones or not len(system.meshes.tone):
        return Fraction(1)
    return system.tones[int(system.meshes.tone[0])]


def record_of(
    system: System,
    *,
    cycles: int | None,
    turns: int | None,
    of: str | None,
    samples: int,
    most: int,
    slow: bool = False,
) -> Record:
    """The record that is asked for; the common period, as far as `most` instants go, where no length is.

    Parameters
    ----------
    cycles : mesh cycles of the first mesh.  turns : turns of the body `of`; `of` alone asks for its common period.
    samples : instants per mesh cycle or turn.  most : instants that may be chosen.
    slow : where nothing changes within a mesh cycle, count in cycles of the fastest line instead.

    Raises
    ------
    ModelError : both lengths, a body that does not turn, more instants than memory may hold.
    """
    if cycles is not None and (turns is not None or of is not None):
        raise ModelError("a record has one length", path="cycles, turns", allowed="cycles, or turns of a body")
    unit, name = reference_tone(system), "mesh cycles"
    if turns is not None or of is not None:
        unit, name = _turn_rate(system, of), f"turns of {of}"
    elif slow and cycles is None and not np.any(system.meshes.variation) and not system.meshes.laws:
        fastest = max((line.frequency for line in system.lines), default=Fraction(0))
        if system.tones and 0 < fastest < min(system.tones):
            unit, name = fastest, "cycles of the fastest error"
    varying = np.any(system.meshes.variation != 0, axis=1)
    for lawful in system.meshes.laws:
        varying[lawful.rows] = True
    tones = [system.tones[i] for i in np.unique(system.meshes.tone[varying])] if system.tones else []
    period = hunting_cycles([f / unit for f in (*(line.frequency for line in system.lines), *tones)])
    path, length = ("cycles", cycles) if turns is None else ("turns", turns)
    count = length or min(period, max(1, most // samples))
    width = len(system.meshes.name) + len(system.force) + len(system.links.name)
    require_memory(
        float(count) * samples * width,
        path=f"{path}, samples",
        given=f"{count} {name} of {samples} instants",
        allowed=f"{MOST_NUMBERS // width} instants or fewer",
    )
    called = period_name(system, name == "mesh cycles")
    return Record(unit=unit, name=name, count=count, samples=samples, period=period, period_name=called)


def _turn_rate(system: System, body: str | None) -> Fraction:
    """Turns per second of a body, exact [Hz].

    Raises
    ------
    ModelError : no such body, or it does not turn.
    """
    rates = {name: abs(turn) for name, turn in zip(system.dofs.bodies, system.body_turns, strict=False) if turn}
    body = None if body is None else body.replace(".", "/")
    if body is None or body not in rates:
        given = {} if body is None else {"given": body}
        allowed = ", ".join(rates) or "a train's speed"
        raise ModelError("turns are counted of a body that turns", path="of", allowed=allowed, **given)
    return rates[body]


def turn_fraction(ratio: Fraction, index: NDArray[np.int64]) -> Array:
    """Fractional part of ratio * index (T,) in [0, 1) [turns], exact before the last division where int64 allows it."""
    q = ratio.denominator
    p = ratio.numerator % q
    if q < _EXACT_PRODUCT and int(np.max(np.abs(index), initial=0)) < _EXACT_PRODUCT:
        return (index * p % q) / q
    return np.asarray(np.mod(float(Fraction(p, q)) * index, 1.0))


def parallel_meshes(meshes: MeshRows) -> list[MeshGroup]:
    """Meshes that share one load: indices of the whole meshes of each pair and side, (branches,) each.

    In order of first appearance; slices of a mesh count once.
    """
    keys = [(meshes.pair[i], meshes.side[i]) for i in faces(meshes).first.tolist()]
    return [np.array([i for i, other in enumerate(keys) if other == key]) for key in dict.fromkeys(keys)]


def shares(force: Array, members: Sequence[MeshGroup]) -> Array:
    """N F_i / sum_j F_j [1] of each mesh in its group, of forces (.., m) [N], as of `group_shares`."""
    share = np.empty_like(force)
    for group in members:
        share[..., group] = group_shares(force[..., group])
    return share


def group_shares(force: Array, axis: int = -1) -> Array:
    """N F_i / sum_j F_j [1] of the N meshes of one group, along an axis of their forces [N] [ren2021, eq. 21-24].

    inf where the forces sum to nothing or less, as those of a linear model pulled open.
    """
    total, share = force.sum(axis=axis, keepdims=True), float(force.shape[axis]) * force
    closed = total > 0
    with np.errstate(divide="ignore", invalid="ignore"):
        share /= total
    return share if closed.all() else np.where(closed, share, np.inf)


def samples_per_cycle(meshes: MeshRows, chosen: MeshGroup, least: int) -> int:
    """Samples of a mesh cycle for which equal branches whose meshes are equally out of phase have equal peaks.

    The smallest number, `least` or above, that is a multiple of the branches of every group of the meshes `chosen`
    (c,).
    """
    wanted = set(chosen.tolist())
    unit = lcm(*(len(group) for group in parallel_meshes(meshes) if int(group[0]) in wanted))
    return -(-least // unit) * unit


def hunting_cycles(ratios: Iterable[Fraction]) -> int:
    """Mesh cycles after which every line returns to its phase; ratios : line per mesh frequency, exact [1]."""
    return lcm(*(ratio.denominator for ratio in ratios))


def mesh_phases(system: System, tone: Fraction, index: NDArray[np.int64], samples: int) -> Array:
    """Phases (T, tones) of the mesh tones at instants index (T,) / (samples tone), whole cycles taken off [turns]."""
    ratios = [other / tone for other in system.tones] or [Fraction(1)]
    return np.array([turn_fraction(ratio / samples, index) for ratio in ratios]).T


def stiffness_at(system: System, phases: Array) -> tuple[Array, Array]:
    """Stiffness (T, m) and (T, c) [N/m] of loaded and far flanks at phases (T, tones) of the mesh tones [turns]."""
    loaded, far = np.split(flanks(system).tangent.at(phases).stiffness, [len(system.meshes.name)], axis=1)
    return loaded, far


def excitation(system: System, tone: Fraction, index: NDArray[np.int64], samples: int) -> RecordExcitation:
    """Excitation of the train at rest at instants index (T,) / (samples tone) of the operating speed.

    The part at rest of a line's force counts (``force[0]``).  What grows with speed is inertia and is left out.
    """
    turns = [turn_fraction(line.frequency / tone / samples, index) for line in system.lines]
    waves = np.exp(2j * np.pi * np.array(turns).reshape(len(turns), len(index)).T)
    return excitation_at(system, waves, mesh_phases(system, tone, index, samples))


def excitation_at(system: System, waves: ComplexArray, phases: Array) -> RecordExcitation:
    """Excitation of the train at rest at T instants.

    Parameters
    ----------
    waves : (T, lines) exp(i phase) of every line.  phases : (T, tones) of the mesh frequencies [turns].
    """
    lines, still = system.lines, still_excitation(system)
    amplitude = np.array([line_excitation(system, line) for line in lines], complex).reshape(len(lines), still.size)
    of_links = np.array([line.link_gap for line in lines], complex).reshape(len(lines), len(system.links.name))
    return excitation_of(system, still + (waves @ amplitude).real, phases, link_gap=(waves @ of_links).real)


def still_excitation(system: System) -> Array:
    """Errors and force (m + R + c + n,) without any line: what flanks are open by [m], the load [N, N m]."""
    loaded, far = np.split(system.flank_opening, [len(system.meshes.name)])
    return np.concatenate([loaded, np.zeros(sum(len(group.rows) for group in system.groups)), far, system.force])


def standing_excitation(system: System) -> Array:
    """The same with all lines that do not turn."""
    standing = [line_excitation(system, line).real for line in system.lines if line.frequency == 0]
    return sum(standing, still_excitation(system))


def line_excitation(system: System, line: Line) -> ComplexArray:
    """Amplitudes of a line in loaded flanks, rows of groups and far flanks [m], and its force at rest [N, N m]."""
    gaps, m = system.flank_gaps(line), len(system.meshes.name)
    of_groups = group_gap(line, sum(len(group.rows) for group in system.groups))
    return np.concatenate([gaps[:m], of_groups, gaps[m : m + system.far_flanks.mesh.size], force_at_rest(system, line)])


def link_factor(largest: Array, average: Array) -> Array:
    """Largest size of a force or moment per its mean [1], nan where the mean is rounding: of a torque its ripple."""
    carried = largest > _NO_MEAN * largest.max(axis=0, initial=0.0)  # of those that carry anything
    known = carried & (np.abs(average) > _NO_MEAN * largest)
    return np.asarray(np.where(known, largest, np.nan) / np.where(known, np.abs(average), 1.0))


def force_at_rest(system: System, line: Line) -> ComplexArray:
    """Force of a line on a train that turns slowly, (n,) [N, N m]: of torque ripple without what accelerates it.

    By d'Alembert F - M N (N' M N)^-1 N' F with the free motions N, the limit of the dynamic response at slow ripple.
    """
    if not line.ripple.any():
        return np.asarray(line.force[0])
    free, carried = _inertia_of_free_motions(system)
    return np.asarray(line.force[0] - carried @ (free.T @ line.ripple))


@lru_cache(maxsize=4)  # of one train many lines
def _inertia_of_free_motions(system: System) -> tuple[Array, Array]:
    """Free motions N (n, r) and M N (N' M N)^-1 (n, r). Raises ModelError for a missing inertia."""
    system.require_inertia()
    scale = 1 / np.sqrt(np.diag(system.M))[:, None]
    rows = np.hstack([elastic_rows(system), system.meshes.B, system.group_rows])
    free = scale * free_motions(scale * rows)[0]
    return free, system.M @ free @ np.linalg.inv(free.T @ system.M @ free)


def excitation_of(
    system: System, values: Array, phases: Array, *, stiffness: Array | None = None, link_gap: Array | None = None
) -> RecordExcitation:
    """Excitation at T instants of errors and forces (T, m + R + c + n) as of `line_excitation`.

    Parameters
    ----------
    phases : (T, tones) of the mesh frequencies [turns].  stiffness : (T, m) of both flanks [N/m]; None: at the phases.
    link_gap : (T, p) [m, rad]; none where None.
    """
    far, n = system.far_flanks.mesh, len(system.force)
    gap, far_gap, force = np.split(values, [-n - far.size, -n], axis=1)
    if stiffness is None:
        stiffness, far_stiffness = stiffness_at(system, phases)
    else:
        far_stiffness = stiffness[:, far]
    link_gap = np.zeros((len(values), 0)) if link_gap is None else link_gap
    return RecordExcitation(stiffness, far_stiffness, gap, far_gap, force, link_gap, phases)


def group_gap(line: Line, rows: int) -> ComplexArray:
    """Amplitudes of a line's errors in the rows of groups, (R,) [m]; zeros where the line holds none."""
    return line.group_gap if line.group_gap.size else np.zeros(rows, dtype=complex)


def loaded_meshes(mean: Array, members: Sequence[MeshGroup], *, most: Array, rounding: float) -> NDArray[np.bool_]:
    """Meshes of groups that carry load in the mean, (m, ..), from mean forces (m, ..) [N].

    The meshes of a pair are asked together: those of an idle gear may be pressed against each other.

    Parameters
    ----------
    members : meshes of one pair and side.  most : (m, ..) largest forces [N].  rounding : a force that is none [N].
    """
    least = least_load(mean, most=most, rounding=rounding)
    loaded = np.zeros(mean.shape, dtype=bool)
    for group in members:
        loaded[group] = mean[group].sum(axis=0) > least
    return loaded


def least_load(mean: Array, *, most: Array, rounding: float) -> Array:
    """Mean force (..) [N] from which on a mesh carries load; arguments as of `loaded_meshes`.

    An idle group beside loaded ones, or one that only swings, carries rounding.
    """
    largest = np.max(np.nan_to_num(np.abs([mean, most])), axis=(0, 1), initial=0.0)
    return np.asarray(np.maximum(_NONE * largest, rounding))


def idle_warnings(meshes: Sequence[str], loaded: NDArray[np.bool_], what: str) -> list[CodedText]:
    """A warning of the meshes without load, (m,), and `what` is not defined there."""
    names = ", ".join(name for name, yes in zip(meshes, loaded, strict=True) if not yes)
    return [coded("mesh-without-load", f"no load, or next to none, hence no {what}, in {names}")] if names else []
