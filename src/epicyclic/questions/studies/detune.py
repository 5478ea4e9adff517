"""What moves a resonance away from operation: changes of the drawing, each computed again on the changed train.

A resonance is a mesh order that meets a mode.  Lengths, masses and stiffnesses p move its natural frequency, f ~ p^S,
which gives the first size of a change; tooth counts with a module that keeps the centre distance move the mesh
frequency.  What a change gives is computed on the changed train, where its mode is found again by its shape.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...document.tables import leaves
from ...engine.points import Outcome, outcomes
from ...errors import ConvergenceError, ModelError
from ...limits import NO_MATTER, SAME_SHAPE, ResonanceVerdict
from ...options import Progress
from ...results.dataset import EQUAL, dataset, ranked
from ...statics.tangent import linear
from ...system.assembly import assemble, train_provenance
from ...system.system import Array, System
from ...train.layouts import FEWEST, RATIO_LIMIT, fits, said
from ...train.resolution import load
from ...train.train import Train
from ...warning_codes import code_of
from ..modes.campbell import MeshCrossings, mesh_crossings, tones_of_meshes
from ..modes.eigen import repeated_roots
from ..response.sweep_table import resonance_forces
from . import DetuneOptions
from .compare import TrainModes, mode_pairs, modes_of, transmission_ratio
from .sensitivity import Parameter, all_parameters, parameter_at

# Largest sensible factor of a length or a mass, and of the stiffness of a support, a bearing or a mesh.
_SIZE, _STIFFNESS = 1.25, 4.0
_MASSES = ("mass", "inertia", "tilt_inertia")
_SIZES = ("module", "face_width", "helix_angle", "bore", "rim", "outer_diameter", "diameter")
_HELD = ("support", "bearing", "neck")
_DIRECTIONS = {"radial": "radial", "x": "horizontal", "y": "vertical", "z": "axial", "rz": "rotary", "tilt": "tilting"}
# Warnings of drawings that cannot be built.
_UNBUILT = (
    *("not-assembled", "ring-too-small", "planets-collide", "tips-in-roots", "contact-ratio-below-one"),
    *("centre-distances-differ", "shafts-not-alike"),
)
# Resonances that a message names.
_SHOWN = 8
# Step of a difference quotient, per value; sensitivity below which a number moves nothing that a change could use [1].
_STEP, _MOVES = 1e-4, 2e-3
# Sizes that are tried of one change; distance that is no more than was wanted, per band.
_TRIES, _ENOUGH = 3, 1.1
# Teeth of the planet beside those that keep the shares of the gears.
_BESIDE = 2
# Change of a centre distance or a ratio that is none: of a module of six digits.
_SAME = 1e-4
_FAILING = (ModelError, ConvergenceError, ArithmeticError, np.linalg.LinAlgError)


class NearResonance(NamedTuple):
    """A mesh order that meets a mode.

    mode, multiplicity : place of the first mode of the frequency, from 0, and how many it has.  hertz : of the mode.
    stage : whose mesh order.  speed : per operating speed [1].  away : from the speed that is to be free, per it [1].
    force_ratio : largest force of the mode per mean force of the same mesh [1], nan where it is not known.
    """

    mode: int
    multiplicity: int
    hertz: float
    stage: str
    order: int
    speed: float
    away: float
    force_ratio: float

    @property
    def label(self) -> str:
        """``order 3 with mode 7``."""
        return f"order {self.order} with mode {self.mode + 1}"


class Change(NamedTuple):
    """A change of the drawing.

    label : ``module``, or whole where it is one of tooth counts.  values : numbers that a factor multiplies.
    most : largest sensible factor [1].  moves : per cent of the resonance speed per cent of the numbers.
    factor : that brings it out of the band by that [1].  fixed : other overrides; the factor is then their own.
    """

    label: str
    values: tuple[Parameter, ...]
    most: float
    moves: float
    factor: float
    fixed: Mapping[str, object] = {}

    def effort(self, factor: float) -> float:
        """Part of the largest sensible change, on a scale of ratios [1]."""
        return abs(math.log(factor)) / math.log(self.most)

    def overrides(self, factor: float) -> dict[str, object]:
        """What sets the numbers."""
        own = {one.path: one.number.text((float(f"{one.value * factor:.6g}"),)) for one in self.values}
        return {**own, **self.fixed}

    def said(self, factor: float) -> str:
        """``module -12 %``, ``radial sun support x 2.1``."""
        size = f" x {factor:.2g}" if self.most > _SIZE else f" {100 * (factor - 1):+.0f} %"
        return self.label + ("" if self.fixed else size)

    def rounded(self, factor: float) -> float:
        """A factor as a person writes it, away from 1 and sensible: whole per cent, two digits of a stiffness."""
        factor = min(max(factor, 1 / self.most), self.most)
        step = 0.01 if self.most == _SIZE else 10.0 ** (math.floor(math.log10(factor)) - 1)
        outward = math.ceil(factor / step - 1e-6) if factor > 1 else math.floor(factor / step + 1e-6)
        return min(max(round(outward * step, 6), 1 / self.most), self.most)


class _Trial(NamedTuple):
    """One size of a change.

    place : of every mode of the train on the changed one (n,).  own : the resonance there, without its force.
    correlation : of its shape with that before [1].
    """

    factor: float
    train: Train
    system: System
    modes: TrainModes
    place: NDArray[np.int64]
    own: NearResonance
    correlation: float


class Judged(Protocol):
    """What has the distance and the force of a resonance."""

    @property
    def away(self) -> float: ...

    @property
    def force_ratio(self) -> float: ...


Met = TypeVar("Met", bound=Judged)


def strongest(met: Sequence[Met]) -> Met:
    """The strongest of some resonances; where no force is known, the nearest."""
    force = [one.force_ratio for one in met]
    return met[ranked(force, equal=EQUAL)[0]] if np.isfinite(force).any() else min(met, key=lambda one: abs(one.away))


def detune(train: Train, options: DetuneOptions, *, progress: Progress | None = None) -> xr.Dataset:
    """Changes of a drawing that move a resonance out of the band about a speed, the best first.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : over ``change`` (c,), each computed on the changed train: ``moved_speed`` per operating speed [1],
        ``moved_away`` from the speed that is to be free [1], ``moved_frequency`` [Hz], ``left_force_ratio`` of the
        strongest resonance left in the band [1], ``change_overrides``, and ``status``: why it gives nothing.
        Attribute ``resonance``: the one that is moved, empty where no order excites a mode in the band.

    Raises
    ------
    ModelError : no speed; a resonance that is not in the band; no modes.
    """
    told = progress or (lambda _: None)
    system = assemble(train)
    modes, rows = modes_of(system), list[tuple[str, dict[str, Any]]]()
    near = resonances_near(system, modes, options.relative_speed, options.band)
    asked = [one for one in near if options.mode in (None, one.mode + 1) and options.order in (None, one.order)]
    if not asked and (options.mode or options.order):
        unknown = options.mode is not None and all(one.mode + 1 != options.mode for one in near)
        path = "mode" if unknown or options.order is None else "order"
        allowed = "; ".join(one.label for one in near[:_SHOWN]) or "none: nothing is to be moved"
        raise ModelError("no such resonance in the band", path=path, given=getattr(options, path), allowed=allowed)
    chosen = strongest(asked) if asked else None
    if chosen is not None:
        search = _Search(train, system, modes, options.relative_speed, options.band, chosen, near)
        changes = [*search.numbers(told), *search.tooth_sets()]
        changes = sorted(changes, key=lambda change: change.effort(change.factor))[: options.changes]
        found = outcomes(
            search.tried, changes, workers=False, failing=_FAILING, progress=lambda share: told(0.5 + 0.5 * share)
        )
        ordered = sorted(zip(changes, found, strict=True), key=lambda one: _rank(one[0], one[1], options.band))
        rows = [_row(*one) for one in ordered]
    texts = ("left_resonance", "change_note", "change_overrides", "status")
    result = dataset(
        {
            name: ("change", np.array([row[name] for _, row in rows], object if name in texts else float))
            for name in _EMPTY
        },
        {"change": [label for label, _ in rows]},
        verb="detune",
        options={name: getattr(options, name) for name in ("mode", "order", "band", "relative_speed")},
        provenance=train_provenance(train),
        warnings=linear(system).warnings,
    )
    said = {} if chosen is None else chosen._asdict() | {"mode": chosen.mode + 1}
    known = {name: value for name, value in said.items() if value == value}
    return result.assign_attrs(resonance=json.dumps(known))


def resonances_near(
    system: System, modes: TrainModes, speed: float, band: float, *, also: float | None = None
) -> list[NearResonance]:
    """Resonances within a band about a speed per operating speed, or as far as another one, that may be excited."""
    tones = tones_of_meshes(system)
    if not tones:
        raise ModelError("no mesh turns: no mesh order meets a mode", path="operation.speed")
    ends, stages = ((1 - band) * speed, (1 + band) * speed, also or speed), [", ".join(one) for one in tones.values()]
    low, high = min(ends) * (1 - 1e-9), max(ends) * (1 + 1e-9)
    met = mesh_crossings(modes.frequency, [float(tone) for tone in tones], low=low, high=high)
    forces = resonance_forces(system, met, modes.vectors)
    excited = forces["excited"] != "no"
    return met_at(met.chosen(excited), forces["force_ratio"][excited], modes.frequency, stages, speed)


def met_at(
    met: MeshCrossings, force_ratio: Array, frequency: Mapping[int, float] | Array, stages: Sequence[str], speed: float
) -> list[NearResonance]:
    """Resonances at crossings (c,).

    force_ratio : (c,) [1].  frequency : of the modes by place [Hz].  stages : by tone.  speed : that is to be free, per
    operating speed [1].
    """
    columns = (met.mode, met.count, met.tone, met.order, met.relative_speed, force_ratio)
    return [
        NearResonance(mode, count, float(frequency[mode]), stages[tone], order, at, at / speed - 1, ratio)
        for mode, count, tone, order, at, ratio in zip(*(column.tolist() for column in columns), strict=True)
    ]


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """A train, the speed that a resonance is to leave, per operating speed [1], and the band about it [1].

    chosen : the resonance.  near : all of the band.
    """

    train: Train
    system: System
    modes: TrainModes
    speed: float
    band: float
    chosen: NearResonance
    near: Sequence[NearResonance]

    def wanted(self, side: float) -> float:
        """Speed of the resonance beyond the band on a side, -1 or 1, per its speed now [1]."""
        return (1 + side * self.band) * self.speed / self.chosen.speed

    @property
    def shapes(self) -> slice:
        """Places of the modes of the resonance."""
        return slice(self.chosen.mode, self.chosen.mode + self.chosen.multiplicity)

    def numbers(self, told: Progress) -> Iterator[Change]:
        """Changes of the lengths, masses and stiffnesses that the file states; mass and inertia of a body together."""
        groups: dict[tuple[str, float], list[Parameter]] = {}
        stated = dict(leaves(dict(self.train.document)))
        for one in all_parameters(self.train):
            named = _named(one.path, several=len(self.train.planets) > 1)
            if named is not None and one.leaves[0] in stated and one.value and not one.number.many:
                groups.setdefault(named, []).append(one)
        before, wanted = self._squared(self.system), math.log(self.wanted(math.copysign(1.0, self.chosen.away)))
        for done, ((label, most), values) in enumerate(groups.items()):
            change = Change(label, tuple(values), most, 0.0, 1.0)
            with suppress(*_FAILING):  # what the model cannot have beside its value is no change
                beside = assemble(self._changed(change.overrides(1 + _STEP)))
                moves = math.log(self._squared(beside) / before) / math.log1p(_STEP) / 2
                if abs(moves) > _MOVES:
                    yield change._replace(moves=moves, factor=math.exp(wanted / moves))
            told(0.5 * (done + 1) / len(groups))

    def _changed(self, overrides: Mapping[str, object]) -> Train:
        # tolerances move no resonance but take time to check
        kept = {name: table for name, table in self.train.document.items() if name not in ("tolerance", "assumed")}
        return load(kept, dict(overrides))

    def _squared(self, system: System) -> float:
        """omega^2 of the shapes of the resonance [rad^2/s^2]: Rayleigh's quotient, right to first order."""
        system, shapes = linear(system), self.modes.vectors[:, self.shapes]
        if tuple(system.dofs.names) != self.modes.dofs:
            raise ModelError("another number of motions beside this value")
        mean = system.K + (system.meshes.B * system.meshes.stiffness) @ system.meshes.B.T
        energies = np.linalg.solve(shapes.T @ system.M @ shapes, shapes.T @ mean @ shapes)
        return float(np.trace(energies)) / self.chosen.multiplicity

    def tooth_sets(self) -> list[Change]:
        """Tooth counts of a simple planetary stage, with the module that keeps the centre distance: to each side of
        the band the two sets that move the mesh frequency by what is wanted, or a little more."""
        path, of_stage = f"stages.{self.chosen.stage}", [b for b in self.train.bodies if b.frame == self.chosen.stage]
        gears = {body.member: (body.kind, body.gear) for body in of_stage if body.gear is not None}
        counts = {kind: gear.teeth for kind, gear in gears.values()}
        if sorted(counts) != sorted({"sun", "planet", "ring"}) or len(gears) > len(counts):
            return []
        sun, planet, ring = (counts[kind] for kind in ("sun", "planet", "ring"))
        planets = self.train.planets[self.chosen.stage]
        helix, module = next(gear.helix_angle for _, gear in gears.values()), f"{path}.module"
        if module not in dict(leaves(dict(self.train.document))):
            return []
        number, found = parameter_at(self.train, module), list[Change]()
        for z_s in range(max(math.ceil(sun / _SIZE), min(FEWEST, sun)), math.floor(sun * _SIZE) + 1):
            middle = round(planet * z_s / sun)
            for z_p in range(max(middle - _BESIDE, min(FEWEST, planet)), middle + _BESIDE + 1):
                new = {"sun": z_s, "planet": z_p, "ring": ring + z_s - sun + 2 * (z_p - planet)}
                change = (1 + new["ring"] / z_s) / (1 + ring / sun)
                if abs(change - 1) > RATIO_LIMIT or not fits(new, planets, helix, None):
                    continue
                size = f"{number.value * (sun + planet) / (z_s + z_p):.6g} {number.unit}".strip()
                teeth = {f"{path}.{kind}.teeth": new[kind] for kind in counts}
                label = f"teeth {said(new)}, module {size}"
                found.append(Change(label, (), _SIZE, 1.0, sun / z_s, {module: size, **teeth}))
        found.sort(key=lambda change: abs(math.log(change.factor)))
        sides = ((side, side * math.log(self.wanted(side))) for side in (-1.0, 1.0))
        enough = ([one for one in found if side * math.log(one.factor) >= least] for side, least in sides)
        return [one for sets in enough for one in sets[:2]]

    def tried(self, change: Change) -> dict[str, Any]:
        """What a change gives, by the names of the result.

        Raises
        ------
        ModelError : the changed train cannot be, cannot be built where this one can, or has another ratio.
        """
        trial = self._sized(change)
        ratios = transmission_ratio(self.train), transmission_ratio(trial.train)
        spared = set() if change.fixed else {code_of(text) for text in self.train.warnings}
        for text in trial.train.warnings:
            if code_of(text) in _UNBUILT and code_of(text) not in spared:
                raise ModelError(f"cannot be built: {text}")
        if change.fixed and abs(ratios[1] / ratios[0] - 1) > RATIO_LIMIT:
            raise ModelError(f"changes the ratio to {ratios[1]:.5g}")
        known = {(int(trial.place[one.mode]), one.stage, one.order) for one in self.near}
        met = {
            (one.mode, one.stage, one.order): one
            for one in resonances_near(trial.system, trial.modes, self.speed, self.band, also=trial.own.speed)
        }
        own = met.get((trial.own.mode, trial.own.stage, trial.own.order), trial.own)
        left = [one for one in met.values() if abs(one.away) < self.band * (1 - 1e-9)]
        come = [one for key, one in met.items() if one in left and one != own and key not in known]
        most = strongest(left) if left else None
        return {
            "change_factor": trial.factor,
            "predicted_speed": self.chosen.speed * trial.factor**change.moves,
            "moved_speed": own.speed,
            "moved_away": own.away,
            "moved_frequency": own.hertz,
            "moved_mode": own.mode + 1,
            "moved_force_ratio": own.force_ratio,
            "mode_correlation": trial.correlation,
            "left_force_ratio": 0.0 if most is None else most.force_ratio,
            "left_resonance": "" if most is None else most.label,
            "transmission_ratio": ratios[1],
            "change_note": "; ".join(
                _notes(self.train, trial, change, [o for o in come if o.force_ratio >= NO_MATTER])
            ),
            "change_overrides": json.dumps(change.overrides(trial.factor)),
        }

    def _sized(self, change: Change) -> _Trial:
        """The change at the size that is wanted: a secant of the trials corrects the first one."""
        best = trial = self._followed(change, change.factor if change.fixed else change.rounded(change.factor))
        for _ in range(0 if change.fixed else _TRIES - 1):
            moved, out = math.log(trial.own.speed / self.chosen.speed), abs(trial.own.away) / self.band
            if 1 <= out < _ENOUGH or not moved or (out < 1 and change.effort(trial.factor) > 1 - 1e-9):
                break
            wanted = math.log(self.wanted(math.copysign(1.0, self.chosen.away)))
            factor = change.rounded(math.exp(math.log(trial.factor) * wanted / moved))
            if factor == trial.factor:
                break
            trial = self._followed(change, factor)
            smaller = change.effort(factor) < change.effort(best.factor)
            if abs(best.own.away) < self.band or (abs(trial.own.away) >= self.band and smaller):
                best = trial
        return best

    def _followed(self, change: Change, factor: float) -> _Trial:
        """The resonance on the changed train by its shape, of modes that part the one nearest to the speed."""
        train = self._changed(change.overrides(factor))
        system = assemble(train)
        modes, tones = modes_of(system), tones_of_meshes(system)
        place, criterion, _ = mode_pairs(self.modes, modes)
        correlation, places = float(criterion[self.shapes].min()), place[self.shapes].tolist()
        if min(places) < 0 or not correlation >= SAME_SHAPE:
            raise ModelError("the mode is not found again by its shape")
        tone = next(float(tone) for tone, stages in tones.items() if ", ".join(stages) == self.chosen.stage)
        hertz = modes.frequency[places]
        speed = hertz / (self.chosen.order * tone)
        nearest = int(np.abs(speed / self.speed - 1).argmin())
        run = next(run for run in repeated_roots(modes.squared) if run.start <= places[nearest] < run.stop)
        own = self.chosen._replace(
            mode=run.start,
            hertz=float(hertz[nearest]),
            speed=float(speed[nearest]),
            away=float(speed[nearest]) / self.speed - 1,
            force_ratio=math.nan,
        )
        return _Trial(factor, train, system, modes, place, own, correlation)


