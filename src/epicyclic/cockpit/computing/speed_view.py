"""Modes as the page lists and animates them, and largest mesh forces over speed, with the orders that meet modes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...limits import RESONANCE_BAND, peak_matters
from ...questions.modes.campbell import OPERATION, MeshCrossings, mesh_crossings, tones_of_meshes
from ...questions.modes.eigen import classify_modes, mean_modes, normalisation
from ...questions.modes.modal import bending_energy
from ...questions.response import SweepOptions
from ...questions.response.measures import force_extremes, mean
from ...questions.response.response import Response, respond_part, response, response_parts, unstable_speeds
from ...questions.response.spectra import force_signal, mesh_tones, whole_mesh_signal
from ...questions.response.sweep_table import of_one_tone, resonance_forces, speeds_of
from ...results.dataset import largest, ranked
from ...show.series import ring_deflection
from ...statics.tangent import linear
from ...system.system import Array, System, faces
from ...train.train import Train
from ..state.frames import SpeedAxis, force_unit, member_words, number, ordinal

# A list of more modes is read by nobody, and their shapes would be most of the message.
_MOST = 60
# Share of the kinetic energy from which a member is named beside the one that moves most, and share of the largest
# motion of a branch from which a branch takes part.
_NAMED, _TAKES_PART = 0.25, 0.3
# Motions in words, of one body and of several: x, y, z, tilt, rotation, bending.
_ALL = (("slides along the axis", "slide along the axis"), ("tilts", "tilt"), ("rotates", "rotate"), ("bends", "bend"))
_ROUND = np.linspace(0.0, 2 * np.pi, 96, endpoint=False)  # places of a ring that bends
_CENTRAL = (("moves sideways", "move sideways"),) * 2 + _ALL
_CARRIED = (("moves radially", "move radially"), ("moves tangentially", "move tangentially"), *_ALL)
_ROTATES = 4


class ModeView(NamedTuple):
    """Elastic modes, at most 60, the lowest first.

    number : (m,) of each among all modes of the verb `modes`, from 1.  frequency : (m,) [Hz].
    shape : (m, nb, 6) x, y, z and rx, ry, rz times the pitch radius, in the axes of the stage, largest component 1.
    mass : (nb, 6) of these motions [kg], by which shapes of one train are orthogonal; 1 where not given.
    bends : names of the coordinates by which bodies bend, in the order of the bodies; bent : (m, e) of these, in the
    unit of the shape; bent_mass : (e,) [kg], without what couples them where a ring stretches.
    label : what moves.  kind : rotational, translational, planet, ring or mixed.  body : the one that moves most.
    damping : (m,) damping ratio [1], nan where not given.  crossings : speeds at which mesh orders meet them, of all
    modes; within 20 % of the speed that is shown those of orders that excite the mode, or where that is not known.
    force_ratio : (c,) largest force of the mode per mean mesh force there [1], nan where not known, and farther away.
    at_rest : how many others there are.
    """

    number: NDArray[np.int64]
    frequency: Array
    shape: Array
    mass: Array
    bends: tuple[str, ...]
    bent: Array
    bent_mass: Array
    label: tuple[str, ...]
    kind: tuple[str, ...]
    body: tuple[str, ...]
    crossings: MeshCrossings
    force_ratio: Array
    at_rest: int
    tones: Mapping[Fraction, Sequence[str]]

    @property
    def of_number(self) -> dict[int, int]:
        """Place of a mode in the list by its number."""
        return {int(number): place for place, number in enumerate(self.number)}

    def rows(self, axis: SpeedAxis | None, relative_speed: float, stages: int) -> list[dict[str, Any]]:
        """``head["modes"]`` of a frame, at a speed per operating speed [1]."""
        met = self._met(axis, relative_speed, stages)
        return [
            {
                "index": int(self.number[i]),
                "frequency": float(self.frequency[i]),
                "label": self.label[i],
                "body": self.body[i],
                "kind": self.kind[i],
                "met_by": met.get(int(self.number[i]), ""),
            }
            for i in range(len(self.frequency))
        ]

    def _met(self, axis: SpeedAxis | None, relative_speed: float, stages: int) -> dict[int, str]:
        """Number of a mode -> the order that meets it nearest to a speed, within 20 % of that."""
        crossings, nearest = self.crossings, dict[int, tuple[float, str]]()
        tones = list(self.tones.values())
        for i, speed in enumerate(crossings.relative_speed):
            away = abs(speed / relative_speed - 1)
            if away > RESONANCE_BAND or axis is None:
                continue
            where = f" of {' and '.join(tones[crossings.tone[i]])}" if stages > 1 else ""
            text = f"{ordinal(int(crossings.order[i]))} mesh order{where} at {number(speed * axis[1])} rpm"
            first = int(crossings.mode[i]) + 1
            for mode in range(first, first + int(crossings.count[i])):
                if mode not in nearest or away < nearest[mode][0]:
                    nearest[mode] = away, text
        return {mode: text for mode, (_, text) in nearest.items()}


def mode_view(
    train: Train,
    system: System,
    labels: Mapping[str, str],
    *,
    relative_speed: float = 1.0,
) -> ModeView:
    """Elastic modes of the undamped mean system at standstill.

    Parameters
    ----------
    labels : of the bodies.  relative_speed : that is shown, per operating speed [1].

    Raises
    ------
    ModelError : a mass or inertia is missing, or the mean system is statically unstable.
    """
    system = linear(system)
    squared, vectors = mean_modes(system)
    kinds = classify_modes(system, squared, vectors)
    elastic = np.flatnonzero(squared > 0)[:_MOST]
    shapes = kinds.vectors[:, elastic]
    shapes = shapes * normalisation(shapes, system.dofs.radius)
    full = (system.dofs.rigid @ shapes).reshape(len(system.dofs.bodies), 6, -1).transpose(2, 0, 1)
    first = 6 * len(system.dofs.bodies)
    bent, bent_mass = (system.dofs.expand[first:] @ shapes).T, np.diag(system.bent_mass)[first:]
    label, body = _labels(train, system, full, bending_energy(system, shapes), labels)
    radius = _radii(train)
    frequency = np.sqrt(squared) / (2 * np.pi)
    shape, bent = _drawn(train, system, full, bent, radius)
    kind = tuple(kinds.kind[i] for i in elastic)
    mass = _masses(system, full) / np.repeat([np.ones_like(radius), radius**2], 3, axis=0).T
    met = _crossings(system, frequency, np.real(kinds.vectors), relative_speed)
    bends = tuple(f"{system.dofs.bodies[body]}/{name}" for body, names in system.dofs.elastic for name in names)
    shown = elastic + 1, frequency[elastic], shape, mass, bends, bent, bent_mass
    return ModeView(*shown, label, kind, body, *met, tones_of_meshes(system))


def _crossings(
    system: System, frequency: Array, shapes: Array, relative_speed: float
) -> tuple[MeshCrossings, Array, int]:
    """Crossings about operation and within the band about a speed, there without those whose order leaves the mode at
    rest; the forces of the modes in the band per mean mesh force (c,) [1]; and how many are left out.

    frequency : (n,) of all modes [Hz].  shapes : (n, n).
    """
    low = min(OPERATION[0], (1 - RESONANCE_BAND) * relative_speed)
    high = max(OPERATION[1], (1 + RESONANCE_BAND) * relative_speed)
    crossings = mesh_crossings(frequency, [float(tone) for tone in tones_of_meshes(system)], low=low, high=high)
    near = np.abs(crossings.relative_speed / relative_speed - 1) <= RESONANCE_BAND
    forces = resonance_forces(system, crossings.chosen(near), shapes, tolerance=_REST)
    kept, ratio = np.ones(len(crossings.mode), dtype=bool), np.full(len(crossings.mode), np.nan)
    kept[near], ratio[near] = forces["excited"] != "no", forces["force_ratio"]
    return crossings.chosen(kept), ratio[kept], int((~kept).sum())


def _radii(train: Train) -> Array:
    """Radius (nb,) by which a rotation of each body is drawn [m]: its pitch circle, of a carrier that of its pins."""
    pins = {body.carried_by: float(np.hypot(*body.centre)) for body in train.bodies if body.carried_by}
    pitch = [body.gear.reference_radius if body.gear is not None else pins.get(body.name, 0.0) for body in train.bodies]
    usual = 0.25 * (max(pitch, default=0.0) or 1.0)
    return np.array([r if np.isfinite(r) and r > 0 else usual for r in pitch])


def _masses(system: System, full: Array) -> Array:
    """Masses and inertias (nb, 6) [kg, kg m^2] of the motions of shapes (m, nb, 6); 1 where they are not given."""
    return system.body_mass if system.body_mass.shape == full.shape[1:] else np.ones(full.shape[1:])


def _drawn(train: Train, system: System, full: Array, bent: Array, radius: Array) -> tuple[Array, Array]:
    """Shapes (m, nb, 6) in the axes of the stage, rotations as lengths, and (m, e) of what bends; largest motion 1.

    full : (m, nb, 6) in each body's own axes [m, rad].  bent : (m, e) [m].  radius : (nb,) of the rotations [m].
    """
    angle = np.array([body.angle for body in train.bodies])
    cosine, sine = np.cos(angle), np.sin(angle)
    shape = np.array(full)
    for x, y in ((0, 1), (3, 4)):
        shape[..., x] = cosine * full[..., x] - sine * full[..., y]
        shape[..., y] = sine * full[..., x] + cosine * full[..., y]
    shape[..., 3:] *= radius[:, None]
    most, last = np.abs(shape).max(axis=(1, 2), initial=0.0), 0
    for body, names in system.dofs.elastic:
        if train.bodies[body].elastic is not None:
            moved = ring_deflection(names, _ROUND) @ bent[:, last : last + len(names)].T
            most = np.maximum(most, np.hypot(*moved).max(axis=0))
        last += len(names)
    scale = 1 / np.where(most > 0, most, 1.0)
    return shape * scale[:, None, None], bent * scale[:, None]


def _labels(
    train: Train, system: System, full: Array, bending: Mapping[int, Array], labels: Mapping[str, str]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What moves in each mode, and the body that moves most, by kinetic energy; of shapes (m, nb, 6).

    bending : (m,) that of the bending of each body that bends, by its index.
    """
    energy = np.pad(full**2 * _masses(system, full), ((0, 0), (0, 0), (0, 1)))
    for place, bent in bending.items():
        energy[:, place, 6] = bent
    total = energy.sum(axis=(1, 2), keepdims=True)
    energy = energy / np.where(total > 0, total, 1.0)
    members = list(dict.fromkeys(body.member for body in train.bodies))
    member_of_body = np.array([members.index(body.member) for body in train.bodies])
    member_sum = (member_of_body == np.arange(len(members))[:, None]).astype(float)
    by_member = np.einsum("kb,mbd->mkd", member_sum, energy)
    tilting = by_member[..., 3:5].sum(axis=2, keepdims=True)
    motions = np.concatenate([by_member[..., :3], tilting, by_member[..., 5:]], axis=2)
    # a member about the axis has no radial and tangential of its own
    central = np.array([all(b.branch is None for b in train.bodies if b.member == member) for member in members])
    motions[:, central, 0] += motions[:, central, 1]
    motions[:, central, 1] = 0.0
    of_body = energy.sum(axis=2)
    member = {body.name: body.member for body in train.bodies}
    meshing = {frozenset((member[mesh.a], member[mesh.b])) for mesh in train.meshes}
    words = [_Movement(train, members, central, motions[i], of_body[i]).sentence(meshing) for i in range(len(full))]
    names = [labels[body.name] for body in train.bodies]
    return tuple(words), tuple(names[largest(shares)] for shares in of_body)


