"""Speeds, ratios, orders, torques and power of a train, exact, from one linear solve of small systems of fractions.

Speeds and torques of members are dual: the admissible speeds are the null space of the mesh and coupling equations, and
external torques are in equilibrium when their virtual power is zero in every admissible motion.  Derived here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeVar

from ..errors import ModelError

Row = list[Fraction]
Known = TypeVar("Known")
Label = TypeVar("Label", int, str)
Exact = TypeVar("Exact", int, Fraction)


def merged(labels: Mapping[str, Label], pairs: Iterable[tuple[str, str]]) -> dict[str, Label]:
    """Labels of names, the least one for all that pairs join with one another."""
    result = dict(labels)
    for a, b in pairs:
        low, high = sorted((result[a], result[b]))
        result = {name: low if label == high else label for name, label in result.items()}
    return result


def spread(
    known: Mapping[str, Known], joints: Sequence[tuple[str, str, Any]], step: Callable[[Known, Any], Known]
) -> dict[str, Known]:
    """Values of names: known ones, and those that joints (from, to, what) lead to by step(value, what).

    The nearest to a known one come first, each by the first joint that leads there.
    """
    found, reached = dict(known), list(known)
    for name in reached:
        for _, end, what in (joint for joint in joints if joint[0] == name and joint[1] not in found):
            found[end] = step(found[name], what)
            reached.append(end)
    return found


def null_space(rows: Sequence[Sequence[Fraction]], order: Sequence[int]) -> dict[int, Row]:
    """Basis of the null space: vectors v (n,), rows @ v = 0, by the free unknown that is 1 in v and 0 in the others.

    rows : (m, n).  order : all n unknowns; later ones become free first.
    """
    reduced, pivots = _reduce([[row[j] for j in order] for row in rows], len(order))
    free = [j for j in range(len(order)) if j not in pivots]
    vectors: dict[int, Row] = {}
    for j in free:
        vector = [Fraction(0)] * len(order)
        vector[order[j]] = Fraction(1)
        for row, pivot in zip(reduced, pivots, strict=True):
            vector[order[pivot]] = -row[j]
        vectors[order[j]] = vector
    return vectors


def least_norm(rows: Sequence[Sequence[Fraction]], right: Sequence[Fraction]) -> Row | None:
    """Solution x (n,) of least norm of rows @ x = right, rows (m, n), right (m,); None where there is none."""
    count = len(rows[0]) if rows else 0
    reduced, pivots = _reduce([[*row, value] for row, value in zip(rows, right, strict=True)], count + 1)
    if count in pivots:
        return None
    solution = [Fraction(0)] * count
    for row, pivot in zip(reduced, pivots, strict=True):
        solution[pivot] = row[count]
    idle = list(null_space(rows, range(count)).values())
    if not idle:
        return solution
    # Take away the part along the null space: N (N^T N)^-1 N^T x.
    weights = least_norm([[_dot(u, v) for v in idle] for u in idle], [_dot(u, solution) for u in idle])
    assert weights is not None  # N^T N of independent vectors is regular
    return [
        value - sum((w * v[j] for w, v in zip(weights, idle, strict=True)), Fraction(0))
        for j, value in enumerate(solution)
    ]


def whole_solution(rows: Sequence[Sequence[int]], count: int) -> tuple[list[Row], list[list[int]]]:
    """Solutions of rows @ x = right + whole numbers: (inverse, kernel) of rows (m, count), both exact.

    It has a solution exactly where every number of kernel @ right is whole; inverse @ right is one then, unknowns that
    may have any value being 0.  kernel (r, m) is a basis of all vectors y of whole numbers with y @ rows = 0, each with
    its last entry, positive, at a row of its own, later rows first.  It decides because such a basis maps whole numbers
    onto all whole numbers (Hermite normal form, by the algorithm of Euclid on the rows).
    """
    size = len(rows)
    tagged = [[*row, *(int(i == j) for j in range(size))] for i, row in enumerate(rows)]
    done, left = _whole_echelon(tagged, count)
    reduced, pivots = _reduce([[Fraction(value) for value in row] for row in done], count)
    inverse = [[Fraction(0)] * size for _ in range(count)]
    for row, pivot in zip(reduced, pivots, strict=True):
        inverse[pivot] = row[count:]
    backwards, _ = _whole_echelon([row[count:][::-1] for row in left], size)
    return inverse, [row[::-1] for row in backwards]


def _whole_echelon(rows: Sequence[list[int]], columns: int) -> tuple[list[list[int]], list[list[int]]]:
    """Row echelon form in the first columns by whole combinations that can be undone, and the rows that are 0 there."""
    left, done = list(rows), list[list[int]]()
    for column in range(columns):
        while some := [row for row in left if row[column]]:
            least = min(some, key=lambda row: abs(row[column]))
            left = [row if row is least else _less(row, least, row[column] // least[column]) for row in left]
            if len(some) == 1:
                done.append(least if least[column] > 0 else [-value for value in least])
                left = [row for row in left if row is not least]
    return done, left


def _reduce(rows: Sequence[Row], columns: int) -> tuple[list[Row], list[int]]:
    """Reduced row echelon form without its zero rows, and its pivot columns."""
    left, done, pivots = [row for row in rows if any(row)], list[Row](), list[int]()
    for column in range(columns):
        first = next((row for row in left if row[column]), None)
        if first is None:
            continue
        left = [row for row in left if row is not first]
        pivot = [value / first[column] for value in first]
        done = [_less(row, pivot, row[column]) for row in done] + [pivot]
        left = [row for row in (_less(row, pivot, row[column]) for row in left) if any(row)]
        pivots.append(column)
    return done, pivots


def _less(row: list[Exact], other: list[Exact], times: Exact) -> list[Exact]:
    return [a - times * b if b else a for a, b in zip(row, other, strict=True)] if times else row


def _dot(a: Row, b: Row) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True) if x and y), Fraction(0))


# speeds and torques ---------------------------------------------------------------------------------------------------

Motion = Mapping[str, Fraction]  # speed of every member in one admissible motion
UNBALANCED = Fraction(1, 10**6)  # torques written with six digits still balance; what is left is spread over them


@dataclass(frozen=True, slots=True, kw_only=True)
class Gearing:
    """One kind of mesh between two members: teeth_a (w_a - w_c) = -+ teeth_b (w_b - w_c), - external, + internal.

    pair : ``stages.main.meshes.sun-planet``; stage; a, b : members (``main.sun``); carrier : member or None.
    """

    pair: str
    stage: str
    a: str
    b: str
    teeth_a: int
    teeth_b: int
    internal: bool
    carrier: str | None

    @property
    def signed_b(self) -> int:
        """Teeth of b, negative of a ring: torques on a and b are in the ratio of teeth_a to this."""
        return -self.teeth_b if self.internal else self.teeth_b

    def equation(self, share: float = 1) -> dict[str, Any]:
        """Coefficients of the members: speeds fulfil it, and a torque per tooth acts on the members by them.

        share : of the torque on a per that on b, other than 1 with losses.
        """
        row: dict[str, Any] = {self.a: Fraction(self.teeth_a) * share, self.b: Fraction(self.signed_b)}
        if self.carrier is not None:
            row[self.carrier] = row.get(self.carrier, 0) - row[self.a] - row[self.b]
        return row


@dataclass(frozen=True, slots=True, kw_only=True)
class Tie:
    """Two members that turn at one speed: a coupling, a shaft, a neck."""

    name: str
    a: str
    b: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Kinematics:
    """Speeds, mesh frequencies, torques and power of all members.

    freedoms : members whose speeds determine all others (held members left out); none of a locked train.
    ratio : speed of each member per speed of each freedom, ratio[member][freedom], exact.
    speed : absolute speed of each member, exact [rev/min], or None where the file gives no (or too few) speeds.
    frame_speed : the same for each frame (stage name, ``housing``).
    mesh_frequency : of each stage (of each tone, see `tones`), exact [Hz], or None without speeds; positive, 0 where
        the stage turns as a block or stands.
    mesh_order : mesh_frequency per |speed| of the first freedom in rev/s (teeth per turn), exact, of each stage, where
        there is one freedom only.
    torque : external torque on each member incl. held and balancing ones [N m], None without torques.
    power : torque x absolute speed of each member [W], None without both.
    mesh_torque : of each pair (file path): torque its meshes put on member b, all branches and sides together [N m],
        or None.
    tie_torque : of each tie (its name): torque it puts on member b [N m], or None.
    held : members that do not turn.
    gearings, ties : the equations of meshes and couplings.
    stated : members whose external torque or power is given.
    reacting : members whose external torque follows: held ones and those that balance.
    """

    freedoms: tuple[str, ...]
    ratio: Mapping[str, Mapping[str, Fraction]]
    speed: Mapping[str, Fraction] | None = None
    frame_speed: Mapping[str, Fraction] | None = None
    mesh_frequency: Mapping[str, Fraction] | None = None
    mesh_order: Mapping[str, Fraction] = field(default_factory=dict)
    torque: Mapping[str, float] | None = None
    power: Mapping[str, float] | None = None
    mesh_torque: Mapping[str, float] | None = None
    tie_torque: Mapping[str, float] | None = None
    held: tuple[str, ...] = ()
    gearings: tuple[Gearing, ...] = ()
    ties: tuple[Tie, ...] = ()
    stated: tuple[str, ...] = ()
    reacting: tuple[str, ...] = ()

    @property
    def locked(self) -> bool:
        """Whether what is held leaves no rigid motion: all speeds are 0, and a torque only deforms the train."""
        return not self.freedoms

    def against(self, member: str | None, frame: str) -> Fraction:
        """Speed of a member, or of the housing, against a frame [rev/min]; 0 where the file gives no speeds."""
        return Fraction((self.speed or {}).get(member or "", 0)) - Fraction((self.frame_speed or {}).get(frame, 0))

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Couplings and shafts whose torque statics alone does not tell, as they lie on a closed path of their own."""
        rows = _equations(self.gearings, self.ties)
        matrix = [[row.get(name, Fraction(0)) for row in rows] for name in self.ratio]
        loops = null_space(matrix, range(len(rows))).values()
        return tuple(
            tie.name for at, tie in enumerate(self.ties, len(self.gearings)) if any(loop[at] for loop in loops)
        )

    def __repr__(self) -> str:
        """One line: freedoms, held members, number of members, mesh frequencies."""
        rates = ", ".join(f"{tone} {float(rate):.5g} Hz" for tone, rate in (self.mesh_frequency or {}).items())
        held = f", held {', '.join(self.held)}" if self.held else ""
        meshes = f", mesh frequency {rates}" if rates else ""
        freedoms = "locked" if self.locked else f"freedoms {', '.join(self.freedoms)}"
        return f"Kinematics({len(self.ratio)} members, {freedoms}{held}{'' if self.locked else meshes})"


