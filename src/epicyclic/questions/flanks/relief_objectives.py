"""Micro-geometry as an optimisation: design variables of the unit cube, and the objectives that they are judged by.

Amounts are whole nanometres and lengths whole micrometres, so that a model file says exactly what was computed.

Objectives are loaded transmission error, load per length of contact line and dynamic mesh force.  Transmission error
and load follow from the loaded contact of each mesh alone.  The dynamic mesh force follows from the linear sweep of the
train, with the tangent stiffness of that contact in its meshes (docs/how-to/relief.md).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from itertools import chain
from typing import NamedTuple

import numpy as np

from ...document.units import Bounds, read_quantity
from ...errors import ModelError
from ...statics.record import reference_tone
from ...system.system import Array, System
from ...system.tooth_pairs import ContactHistory, pair_of, with_contact_tangent
from ...teeth.form import Flank, Relief
from ...teeth.gear_pair import ContactPair, uniform_along_face
from ...teeth.loaded_contact import MicrogeometryContact, all_segments, first_images, microgeometry_contact
from ...teeth.segments import ContactSegments
from ...train.train import Mesh, Train
from ..response import SweepOptions
from ..response.steady import sweep
from . import ContactOptions
from .contact_resolution import Resolution, mesh_phases, sigma_at

Value = float | str
FlankSettings = Mapping[str, Value]
"""Settings of one flank: keys of `KEYS` -> lengths [m], or a shape."""

_TABLES = ("tip_relief", "root_relief", "end_relief")
_SHAPES = ("linear", "parabolic")
# key -> power of ten of its resolution [m]
_RESOLUTION = {f"{table}.{name}": power for table in _TABLES for name, power in (("amount", -9), ("length", -6))}
_RESOLUTION |= {"crown": -9, "slope": -9}
KEYS = (*_RESOLUTION, *(f"{table}.shape" for table in _TABLES))
"""Keys of a flank that may vary."""

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_RANGE = re.compile(rf"\s*({_NUMBER})\s*([A-Za-zµ].*?)?\s*\.\.\s*({_NUMBER})\s*([A-Za-zµ].*?)\s*")

# Phases and slices of a search where none are given.  With the corners of contact among the phases, and parts of slices
# coupled as parts, objectives are then known to some per cent; the best candidates are solved again (`verification`).
_PHASES, _SLICES = 64, 10
_UNCUT = Resolution(phase=np.zeros(0), samples=0, slices=0, graded=False, error=np.full(3, np.nan))

OBJECTIVES = {
    "lte": ("m", "peak to peak of the loaded transmission error, largest over the loads, mean over the meshes"),
    "load": ("N/m", "largest force per length of contact line over the mesh cycle, loads and meshes"),
    "force_rms": ("N", "RMS of the dynamic mesh force, largest over the speeds and meshes"),
    "force_peak": ("N", "mesh force, largest over the speeds and meshes"),
}
"""Objective -> its unit, and the quantity that is minimised."""

DYNAMIC = {"force_rms": "mesh_force_rms", "force_peak": "mesh_force_peak"}
"""Objective of the train in motion -> the variable of `sweep` it is the maximum of."""


# design variables -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignVariable:
    """One key of one flank, or of several flanks alike, between bounds.

    name : as given by the user, ``p.tip_relief.amount``.  key : of the flank.
    paths : of the flanks in the model file.
    low, high : bounds [m], multiples of the resolution; of a shape 0 and the number of shapes.
    shapes : alternatives of a shape key, else empty.
    """

    name: str
    key: str
    paths: tuple[str, ...]
    low: float
    high: float
    shapes: tuple[str, ...] = ()

    def value(self, coordinate: float) -> Value:
        """Value at a unit-cube coordinate 0..1: a length [m] rounded to the resolution, or a shape."""
        if self.shapes:
            return self.shapes[min(int(coordinate * len(self.shapes)), len(self.shapes) - 1)]
        scale = 10.0 ** -_RESOLUTION[self.key]
        steps = round((self.low + coordinate * (self.high - self.low)) * scale)
        low, high = round(self.low * scale), round(self.high * scale)
        return float(Decimal(min(max(steps, low), high)).scaleb(_RESOLUTION[self.key]))

    def coordinate(self, value: Value) -> float:
        """Unit-cube coordinate of a value; outside 0..1, or nan of a shape, where the value is out of bounds."""
        if self.shapes:
            return (self.shapes.index(str(value)) + 0.5) / len(self.shapes) if value in self.shapes else math.nan
        return (float(value) - self.low) / (self.high - self.low)

    def numeric(self, value: Value) -> float:
        """Length [m], or index of a shape."""
        return float(self.shapes.index(str(value))) if self.shapes else float(value)

    def text(self, value: Value) -> str:
        """A value as a model file has it."""
        return value if isinstance(value, str) else length_text(value, -3 if self.key.endswith("length") else -6)


def read_variables(
    vary: Mapping[str, object], flanks: Mapping[str, Flank]
) -> tuple[tuple[DesignVariable, ...], dict[str, dict[str, Value]]]:
    """Design variables, and the settings that are fixed to one value.

    Parameters
    ----------
    vary : ``[GEAR.]KEY`` -> ``"0..40 um"``, (low, high) [m], one value, or shapes; without a gear it holds for all
        flanks alike.
    flanks : path in the model file -> flank as drawn.

    Returns
    -------
    Variables in the order of `vary`, and fixed settings by path of the flank.

    Raises
    ------
    ModelError : unknown key or gear, empty bounds, missing or other unit, a key given twice, a relief without length
        or amount.
    """
    variables: list[DesignVariable] = []
    fixed: dict[str, dict[str, Value]] = {path: {} for path in flanks}
    for name, given in vary.items():
        paths, key = _flanks_and_key(str(name), tuple(flanks))
        for path in paths:
            if key in fixed[path] or any(key == one.key and path in one.paths for one in variables):
                raise ModelError(f"given twice for {path}", path=f"vary {name}")
        value = _read(given, key, f"vary {name}")
        if isinstance(value, tuple):
            low, high = map(float, value) if key in _RESOLUTION else (0.0, len(value))
            shapes = () if key in _RESOLUTION else tuple(map(str, value))
            name = str(name).strip()
            variables.append(DesignVariable(name=name, key=key, paths=paths, low=low, high=high, shapes=shapes))
        else:
            for path in paths:
                fixed[path][key] = value
    if not variables:
        raise ModelError("nothing to vary", path="vary", given=dict(vary), allowed='tip_relief.amount = "0..40 um"')
    # refuse a changed relief whose amount or length is neither drawn nor given
    for path, flank in flanks.items():
        keys = {one.key: one.name for one in variables if path in one.paths} | {key: key for key in fixed[path]}
        for table in _TABLES:
            changed = [key for key in keys if key.startswith(table)]
            if not changed or getattr(flank, table) is not None:
                continue
            for part in ("amount", "length"):
                if f"{table}.{part}" not in keys:
                    problem = f"{path}.{table} has no {part}, neither drawn nor given"
                    raise ModelError(problem, path=f"vary {keys[changed[0]]}", allowed=f"{table}.{part} beside it")
    return tuple(variables), fixed


def _flanks_and_key(name: str, paths: Sequence[str]) -> tuple[tuple[str, ...], str]:
    """Paths of the flanks that ``[GEAR.]KEY`` names, and the key of the flank."""
    text = name.strip()
    key = next((key for key in KEYS if text == key or text.endswith(f".{key}")), None)
    if key is None:
        raise ModelError("no such thing to vary", path="vary", given=name, allowed=", ".join(KEYS))
    gear = text[: -len(key)].rstrip(".").removeprefix("stages.").removesuffix(".flank")
    named = tuple(path for path in paths if not gear or gear in _gear_names(path))
    if not named:
        allowed = ", ".join(sorted({sorted(_gear_names(path), key=len)[0] for path in paths}))
        raise ModelError("no such gear in the meshes looked at", path=f"vary {name}", given=gear, allowed=allowed)
    return named, key


def _gear_names(path: str) -> set[str]:
    """Names of the gear of a flank: p, main.p; of one side p.left, main.p.left too."""
    stage, gear, *side = path.removeprefix("stages.").removesuffix(".flank").split(".")
    return {gear, f"{stage}.{gear}", ".".join([gear, *side]), ".".join([stage, gear, *side])}


def _read(given: object, key: str, path: str) -> Value | tuple[Value, ...]:
    """One value, bounds [m], or shapes."""
    if key not in _RESOLUTION:
        names = [part.strip() for part in given.split(",")] if isinstance(given, str) else given
        if not isinstance(names, (list, tuple)) or not names or any(name not in _SHAPES for name in names):
            raise ModelError("no such shape", path=path, given=given, allowed=", ".join(_SHAPES))
        return str(names[0]) if len(names) == 1 else tuple(dict.fromkeys(map(str, names)))
    if isinstance(given, str) and ".." in given:
        match = _RANGE.fullmatch(given)
        if match is None:
            raise ModelError("not a range with a unit", path=path, given=given, allowed='"0..40 um"')
        first, one, last, other = match.groups()
        return _bounds(_metres(f"{first} {one or other}", path), _metres(f"{last} {other}", path), key, path, given)
    if isinstance(given, (tuple, list)) and len(given) == 2:
        return _bounds(_metres(given[0], path), _metres(given[1], path), key, path, given)
    return _removing(_metres(given, path), key, path)


def _metres(given: object, path: str) -> float:
    """Length in SI [m] of a number, or of a text with its unit."""
    try:
        value = read_quantity(given, ("length",), Bounds())
    except ModelError as error:
        raise ModelError(error.problem, path=path, given=given, allowed=error.allowed) from None
    assert isinstance(value, float)
    return value


def _bounds(low: float, high: float, key: str, path: str, given: object) -> tuple[float, float]:
    """Bounds [m] drawn in to multiples of the resolution."""
    power = _RESOLUTION[key]
    # 1e-6 of a step: a bound on a multiple must not be lost to rounding
    first, last = (math.ceil(low * 10.0**-power - 1e-6), math.floor(high * 10.0**-power + 1e-6))
    if key.endswith("length"):
        first = max(first, 1)  # a relief of zero length is none: the shortest is one step long
    if not first < last:
        problem = "empty bounds" if low >= high else f"bounds nearer than {10.0**power:g} m"
        raise ModelError(problem, path=path, given=given, allowed="low .. high")
    _removing(low, key, path)
    return float(Decimal(first).scaleb(power)), float(Decimal(last).scaleb(power))


def _removing(value: float, key: str, path: str) -> float:
    """The value, refused where it would add material; a slope may have either sign."""
    if value < 0 and key != "slope":
        raise ModelError("takes material off", path=path, given=value, allowed="0 or more")
    return value


def modified_flank(flank: Flank, settings: FlankSettings) -> Flank:
    """Flank with settings in place of what is drawn."""
    changes: dict[str, object] = {key: settings[key] for key in ("crown", "slope") if key in settings}
    for table in _TABLES:
        new = {key.split(".")[1]: value for key, value in settings.items() if key.startswith(f"{table}.")}
        if new:
            changes[table] = replace(getattr(flank, table) or Relief(amount=0.0, length=0.0), **new)
    return replace(flank, **changes)  # type: ignore[arg-type]


def overrides_of(settings: Mapping[str, FlankSettings], flanks: Mapping[str, Flank]) -> dict[str, str]:
    """Settings as overrides of the model file; of a changed relief all keys, as some may be drawn on another side."""
    overrides: dict[str, str] = {}
    for path, values in settings.items():
        flank = modified_flank(flanks[path], values)
        for table in _TABLES:
            if any(key.startswith(f"{table}.") for key in values):
                relief = getattr(flank, table)
                overrides[f"{path}.{table}.amount"] = length_text(relief.amount, -6)
                overrides[f"{path}.{table}.length"] = length_text(relief.length, -3)
                overrides[f"{path}.{table}.shape"] = relief.shape
        for key in ("crown", "slope"):
            if key in values:
                overrides[f"{path}.{key}"] = length_text(getattr(flank, key), -6)
    return overrides


def length_text(value: float, power: int) -> str:
    """Length [m] as a text in um (power -6) or mm (-3) that is read back exactly."""
    unit = {-6: "um", -3: "mm"}[power]
    return f"{Decimal(repr(value)).scaleb(-power).normalize():f} {unit}"


# objectives -----------------------------------------------------------------------------------------------------------


class HelixContact(NamedTuple):
    """One helix of a mesh: its place in the train, its contact segments as drawn, its operating load [N]."""

    mesh: Mesh
    segments: ContactSegments
    force: float

    def modified_pair(self, settings: Mapping[str, FlankSettings]) -> ContactPair:
        """Contact pair with the settings of its two flanks applied."""
        pair, teeth = self.segments.pair, self.mesh.teeth
        assert teeth is not None
        a, b = (settings.get(path, {}) for path in teeth.paths)
        return replace(pair, flank_a=modified_flank(pair.flank_a, a), flank_b=modified_flank(pair.flank_b, b))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReliefProblem:
    """Data of the optimisation: o objectives of v design variables, over M meshes and F relative loads.

    objectives : names, of `OBJECTIVES`.  variables : (v,).  fixed : settings that do not vary, by path of the flank.
    contact : settings of all meshes.  loaded : the helices of each with their operating loads [N].
    factors : (F,) loads per operating one [1].
    meshes, resolution : contact of these helices with so many phases and slices, as of `cut`.
    train, system, speeds : the train, and for dynamic objectives its System and (P,) relative speeds [1], else None.
    """

    objectives: tuple[str, ...]
    variables: tuple[DesignVariable, ...]
    fixed: Mapping[str, FlankSettings]
    contact: ContactOptions
    loaded: Sequence[Sequence[tuple[Mesh, float]]]
    factors: Array
    train: Train
    system: System | None
    speeds: Array | None
    meshes: Sequence[Sequence[HelixContact]] = ()
    resolution: Resolution = _UNCUT

    def __call__(self, candidates: Array) -> Array:
        """Objectives (P, o) of candidates (P, v) in the unit cube; nan where one could not be computed."""
        return objectives_of(self, [self.settings(candidate) for candidate in candidates])

    def settings(self, candidate: Array) -> dict[str, dict[str, Value]]:
        """Settings of one candidate (v,) in the unit cube, by path of the flank; fixed ones included."""
        settings = {path: dict(values) for path, values in self.fixed.items()}
        for variable, coordinate in zip(self.variables, candidate.tolist(), strict=True):
            for path in variable.paths:
                settings[path][variable.key] = variable.value(coordinate)
        return settings

    def cut(self, needed: Resolution | None = None) -> ReliefProblem:
        """The problem with the helices cut into contact segments; a face that stays uniform is one segment.

        needed : its numbers of phases and slices count, the phases are those of all meshes; None: those given, else
        few, since the best candidates are solved again.

        Raises
        ------
        ModelError : as of `pair_of`.
        """
        contact = self.contact
        if needed is None:
            needed = replace(_UNCUT, samples=contact.samples or _PHASES, slices=contact.slices or _SLICES)
        keys = [*(one.key for one in self.variables), *(key for own in self.fixed.values() for key in own)]
        lead_modified = any(key.startswith(("end_relief", "crown", "slope")) for key in keys)

        def pair(mesh: Mesh) -> ContactPair:
            drawn = pair_of(
                self.train, mesh, slices=needed.slices, corner=contact.corner, misalignment=contact.misalignment
            )
            return replace(drawn, slices=1) if uniform_along_face(drawn) and not lead_modified else drawn

        pairs = [[pair(mesh) for mesh, _ in helices] for helices in self.loaded]
        graded, every = contact.samples is None, [mesh for helices in self.loaded for mesh, _ in helices]
        phase = mesh_phases(every, [*chain(*pairs)], needed.samples, graded=graded)
        meshes = []
        for helices, of_mesh in zip(self.loaded, pairs, strict=True):
            segments = all_segments(of_mesh, [sigma_at(mesh, phase) for mesh, _ in helices])
            parts = zip(helices, segments, strict=True)
            meshes.append([HelixContact(mesh, own, force) for (mesh, force), own in parts])
        return replace(self, meshes=meshes, resolution=replace(needed, phase=phase, graded=graded))


def relative_speeds(system: System, mesh_frequencies: Sequence[float], points: int) -> Array:
    """Relative speeds (P,) [1], evenly spaced between two mesh frequencies of the first mesh [Hz].

    mesh_frequencies : empty is 0.2 and 1.2 times the operating one.

    Raises
    ------
    ModelError : no speed, an empty range.
    """
    tone = float(reference_tone(system))
    low, high = mesh_frequencies or (0.2 * tone, 1.2 * tone)
    if not (0 < low <= high < math.inf) or points < 1:
        raise ModelError("the range is empty", path="start, stop", given=f"{low:g} Hz to {high:g} Hz, {points} points")
    return np.linspace(low, high, points) / tone


def objectives_of(problem: ReliefProblem, settings: Sequence[Mapping[str, FlankSettings]]) -> Array:
    """Objectives (S, o) of S sets of flank settings, in the units of `OBJECTIVES`; nan where contact is not solved."""
    contacts = _loaded_contacts(problem, settings)
    values = np.full((len(settings), len(problem.objectives)), np.nan)
    static = slice(0, len(problem.factors))
    for column, name in enumerate(problem.objectives):
        if name == "lte":
            # transmission error of a mesh: the mean of its helices
            swings = []
            for helices, solved_helices in zip(problem.meshes, contacts, strict=True):
                slants = [math.cos(helix.segments.pair.plane.base_helix) for helix in helices]
                errors = [one.approach[:, static] / slant for one, slant in zip(solved_helices, slants, strict=True)]
                swings.append(np.ptp(np.mean(errors, axis=0), axis=2).max(axis=1))
            values[:, column] = np.mean(swings, axis=0)
        elif name == "load":
            largest = [one.largest_load[:, static] for helices in contacts for one in helices]
            values[:, column] = np.max(largest, axis=(0, 2))
    solved = np.all([one.solved.all(axis=1) for helices in contacts for one in helices], axis=0)
    if problem.system is not None:
        dynamic = [name for name in problem.objectives if name in DYNAMIC]
        columns = [problem.objectives.index(name) for name in dynamic]
        for i in np.flatnonzero(solved):
            curves = _force_curves(problem, contacts, int(i))
            values[i, columns] = [float(curves[name].max()) for name in dynamic]
    values[~solved] = np.nan
    return values


def _loaded_contacts(
    problem: ReliefProblem, settings: Sequence[Mapping[str, FlankSettings]]
) -> list[list[MicrogeometryContact]]:
    """Loaded contact of every helix of every mesh; dynamic objectives append the operating load, with its tangents."""
    dynamic = problem.system is not None
    loads = np.append(problem.factors, 1.0) if dynamic else problem.factors
    largest = "load" in problem.objectives
    contacts = []
    for helices in problem.meshes:
        pairs = [[helix.modified_pair(one) for one in settings] for helix in helices]
        sigma = [helix.segments.sigma for helix in helices]
        images = [first_images(column, sigma) for column in zip(*pairs, strict=True)]
        of_helices: list[MicrogeometryContact] = []
        for i, helix in enumerate(helices):
            first = {image[i] for image in images}
            if first != {i} and len(first) == 1:  # the mirror image of another for all settings: the numbers of that
                of_helices.append(of_helices[first.pop()])
                continue
            forces = helix.force * loads
            of_helices.append(
                microgeometry_contact(helix.segments, pairs[i], forces, tangents=dynamic, largest=largest)
            )
        contacts.append(of_helices)
    return contacts


def force_curves(problem: ReliefProblem, settings: Mapping[str, FlankSettings]) -> dict[str, Array]:
    """Dynamic objective -> largest RMS or peak of the mesh forces at each speed, (P,) [N]; nan where a speed failed."""
    return _force_curves(problem, _loaded_contacts(problem, [settings]), 0)


def _force_curves(
    problem: ReliefProblem, contacts: Sequence[Sequence[MicrogeometryContact]], i: int
) -> dict[str, Array]:
    """The same of the contacts of the i-th set of flank settings, at the last load and the even phases."""
    assert problem.system is not None
    assert problem.speeds is not None
    even = problem.resolution.even
    histories = {
        helix.mesh.name: ContactHistory(
            force=helix.force, approach=one.approach[i, -1, even], tangent=one.tangent[i, -1, even]
        )
        for helices, solved in zip(problem.meshes, contacts, strict=True)
        for helix, one in zip(helices, solved, strict=True)
    }
    system = with_contact_tangent(problem.train, problem.system, histories)
    result = sweep(system, SweepOptions(relative_speed=problem.speeds))
    pairs = {helix.mesh.pair for helices in problem.meshes for helix in helices}
    names = [mesh.name for mesh in problem.train.meshes if mesh.pair in pairs]
    kept = result.sel(mesh=names)
    return {name: kept[DYNAMIC[name]].values.max(axis=0) for name in DYNAMIC}