class _Movement(NamedTuple):
    """Shares of the kinetic energy of one mode.

    central : (members,) which turn about the axis.  shares : (members, motions).  of_body : (nb,).
    """

    train: Train
    members: Sequence[str]
    central: NDArray[np.bool_]
    shares: Array
    of_body: Array

    def subject(self, member: int) -> tuple[str, bool]:
        """A member in words, its branches numbered where not all take part; and whether it is several bodies."""
        name = self.members[member]
        branches: dict[int, float] = {}
        for energy, body in zip(self.of_body, self.train.bodies, strict=True):
            if body.member == name and body.branch is not None:
                branches[body.branch] = branches.get(body.branch, 0.0) + float(energy)
        # energies are squares of motions
        least = _TAKES_PART**2 * max(branches.values(), default=0.0)
        moving = sorted(branch for branch, value in branches.items() if value >= least)
        return member_words(self.train, name, moving), len(moving) > 1

    def clause(self, member: int) -> str:
        """A member and the motion with most of its energy: ``planets 1, 3 move radially``."""
        subject, many = self.subject(member)
        verbs = _CENTRAL if self.central[member] else _CARRIED
        return f"{subject} {verbs[largest(self.shares[member])][many]}"

    def sentence(self, meshing: set[frozenset[str]]) -> str:
        """What moves: the member with most kinetic energy, and one beside it with a quarter or more."""
        shares = self.shares.sum(axis=1)
        first, *others = (int(i) for i in ranked(shares)[:2])
        text, motion = self.clause(first), largest(self.shares[first])
        for other in others:
            if shares[other] < _NAMED:
                continue
            if largest(self.shares[other]) != motion:
                text += f", {self.clause(other)}"
            else:
                against = motion == _ROTATES and frozenset((self.members[first], self.members[other])) in meshing
                text += f" {'against' if against else 'with'} the {self.subject(other)[0]}"
        return text