def motions(kinematics: Kinematics, held: Sequence[str]) -> Mapping[str, Motion]:
    """Admissible motions of a train with other members held: freedom that turns once -> speed of every member [1]."""
    return _motions(tuple(kinematics.ratio), _equations(kinematics.gearings, kinematics.ties, held))


def solve_kinematics(
    *,
    members: Sequence[str],
    gearings: Sequence[Gearing],
    ties: Sequence[Tie] = (),
    held: Sequence[str] = (),
    speeds: Mapping[str, Fraction] | None = None,
    torques: Mapping[str, float] | None = None,
    powers: Mapping[str, float] | None = None,
    balance: Sequence[str] = (),
    carriers: Mapping[str, str | None] | None = None,
    ends: Sequence[str] = (),
) -> Kinematics:
    """Speeds, ratios, mesh frequencies, torques and power of a train.

    Speeds are exact: the null space of the mesh and tie equations.  External torques tau (given ones, reactions of held
    members, balancing ends) satisfy tau . v = 0 for every motion v that is admissible with nothing held.  Torques of
    the meshes follow from tau + A^T lambda = 0 with A the mesh and tie equations.  Where a loop or a redundant hold
    makes them statically indeterminate, the solution of least norm (sum of lambda^2, the lambda of a mesh being its
    torque per tooth) replaces that of the unknown stiffnesses.

    A train that is locked, of which what is held leaves no motion, is taken where torques load members that are not
    held: a park lock, a bench test.  All its speeds are 0.

    members : every member and body once.  gearings, ties : equations of meshes and couplings.  held : members at rest.
    speeds : given absolute speeds [rev/min].  torques : given external torques [N m].
    powers : given external power, into the train positive [W].  balance : members whose torque balances the others.
    carriers : carrier of each stage, None where its axes are at rest; the stages of `gearings` need no entry.
    ends : members at which torque may enter or leave (no planets); one that is neither held, tied nor loaded balances
        where `balance` is empty.

    Raises
    ------
    ModelError : locked train without a torque, with a speed or with a balance (of a stage whose planets
        have no carrier: the table that is missing), too few, too many or contradicting speeds, power at a member at
        rest, torques that do not balance, or several ends that could balance them.
    """
    speeds, torques, powers = dict(speeds or {}), dict(torques or {}), dict(powers or {})
    rows = _equations(gearings, ties)
    preferred = [*speeds, *(m for m in ends if m not in speeds)]
    motions = _motions(members, _equations(gearings, ties, held), preferred)
    if not motions and (not torques or any(speeds.values()) or not _motions(members, rows)):
        raise _locked(members, gearings, ties, held, ends)
    if not motions and balance:
        path = f"operation.torque.{balance[0]}"
        allowed = "a torque in N m, or no key: the held members take the balance"
        raise ModelError("nothing is to be balanced, the train is locked", path=path, given="balance", allowed=allowed)
    speed = _speeds(motions, speeds, held) if motions else dict.fromkeys(members, Fraction(0))
    loads = _loads(torques, powers, speed, held)
    coupled = {name for tie in ties for name in (tie.a, tie.b)}
    ratio = {name: {end: motion[name] for end, motion in motions.items()} for name in members}
    names = tones(gearings, ratio)
    frames = {g.stage: g.carrier for g in gearings} | dict(carriers or {})
    turns = {} if speed is None else {stage: speed[c] if c is not None else Fraction(0) for stage, c in frames.items()}
    found = _external_torques(members, rows, motions, loads, held, balance, ends, coupled) if loads else None
    torque, reacting = (None, ()) if found is None else found
    inner = None if torque is None else _internal_torques(gearings, ties, torque)
    return Kinematics(
        freedoms=tuple(motions),
        ratio=ratio,
        speed=speed,
        frame_speed=None if speed is None else turns | {"housing": Fraction(0)},
        mesh_frequency=None if speed is None else _tooth_rates(gearings, names, speed, 60),
        mesh_order=_tooth_rates(gearings, names, next(iter(motions.values()))) if len(motions) == 1 else {},
        torque=None if torque is None else {name: float(torque[name]) for name in members},
        power=None if torque is None or speed is None else {m: watts(torque[m], speed[m]) for m in members},
        mesh_torque=None if inner is None else inner[0],
        tie_torque=None if inner is None else inner[1],
        held=tuple(held),
        gearings=tuple(gearings),
        ties=tuple(ties),
        stated=tuple(loads),
        reacting=reacting,
    )