def _named(path: str, *, several: bool) -> tuple[str, float] | None:
    """Words for a number of the model file, those of the masses of a body the same, and its largest sensible factor;
    None where it is no number that a change moves."""
    words = path.split(".")
    if words[0] not in ("stages", "bodies", "couplings") or not 3 <= len(words) <= 5:
        return None
    table, owner, *inner, last = words
    before = [owner] if several or table != "stages" else []
    if last in _MASSES:
        return " ".join([*before, *inner, "mass"]), _SIZE
    if last == "stiffness" and inner[:1] == ["meshes"]:
        return " ".join([*before, *inner[1:], "mesh stiffness"]), _STIFFNESS
    if last in _DIRECTIONS and (table == "couplings" or (inner and inner[-1] in _HELD)):
        return " ".join([_DIRECTIONS[last], *before, *(inner or ["coupling"])]), _STIFFNESS
    if last in (*_SIZES, "torsional_rigidity"):
        return " ".join([*before, *inner, last.replace("_", " ")]), _SIZE if last in _SIZES else _STIFFNESS
    return None


_EMPTY: Mapping[str, Any] = {
    **dict.fromkeys(("change_factor", "predicted_speed", "moved_speed", "moved_away", "moved_frequency"), math.nan),
    **dict.fromkeys(("moved_mode", "moved_force_ratio", "mode_correlation", "left_force_ratio"), math.nan),
    "transmission_ratio": math.nan,
    **dict.fromkeys(("left_resonance", "change_note", "change_overrides"), ""),
    "status": "ok",
}