# Residual per tolerance that is accepted, as of the verb `sweep`.
_ACCEPTED = 100.0
# Speeds while a lever moves, at rest and with shaft orders, by the number of mesh frequencies that combine: with two
# a speed takes 2 ms and with shaft orders 20 ms.
_POINTS = {1: (120, 200, 60), 2: (48, 120, 60), 3: (120, 200, 0)}
# Speeds times coordinates while a lever moves, in 15 to 25 ms, and speeds at the least.
_AT_ONCE, _FEWEST = 4000, 48
# Tolerance at rest, and of forces at resonances: no mode of a ready drive becomes excited by it, or not.
_REST = 4e-5
# Mesh frequencies that are solved together: with three a speed takes half a second, and they are solved one at a time.
_TOGETHER = 2
# Curves that are drawn strong: more are not told apart.  Curves that differ by less than this part of the largest
# force are one to the eye.
_STRONG, _ALIKE = 4, 2e-3
# More labels of peaks than these cover the curve.
_PEAKS = 8
# Distance of a peak from the speed of its mode, per speed, as far as varying stiffness and gyroscopic terms move it;
# and what an order counts against a lower one, so that of two modes at one place the more strongly excited is named.
_NEAR, _PER_ORDER = 0.03, 0.002


class Effort(NamedTuple):
    """How a curve is computed.  points : speeds.  shaft_orders : whether they count.  tolerance : residual [1]."""

    points: int
    shaft_orders: bool
    tolerance: float