def tones(gearings: Sequence[Gearing], ratio: Mapping[str, Mapping[str, Fraction]]) -> dict[str, str]:
    """Name of the mesh frequency of every pair: its stage, or ``stage/pair`` for a further one behind a stepped shaft.

    ratio : speed of each member per speed of each freedom (`Kinematics.ratio`); pairs of a stage share a tone where
        teeth x relative speed agree for every freedom.
    """
    named: dict[str, str] = {}
    rates: dict[tuple[str, tuple[Fraction, ...]], str] = {}
    for g in gearings:
        frame = ratio[g.carrier] if g.carrier is not None else {}
        rate = tuple(g.teeth_a * (value - frame.get(end, 0)) for end, value in ratio[g.a].items())
        leading = next((value for value in rate if value), Fraction(0))
        key = (g.stage, tuple(-value for value in rate) if leading < 0 else rate)
        fresh = g.stage if g.stage not in rates.values() else f"{g.stage}/{g.pair.rsplit('.', 1)[-1]}"
        named[g.pair] = rates.setdefault(key, fresh)
    return named


def _equations(gearings: Iterable[Gearing], ties: Iterable[Tie], held: Iterable[str] = ()) -> list[dict[str, Fraction]]:
    """What the speeds must fulfil: meshes, ties, then members at rest, each as coefficients of the members.

    Of a mesh teeth_a (w_a - w_c) +- teeth_b (w_b - w_c) = 0, + external, - internal.
    """
    rows = [*(g.equation() for g in gearings), *({tie.a: Fraction(1), tie.b: Fraction(-1)} for tie in ties)]
    return [*rows, *({name: Fraction(1)} for name in held)]