def _row(change: Change, found: Outcome[dict[str, Any]]) -> tuple[str, dict[str, Any]]:
    """Label and values of a change."""
    values = found.value or {"status": found.reason}
    return change.said(values.get("change_factor", change.factor)), {**_EMPTY, **values}


def _rank(change: Change, found: Outcome[dict[str, Any]], band: float) -> tuple[float, ...]:
    """Order of changes: how bad the strongest resonance left is, whether the moved one is out, the least change."""
    if (row := found.value) is None:
        return (math.inf,)
    left = float(row["left_force_ratio"])
    tone = ("good", "caution", "bad").index(ResonanceVerdict(left).tone if math.isfinite(left) else "caution")
    return tone, not abs(row["moved_away"]) >= band * (1 - 1e-9), change.effort(row["change_factor"])


def _notes(before: Train, trial: _Trial, change: Change, come: Sequence[NearResonance]) -> Iterator[str]:
    """What else a change does: centre distances and ratio, stated masses that do not follow, resonances that come."""
    lengths = [
        [float(str(one.value)) for one in train.values if one.path.endswith(".centre_distance")]
        for train in (before, trial.train)
    ]
    other = {(f"{1e3 * old:.5g}", f"{1e3 * new:.5g}") for old, new in zip(*lengths, strict=True) if _differ(old, new)}
    if other:
        yield "centre distance " + ", ".join(f"{old} -> {new} mm" for old, new in sorted(other))
    elif change.fixed:
        yield "centre distance stays"
    ratios = transmission_ratio(before), transmission_ratio(trial.train)
    if _differ(*ratios):
        yield f"ratio {ratios[0]:.5g} -> {ratios[1]:.5g}"
    paths = [path for path in change.overrides(trial.factor) if path.rpartition(".")[2] in (*_SIZES, "teeth")]
    heads = tuple(f"{path.rpartition('.')[0]}." for path in paths)
    stated = [path.split(".") for path, _ in leaves(dict(before.document)) if path.startswith(heads)]
    if owners := dict.fromkeys(words[-2] for words in stated if words[-1] in _MASSES):
        yield f"stated masses stay ({', '.join(owners)})"
    if come:
        words = (f"{one.label} ({100 * one.force_ratio:.{0 if one.force_ratio >= 0.1 else 1}f} %)" for one in come)
        yield f"comes into the band: {', '.join(words)}"


def _differ(before: float, after: float) -> bool:
    return abs(after - before) > _SAME * abs(before)