class ForceCurves(NamedTuple):
    """Largest force of w whole meshes at P speeds.

    speed : (P,) per operating speed [1], rising.  force : (w, P) [N], nan where there is no solution.
    shaft_orders : whether they count.  alone : whether the mesh orders of one stage at a time were solved.
    """

    speed: Array
    force: Array
    shaft_orders: bool
    alone: bool


class SpeedModel(NamedTuple):
    """A train ready for its curves.

    whole : all mesh frequencies together, which gives the speeds.  solved : what is solved, `whole` itself or, with
    three mesh frequencies and more that combine, one Response of each alone.
    """

    whole: Response
    solved: tuple[Response, ...]


def speed_model(system: System) -> SpeedModel:
    """A System ready for its curves.

    Raises
    ------
    ModelError : no damping, no mesh frequency, or torques that do not balance.
    """
    whole = response(system)
    tones = whole.lines.tones
    if len(tones) <= _TOGETHER or not whole.system.meshes.variation.any():
        return SpeedModel(whole, (whole,))
    alone = []
    for tone in mesh_tones(system):
        rows = np.array([system.tones[i] == tone for i in system.meshes.tone])
        alone.append(response(of_one_tone(system, tone, rows)))
    return SpeedModel(whole, tuple(alone))


def efforts(model: SpeedModel) -> list[Effort]:
    """How the curves of a train are computed: while a lever moves, at rest, and, where it has any, with shaft orders.

    A tolerance of 1e-4 moves no force by more than 0.4 % (ready drives), what a pixel is; at rest it is 0.04 %.
    """
    combined = len(model.whole.lines.tones) if model.whole.system.meshes.variation.any() else 1
    live, full, shafts = _POINTS[min(combined, _TOGETHER + 1)]
    live = min(live, max(_FEWEST, _AT_ONCE // model.whole.modal.squared.size))
    steps = [Effort(live, False, 1e-4), Effort(full, False, _REST)]
    if shafts and model.whole.lines.shaft:
        steps.append(Effort(shafts, True, _REST))
    return steps


def force_curves(model: SpeedModel, effort: Effort, *, pause: Callable[[], None] = lambda: None) -> ForceCurves:
    """Largest mesh forces about operation, the numbers of the verb `sweep` at its default speeds but for the tolerance.

    Where the mesh frequencies are solved one at a time, the largest force is the mean and what each adds to it: an
    upper bound but for the combinations of mesh frequencies.  Speeds without a steady motion hold nan.

    Parameters
    ----------
    pause : called between parts of the work; what it raises ends the work.
    """
    whole = model.whole
    speed = speeds_of(whole, SweepOptions(points=effort.points))
    stable = np.flatnonzero(~unstable_speeds(whole, speed))
    force = np.full((len(faces(whole.system.meshes).name), speed.size), np.nan)
    for tone, ready in enumerate(model.solved):
        largest, average = _solved(ready, speed[stable], effort, pause)
        force[:, stable] = largest if tone == 0 else force[:, stable] + largest - average
    return ForceCurves(speed=speed, force=force, shaft_orders=effort.shaft_orders, alone=len(model.solved) > 1)


def _solved(ready: Response, speed: Array, effort: Effort, pause: Callable[[], None]) -> tuple[Array, Array]:
    """Largest and mean force (w, P) [N] of the whole meshes at relative speeds (P,), nan where not solved."""
    face = faces(ready.system.meshes)
    largest, average = (np.full((len(face.name), speed.size), np.nan) for _ in range(2))
    accepted = _ACCEPTED * effort.tolerance
    for part in response_parts(ready, speed, shaft_orders=effort.shaft_orders):
        for block in respond_part(ready, speed, part, tolerance=effort.tolerance, shaft_orders=effort.shaft_orders):
            with np.errstate(all="ignore"):  # a point that overflows is not finite, beside the others
                signal = whole_mesh_signal(force_signal(ready, block), face)
                most = force_extremes(signal, axis=ready.lines.axis[face.first])[1]
                middle = mean(signal)
            pause()
            good = (block.residual <= accepted) & (block.uncertainty <= accepted)
            largest[:, block.index] = np.where(good, most, np.nan)
            average[:, block.index] = np.where(good, middle, np.nan)
    return largest, average


def speed_head(
    curves: ForceCurves, axis: SpeedAxis, modes: ModeView | None, labels: Sequence[str]
) -> tuple[dict[str, Any], dict[str, NDArray[np.float64]]]:
    """``head["sweep"]`` and the arrays ``x`` (P,) and ``y`` (w, P) in its units.

    labels : (w,) of the meshes.
    """
    label, operating = axis
    unit, scale = force_unit(float(np.nanmax(curves.force, initial=0.0)))
    alike = Counter(_strong(curves.force).values())
    head = {
        "x_label": label,
        "y_label": f"largest mesh force [{unit}]",
        "operating": operating,
        "stage": "with shaft orders"
        if curves.shaft_orders
        else f"mesh orders{' of one stage at a time' * curves.alone}",
        "curves": [
            {
                "label": name + (f" and {alike[row] - 1} alike" if alike[row] > 1 else ""),
                "mesh": row,
                "strong": row in alike,
            }
            for row, name in enumerate(labels)
        ],
        "peaks": _peaks(curves, operating, scale, modes),
        "range": [OPERATION[0] * operating, OPERATION[1] * operating],
        "to_relative": 1 / operating,
    }
    return head, {"x": curves.speed * operating, "y": curves.force * scale}


def _strong(force: Array) -> dict[int, int]:
    """Row -> the curve drawn strong that stands for it, of forces (w, P): those with the largest, each look once."""
    most = np.max(np.where(np.isnan(force), -np.inf, force), axis=1, initial=-np.inf)
    # rounding does not choose among equal branches: those that are one to the eye come in their own order
    step = _ALIKE * max(float(np.max(np.abs(most[np.isfinite(most)]), initial=0.0)), 1e-300)
    standing: dict[int, int] = {}
    chosen: list[int] = []
    for row in np.lexsort((np.arange(len(most)), -np.round(most / step))) if len(most) else []:
        if not np.isfinite(most[row]):
            continue
        apart = np.abs(force[chosen] - force[row])  # curves are alike that lie on each other where both are known
        distance = np.max(np.where(np.isfinite(apart), apart, -np.inf), axis=1, initial=-np.inf)
        alike = np.flatnonzero(np.isfinite(distance) & (distance <= step))
        if alike.size:
            standing[int(row)] = chosen[alike[0]]
        elif len(chosen) < _STRONG:
            chosen.append(int(row))
            standing[int(row)] = int(row)
    return standing


def _peaks(curves: ForceCurves, operating: float, scale: float, modes: ModeView | None) -> list[dict[str, Any]]:
    """The highest peaks of the largest force of any mesh that matter, with the mode and order that meet there."""
    from scipy.signal import find_peaks  # a third of the start of a computing process

    known = np.isfinite(curves.force).any(axis=0)
    speed = curves.speed[known]
    if speed.size < 3:
        return []
    most = np.nanmax(curves.force[:, known], axis=0)
    places, properties = find_peaks(most, prominence=0.0)
    rise = properties["prominences"]
    named = peak_matters(most[places], rise)
    highest = places[named][np.argsort(-rise[named], kind="stable")[:_PEAKS]]
    return [
        {"x": float(speed[i] * operating), "y": float(most[i] * scale), **_met(float(speed[i]), modes)}
        for i in sorted(highest.tolist())
    ]


def _met(speed: float, modes: ModeView | None) -> dict[str, Any]:
    """Label of the mode that a mesh order meets nearest to a speed per operating speed [1], its number, and how many
    modes of its frequency there are."""
    nothing = {"label": "", "mode": None, "count": 0, "text": ""}
    if modes is None or not modes.crossings.relative_speed.size:
        return nothing
    crossings = modes.crossings
    away = np.abs(crossings.relative_speed / speed - 1)
    cost = np.where(away <= _NEAR, away + _PER_ORDER * crossings.order, np.inf)
    best = int(cost.argmin())
    if not np.isfinite(cost[best]):
        return nothing
    mode, order = int(crossings.mode[best]) + 1, f"{ordinal(int(crossings.order[best]))} order"
    met = {"mode": mode, "count": int(crossings.count[best])}
    text, place = f"{order} meets mode {mode}", modes.of_number.get(mode)
    if place is None:
        return {"label": order, "text": text, **met}
    label = f"{number(float(modes.frequency[place]), 4)} Hz, {order}"
    return {"label": label, "text": f"{text}: {modes.label[place]}", **met}