def _motions(
    members: Sequence[str], rows: Sequence[Mapping[str, Fraction]], preferred: Sequence[str] = ()
) -> dict[str, dict[str, Fraction]]:
    """Admissible motions, by the freedom that turns once while the others are at rest; preferred freedoms first."""
    return _motions_of(tuple(members), tuple(tuple(row.items()) for row in rows), tuple(preferred))


@lru_cache(maxsize=64)  # a lever, a study and a tolerance change other numbers than teeth
def _motions_of(
    members: tuple[str, ...], rows: tuple[tuple[tuple[str, Fraction], ...], ...], preferred: tuple[str, ...]
) -> dict[str, dict[str, Fraction]]:
    matrix = [[row.get(name, Fraction(0)) for name in members] for row in map(dict, rows)]
    rest = [name for name in members if name not in preferred]
    order = [members.index(name) for name in [*rest, *reversed(preferred)]]
    vectors = null_space(matrix, order)
    return {members[j]: dict(zip(members, vectors[j], strict=True)) for j in reversed(order) if j in vectors}


def _locked(
    members: Sequence[str],
    gearings: Sequence[Gearing],
    ties: Sequence[Tie],
    held: Sequence[str],
    ends: Sequence[str],
) -> ModelError:
    """What to say of a train in which no member can turn: the carriers that would free it, else what is held."""
    planets = set(members) - set(ends or members)
    still = {g.stage: f"stages.{g.stage}.carrier" for g in gearings if g.carrier is None and {g.a, g.b} & planets}
    freed = [replace(g, carrier=still[g.stage]) if g.carrier is None and {g.a, g.b} & planets else g for g in gearings]
    if still and _motions([*members, *still.values()], _equations(freed, ties, held)):
        return ModelError(
            "no member can turn: without a carrier table the axes of the planets stand still",
            path=next(iter(still.values())),
            allowed=f"the table{'s' * (len(still) > 1)} {', '.join(f'[{path}]' for path in still.values())}, "
            "or fewer members in operation.held",
        )
    return ModelError(
        "the train is locked, no member can turn",
        path="operation.held",
        given=list(held),
        allowed="fewer held members, and teeth whose ratios agree around every loop; or, of a train that is locked on "
        "purpose, a torque on a member that is not held, and no speed",
    )


def _speeds(
    motions: Mapping[str, Motion], given: Mapping[str, Fraction], held: Sequence[str]
) -> dict[str, Fraction] | None:
    """Speed of every member [rev/min], None where none is given."""
    for name in given:
        path = f"operation.speed.{name}"
        if name in held and given[name]:
            raise ModelError(
                "a held member does not turn", path=path, given=_rpm(given[name]), allowed="0, or no speed"
            )
        if name not in motions and name not in held:
            follows = sum((m[name] * given.get(end, 0) for end, m in motions.items()), Fraction(0))
            raise ModelError("follows from the other speeds", path=path, given=_rpm(given[name]), allowed=_rpm(follows))
    given_freedoms = [name for name in given if name in motions]
    if not given_freedoms:
        return None
    if len(given_freedoms) < len(motions):
        other = ", ".join(end for end in motions if end not in given)
        problem = f"the train has {len(motions)} freedoms, that many speeds are needed"
        raise ModelError(problem, path="operation.speed", given=given_freedoms, allowed=f"also the speed of {other}")
    return {
        name: sum((m[name] * given[end] for end, m in motions.items()), Fraction(0))
        for name in next(iter(motions.values()))
    }


def _tooth_rates(
    gearings: Sequence[Gearing], names: Mapping[str, str], speed: Motion, unit: int = 1
) -> dict[str, Fraction]:
    """Mesh frequency of every tone: teeth per `unit` of the time in which `speed` counts turns."""
    frames = {g.pair: speed[g.carrier] if g.carrier is not None else Fraction(0) for g in gearings}
    return {names[g.pair]: abs(g.teeth_a * (speed[g.a] - frames[g.pair])) / unit for g in gearings}


def _loads(
    torques: Mapping[str, float], powers: Mapping[str, float], speed: Motion | None, held: Sequence[str]
) -> dict[str, Fraction]:
    """Given external torques, exact [N m]; a power is divided by the speed of its member."""
    loads: dict[str, Fraction] = {}
    for key, given in (("torque", torques), ("power", powers)):
        for name, value in given.items():
            path = f"operation.{key}.{name}"
            if name in held:
                raise ModelError("a held member takes what it must", path=path, given=value, allowed="members not held")
            if name in loads:
                raise ModelError("torque and power of one member", path=path, given=value, allowed="one of the two")
            if key == "power" and (speed is None or not speed[name]):
                state = "its speed is not known" if speed is None else "it does not turn"
                raise ModelError(
                    f"no torque follows from this power, {state}", path=path, given=value, allowed="a torque"
                )
            loads[name] = Fraction(value) if key == "torque" else Fraction(value / watts(1, (speed or {})[name]))
    return loads


def _external_torques(
    members: Sequence[str],
    rows: Sequence[Mapping[str, Fraction]],
    motions: Mapping[str, Motion],
    loads: Mapping[str, Fraction],
    held: Sequence[str],
    balance: Sequence[str],
    ends: Sequence[str],
    coupled: Iterable[str],
) -> tuple[dict[str, Fraction], tuple[str, ...]]:
    """External torque on every member in equilibrium exactly [N m], and the members whose torque follows.

    Raises
    ------
    ModelError : torques that do not balance, or several ends that could balance them.
    """
    free = list(_motions(members, rows).values())
    missing = {end: -_work(loads, motion) for end, motion in motions.items()}
    work = (abs(value * motion[name]) for motion in motions.values() for name, value in loads.items())
    scale = max(work, default=Fraction(0))  # a locked train has no motion: what is held takes all
    balanced = all(abs(value) <= UNBALANCED * scale for value in missing.values())
    sums = ", ".join(f"{float(value):.6g} N m at {end}" for end, value in missing.items())
    balancing = list(dict.fromkeys(balance))
    if len(balancing) > len(motions):
        taken = " and ".join(balancing[: len(motions)])
        path, allowed = f"operation.torque.{balancing[-1]}", "one balance for each freedom of the train"
        raise ModelError(f"{taken} takes it already", path=path, given="balance", allowed=allowed)
    if not balancing and not balanced:
        # the free ends take the balance, if they are no more than the freedoms
        idle = [name for name in ends if name not in held and name not in loads]
        balancing = [name for name in idle if name not in coupled]
        if idle and not 0 < len(balancing) <= len(motions):
            raise ModelError(
                f"which end takes the balance is not clear, the torques need further {sums}",
                path="operation.torque",
                given={name: float(value) for name, value in loads.items()},
                allowed=f'"balance" at one of {", ".join(balancing or idle)}',
            )
    unknown = [*held, *(name for name in balancing if name not in held)]
    found = _reactions(free, loads, unknown)
    if found is None and balanced:
        spread = _reactions(list(motions.values()), loads, list(loads)) or {}
        loads = {name: value + spread[name] for name, value in loads.items()}
        found = _reactions(free, loads, unknown)
    if found is None:
        raise ModelError(
            f"the torques do not balance, they need further {sums}",
            path="operation.torque",
            given={name: float(value) for name, value in loads.items()},
            allowed=f'torques in equilibrium, or "balance" at {len(motions)} of {", ".join(ends or members)}',
        )
    torque = {name: loads.get(name, Fraction(0)) + found.get(name, Fraction(0)) for name in members}
    return torque, tuple(unknown)


def _reactions(
    motions: Sequence[Motion], loads: Mapping[str, Fraction], unknown: Sequence[str]
) -> dict[str, Fraction] | None:
    """Torques of the unknown members that make the virtual power of every motion zero, None where there are none."""
    matrix = [[motion[name] for name in unknown] for motion in motions]
    found = least_norm(matrix, [-_work(loads, motion) for motion in motions])
    return None if found is None else dict(zip(unknown, found, strict=True))


def _work(loads: Mapping[str, Fraction], motion: Motion) -> Fraction:
    return sum((value * motion[name] for name, value in loads.items()), Fraction(0))


def _internal_torques(
    gearings: Sequence[Gearing], ties: Sequence[Tie], torque: Mapping[str, Fraction]
) -> tuple[dict[str, float], dict[str, float]]:
    """Torque of each pair's meshes and of each tie on its member b [N m], from tau + A^T lambda = 0."""
    rows = _equations(gearings, ties)
    matrix = [[row.get(name, Fraction(0)) for row in rows] for name in torque]
    found = (least_norm(matrix, [-value for value in torque.values()]) if rows else None) or []
    ends = [*(g.b for g in gearings), *(tie.b for tie in ties)]
    values = [float(row[end] * value) for row, end, value in zip(rows, ends, found, strict=False)]
    meshes, tied = values[: len(gearings)], values[len(gearings) :]
    return (
        {g.pair: value for g, value in zip(gearings, meshes, strict=False)},
        {tie.name: value for tie, value in zip(ties, tied, strict=False)},
    )


def watts(torque: Fraction | float, speed: Fraction) -> float:
    """Power [W] of a torque [N m] at a speed [rev/min]."""
    return float(torque * speed) * math.tau / 60


def _rpm(speed: Fraction) -> str:
    return f"{float(speed):.12g} rpm"
