"""Tolerances of a train as a map from uniform numbers to load sharing: every draw moves columns of one load map.

Torques and stiffnesses: the System is assembled anew with other values of the number.

Clearances: each sample follows laws of its own, of the train that is assembled with what it draws.

Deviations: a drawn table is one table of the file (`deviations.main.planet.run_out`) with its components.  Each of its
planets has a complex size z = x + j y, which moves two columns, those of Re z and of Im z, and where it is given a size
along the axis.  A gap has a real size, a turning error the size A exp(j phase).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...document.document import read
from ...document.tables import value_at
from ...document.tolerances import Correlations, Tolerance
from ...errors import ModelError
from ...statics.load_map import LawMap, LoadMap, at_mesh_order, law_map, load_map
from ...statics.record import idle_warnings
from ...statics.sample_loads import ContactMethod, SampleLoads, nominal_signs, sample_loads
from ...statics.static import HeldTrain, held_train
from ...statics.tangent import linear, linear_columns
from ...system.assembly import assemble
from ...system.excitation import unit_lines
from ...system.system import Array, Line, System
from ...train.resolution import correlations_of, load, tolerances_of
from ...train.train import Displacement, MeshError, Train
from ...warning_codes import CodedText, code_of, coded

Kind = Literal["vector", "gap", "error", "nothing"]
Drawn = Mapping[str, NDArray[np.inexact]]
"""Draws (S, n) or (S, 1) of the entries of one table, by component; "" is a whole vector."""

_ALLOWED = "deviations, torques, clearances of links, stiffnesses of meshes, supports, bearings and couplings"
# Step of the value per its mean, and per its deviation where that is larger.
_STEP = 1e-2
# Relative difference that is rounding.
_ROUNDING = 1e-9
_VECTORS = ("run_out", "bearing_run_out", "position", "tilt")
# Size of the deviation that columns are taken from [m, rad]: its effect is linear, and this size passes every check.
_UNIT = 1e-6
# Kinds that leave the mesh-cycle mean at rest as it is: an error at mesh orders, and a force of speed.
_WITHOUT_EFFECT = {
    "profile": "it is at mesh orders, without a part in a mesh-cycle mean",
    "unbalance": "it needs speed",
}


# torques and stiffnesses ----------------------------------------------------------------------------------------------


def values_text(values: Sequence[float], unit: str) -> str:
    """Text of one number, or of a list with one per planet, as a model file has it."""
    text = repr(float(values[0])) if len(values) == 1 else f"[{', '.join(repr(float(value)) for value in values)}]"
    return f"{text} {unit}".strip()


def mean_of(entry: Tolerance) -> float:
    """Mean of the number of an entry, own and common draws together [SI]."""
    return sum(float(draw.mean.real) for draw in (entry.own, entry.common) if draw is not None)


def _assembled(document: Mapping[str, object], overrides: Mapping[str, object]) -> System:
    """System of a model with overrides, without the gaps of tabulated meshes, which stay those at the mean loads."""
    train = load(document, overrides)
    return assemble(replace(train, mesh_errors=tuple(e for e in train.mesh_errors if e.cause != "contact")))


def shift_of(
    document: Mapping[str, object], at_means: Mapping[str, object], base: System, entry: Tolerance, planet: int = 0
) -> tuple[Array, Array, Array]:
    """What the number of an entry changes per unit of it about its mean, from two assemblies and that at the means.

    Stiffness of the mesh rows (m,) and of the links (p,), torques (n,).

    Parameters
    ----------
    at_means : overrides with all such numbers at their mean, this one too.  base : the System at them.
    planet : whose number it is, from 0, of an entry with one per planet.

    Raises
    ------
    ModelError : it changes more than torques and stiffnesses, or those not in proportion.
    """
    mean = mean_of(entry)
    spread = max(draw.std for draw in (entry.own, entry.common) if draw is not None)
    step = max(spread, _STEP * abs(mean)) or 1.0
    if 0 < abs(mean) < 2 * step:  # a stiffness stays above zero
        step = abs(mean) / 2

    def loaded(value: float) -> System:
        """The System with another value of that number."""
        numbers = [mean] * entry.count
        numbers[planet] = value
        return _assembled(document, {**at_means, entry.path: values_text(numbers, entry.unit)})

    whole_step, half_step = (_changes(entry.path, base, loaded(mean + share * step)) for share in (1.0, 0.5))
    for whole, half in zip(whole_step, half_step, strict=True):
        if np.any(np.abs(whole - 2 * half) > _ROUNDING * (np.abs(whole).max(initial=0.0) + 1e-300)):
            raise ModelError(
                "torques or stiffnesses do not change in proportion to it",
                path=f"tolerance.{entry.path}",
                allowed="a torque, a stiffness of a mesh, a support, a bearing or a coupling",
            )
    if not any(change.any() for change in whole_step):
        raise ModelError(
            "it changes neither a torque nor a stiffness at rest",
            path=f"tolerance.{entry.path}",
            allowed=_ALLOWED,
        )
    mesh, link, force = (change / step for change in whole_step)
    return mesh, link, force


# Keys of links whose number is in the law of the link alone.
_PLAYS = ("clearance", "internal_clearance")


def check_play(document: Mapping[str, object], at_means: Mapping[str, object], entry: Tolerance) -> None:
    """Check that a clearance is in laws of links and in nothing else.

    Raises
    ------
    ModelError : no law follows it, as where a stiffness stands beside the parts of a bearing.
    """
    base, other = (
        assemble(load(document, {**at_means, entry.path: values_text([value], entry.unit)}))
        for value in (mean_of(entry), mean_of(entry) + _UNIT)
    )
    changes = _changes(entry.path, base, replace(other, groups=base.groups))
    if any(change.any() for change in changes) or all(
        a.law == b.law for a, b in zip(base.groups, other.groups, strict=True)
    ):
        allowed = "the clearance of a link that follows its law: a play, or the parts of a bearing without a stiffness"
        raise ModelError("no law follows it", path=f"tolerance.{entry.path}", allowed=allowed)


def _changes(path: str, base: System, other: System) -> tuple[Array, Array, Array]:
    """Differences of mesh stiffness (m,), link stiffness (p,) and torques (n,); ModelError where others differ."""
    same = (
        base.links.name == other.links.name
        and base.meshes.name == other.meshes.name
        and base.tones == other.tones
        and _equal(base.meshes.B, other.meshes.B)
        and _equal(base.far_flanks.B, other.far_flanks.B)
        and _equal(base.links.B, other.links.B)
        and _equal(base.meshes.backlash, other.meshes.backlash)
        and _equal(base.M, other.M)
        and [(group.name, group.law) for group in base.groups] == [(g.name, g.law) for g in other.groups]
    )
    lines = [[line for line in system.lines if not at_mesh_order(system, line)] for system in (base, other)]
    same = same and [line.frequency for line in lines[0]] == [line.frequency for line in lines[1]]
    if same:
        mesh = other.meshes.stiffness - base.meshes.stiffness
        for law in base.meshes.laws:  # a tangent that follows the load: that of the mean load stays
            mesh[law.rows] = 0.0
        link = other.links.stiffness - base.links.stiffness
        L = base.links.B
        same = _equal(other.K - (L * link) @ L.T, base.K)
        for before, after in zip(*lines, strict=True):
            pulled = L @ (link * after.link_gap)
            same &= _equal(before.gap, after.gap) and _equal(before.link_gap, after.link_gap)
            same &= _equal(before.force[0], after.force[0] - pulled, np.abs(pulled).max(initial=0.0))
    if not same:
        raise ModelError(
            "it changes more than torques and stiffnesses",
            path=f"tolerance.{path}",
            allowed=_ALLOWED,
        )
    return _cleaned(mesh, base.meshes.stiffness), _cleaned(link, base.links.stiffness), other.force - base.force


def _cleaned(change: Array, size: Array) -> Array:
    """Changes without those that are rounding of values of a size."""
    return np.where(np.abs(change) > 1e-12 * np.abs(size), change, 0.0)


def _equal(a: NDArray[Any], b: NDArray[Any], size: float = 0.0) -> bool:
    """Whether two arrays differ by rounding alone."""
    if a.shape != b.shape:
        return False
    finite = np.isfinite(a)
    if not np.array_equal(finite, np.isfinite(b)):
        return False
    largest = max(float(np.abs(a[finite]).max(initial=0.0)), size)
    return bool(np.all(np.abs(a[finite] - b[finite]) <= _ROUNDING * largest))


# tables of deviations -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrawnTable:
    """One table of deviations of which a tolerance draws at least one number.

    table : its path.  kind : how its numbers act.  entry, unit : component -> index of its entry, and its SI unit.
    nominal : component -> value of the file (n,), of those that are not drawn.
    across, along : (n, 2) and (n,) columns of Re z, Im z and of the axial size; -1 where there is none.
    """

    table: str
    kind: Kind
    entry: Mapping[str, int]
    unit: Mapping[str, str]
    nominal: Mapping[str, Array]
    across: NDArray[np.int64]
    along: NDArray[np.int64]

    @property
    def count(self) -> int:
        """Number n of planets, or 1."""
        return len(self.along)

    @property
    def effect(self) -> bool:
        """Whether any column follows it that a mesh-cycle mean keeps."""
        return self.kind != "nothing" and bool((self.across >= 0).any() or (self.along >= 0).any())

    def sizes(self, drawn: Drawn) -> NDArray[np.complex128]:
        """Complex size z (S, n) across the axis, or of a mesh [m, rad]."""
        if "" in drawn:
            return self._spread(drawn[""]).astype(complex)
        if self.kind == "gap":
            return self._value(drawn, "gap").astype(complex)
        form = drawn.keys() & {"x", "y", "amplitude", "phase"} or self.nominal.keys()
        if self.kind == "error" or form & {"amplitude", "phase"}:  # of one table either these or x and y
            return np.asarray(self._value(drawn, "amplitude") * np.exp(1j * self._value(drawn, "phase")))
        return np.asarray(self._value(drawn, "x") + 1j * self._value(drawn, "y"))

    def add(self, factors: Array, drawn: Drawn) -> None:
        """Write the sizes of S samples into their columns of the factors (S, C)."""
        z = self.sizes(drawn)
        sizes = [(self.across[:, 0], z.real), (self.across[:, 1], z.imag)]
        if (self.along >= 0).any():
            sizes.append((self.along, self._value(drawn, "z")))
        for column, values in sizes:
            moved = column >= 0
            factors[:, column[moved]] = np.broadcast_to(values, (len(factors), self.count))[:, moved]

    def overrides(self, drawn: Drawn) -> dict[str, object]:
        """Values of one sample by path, as `load` takes them; drawn : of one sample, (1, n)."""
        overrides: dict[str, object] = {}
        for name, value in drawn.items():
            path = self.table if self.kind in ("gap", "nothing") else f"{self.table}.{name}".removesuffix(".")
            z = self._spread(value)[0]
            numbers = {path: z.real} if name else {f"{path}.x": z.real, f"{path}.y": z.imag}
            overrides |= {key: values_text(size.tolist(), self.unit[name]) for key, size in numbers.items()}
        return overrides

    def _value(self, drawn: Drawn, name: str) -> Array:
        """Component (S, n) drawn, or nominal (1, n)."""
        if name in drawn:
            return np.asarray(self._spread(drawn[name]), float)
        return self.nominal.get(name, np.zeros(self.count))[None]

    def _spread(self, value: NDArray[np.inexact]) -> NDArray[np.inexact]:
        """Draws (S, n) from (S, n) or (S, 1)."""
        return np.broadcast_to(value, (len(value), self.count))


# from paths to tables -------------------------------------------------------------------------------------------------


def drawn_paths(path: str, *, vector: bool) -> tuple[str, str, Kind]:
    """Table, component ("" of a vector) and kind of a path below `deviations`.

    Raises
    ------
    ModelError : a path whose effect is not linear.
    """
    head, _, last = path.rpartition(".")
    if vector:
        return path, "", "vector"
    if ".meshes." in path:
        if last == "gap":
            return path, "gap", "gap"
        if ".errors." in path and last in ("amplitude", "phase"):
            return head, last, "error"
        if (path if last == "profile" else head).endswith(".profile"):
            return path, last, "nothing"
    elif last in _VECTORS:  # a number stands for the amplitude
        return path, "amplitude", "vector"
    elif head.rpartition(".")[2] in _VECTORS and last in ("x", "y", "z", "amplitude", "phase"):
        return head, last, "vector"
    elif (path if last == "unbalance" else head).endswith(".unbalance"):
        return path, last, "nothing"
    raise ModelError(
        "what it changes has no columns",
        path=f"tolerance.{path}",
        allowed="run_out, bearing_run_out, position, tilt; gap and errors of a mesh; torques, stiffnesses",
    )


def unit_overrides(
    tables: Mapping[str, tuple[Kind, Sequence[str]]], document: Mapping[str, object]
) -> dict[str, object]:
    """Overrides that give every component of the drawn tables a unit size: one load of the file has all columns.

    tables : path -> kind, components that are drawn.
    """
    overrides: dict[str, object] = {}
    for table, (kind, components) in tables.items():
        if kind == "gap":
            overrides[table] = f"{_UNIT} m"
        elif kind == "error":
            overrides |= {f"{table}.amplitude": f"{_UNIT} m", f"{table}.phase": "0 rad"}
        elif kind == "vector":
            stated = value_at(document, table.split("."))
            named = {*components, *(stated if isinstance(stated, Mapping) else ())}
            unit = f"{_UNIT} {'rad' if table.endswith('.tilt') else 'm'}"
            if named & {"", "x", "y", "amplitude", "phase"}:
                overrides |= {f"{table}.x": unit, f"{table}.y": unit}
            if "z" in named:
                overrides[f"{table}.z"] = unit
    return overrides


# columns --------------------------------------------------------------------------------------------------------------


def unit_deviations(
    train: Train, tables: Mapping[str, tuple[Kind, Sequence[str]]]
) -> tuple[list[Displacement | MeshError], list[tuple[str, int | None, str]]]:
    """Deviations of size 1 of every column, and of each its table, branch (None: none) and part (re, im, along).

    Parameters
    ----------
    train : resolved with `unit_overrides`.
    """
    items: list[Displacement | MeshError] = []
    keys: list[tuple[str, int | None, str]] = []
    branch: dict[str, int | None] = {body.name: body.branch for body in train.bodies}
    branch |= {mesh.name: mesh.branch for mesh in train.meshes}
    for displaced in train.displacements:
        if displaced.path in tables:
            for part, item in _displaced_units(displaced):
                items.append(item)
                keys.append((displaced.path, branch[displaced.body], part))
    for error in train.mesh_errors:
        if error.path in tables:
            parts = (("re", 1.0),) if error.cause == "gap" else (("re", 1.0), ("im", 1j))
            for part, factor in parts:
                items.append(replace(error, amplitude=error.amplitude / _UNIT * factor))
                keys.append((error.path, branch[error.mesh], part))
    return items, keys


def _displaced_units(item: Displacement) -> list[tuple[str, Displacement]]:
    """Displacements of size 1 for Re z and Im z, or along the axis, from one of size z = (1 + j) `_UNIT` or along.

    One stated from the stage's x axis has been turned into the body's own; so are these.
    """
    first = 3 if item.cause == "tilt" else 0
    size = item.vector[first : first + 3]
    if size[2]:
        return [("along", replace(item, vector=item.vector / _UNIT))]
    turns = item.frequency != 0
    z = size[0] if turns else size[0].real + 1j * size[1].real
    displacements = []
    for part, unit in (("re", 1.0), ("im", 1j)):
        size_one = z / (1 + 1j) / _UNIT * unit
        vector = np.zeros(6, complex)
        vector[first : first + 2] = (size_one, -1j * size_one) if turns else (size_one.real, size_one.imag)
        displacements.append((part, replace(item, vector=vector)))
    return displacements


def drawn_tables(
    document: Mapping[str, object],
    tables: Mapping[str, tuple[Kind, Sequence[str]]],
    entries: Mapping[str, Mapping[str, int]],
    given: Sequence[Tolerance],
    keys: Sequence[tuple[str, int | None, str]],
) -> tuple[list[DrawnTable], list[CodedText]]:
    """All tables that are drawn, and warnings of those without effect.

    Several features of one table and branch (both halves of a split member) have one column: the sum of theirs.

    Parameters
    ----------
    document : of the file.  entries : table -> component -> index of its entry among those `given`.
    keys : of every column, as of `unit_deviations`, each once.
    """
    column = {key: i for i, key in enumerate(keys)}
    deviations = read(document).model.deviations
    result, warnings = [], []
    for table, (kind, _) in tables.items():
        drawn = {name: given[index] for name, index in entries[table].items()}
        branches = sorted({branch for path, branch, _ in keys if path == table and branch is not None})
        owners: list[int | None] = [*branches] or [None] * max(entry.count for entry in drawn.values())
        across = [[column.get((table, branch, part), -1) for part in ("re", "im")] for branch in owners]
        along = [column.get((table, branch, "along"), -1) for branch in owners]
        stated = {} if kind in ("gap", "nothing") else _nominal(deviations, table, len(owners))
        drawn_table = DrawnTable(
            table=table,
            kind=kind,
            unit={name: entry.unit for name, entry in drawn.items()},
            entry=entries[table],
            nominal={name: value for name, value in stated.items() if name not in drawn},
            across=np.array(across, np.int64),
            along=np.array(along, np.int64),
        )
        if not drawn_table.effect:
            known = (why for name, why in _WITHOUT_EFFECT.items() if f".{name}" in table)
            why = next(known, "nothing holds what it moves, or it turns and no speed is given")
            warnings.append(coded("tolerance-without-effect", f"tolerance of {table} has no effect: {why}"))
        result.append(drawn_table)
    return result, warnings


def _nominal(deviations: object, table: str, count: int) -> dict[str, Array]:
    """Values (n,) of the components that the file states in a table [m, rad]."""
    path = table.removeprefix("deviations.")
    group = "meshes" if ".meshes." in path else "members"
    owner, _, kind = path.partition(".errors.") if ".errors." in path else path.rpartition(".")
    stated = getattr(deviations, group).get(owner)
    if stated is not None:
        stated = stated.errors.get(kind) if ".errors." in path else getattr(stated, kind, None)
    if stated is None:
        return {}
    values = {name: getattr(stated, name, None) for name in ("amplitude", "phase", "x", "y", "z")}
    return {
        name: np.broadcast_to(np.asarray(value, float), count) for name, value in values.items() if value is not None
    }


SAMPLES = 2**13
"""Samples that are worked on at once: products of one shape have the same bits whatever else is evaluated."""

# samples that a piece is filled up to at least: fewer cost hardly less
_LEAST_SAMPLES = 2**8


class Moved(NamedTuple):
    """A torque or stiffness that an entry draws.

    entry, planet : its index, and whose number it is, from 0.  mean : of the number.
    slope : (V,) stiffness of the rows that vary per unit of it.
    column : of its torque in the map, -1 where it moves none.
    """

    entry: int
    planet: int
    mean: float
    slope: Array
    column: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ToleranceMap:
    """Load sharing of a train as a function of its tolerances; made by `tolerance_map`.

    entries : drawing entries (E,).  dimension_entry : (d,) entry of every uniform number.
    mesh : (w,) names of the whole meshes.  pair, group : (g,) groups that carry load, their names and meshes.
    warnings : of the train, of tangents taken, of tolerances without effect.
    drawn_tables, moved : what entries draw.  correlations : of own draws.
    column : number of the size that each of the first columns of the map follows; behind them are torques.
    rows : (V,) rows of the map whose stiffness varies.  load_map : of the train with every torque and stiffness at its
        mean.  chosen : (g,) its groups that carry load.
    laws : of a train whose links have laws.  tables : of one whose meshes have tables, which ``static`` asks too.
    plays : entries of clearances, whose samples have laws of their own.  document : that these are loaded from.
    """

    entries: tuple[Tolerance, ...]
    dimension_entry: NDArray[np.int64]
    mesh: tuple[str, ...]
    pair: tuple[str, ...]
    group: tuple[NDArray[np.int64], ...]
    warnings: tuple[CodedText, ...]
    drawn_tables: tuple[DrawnTable, ...]
    moved: tuple[Moved, ...]
    correlations: tuple[Correlations, ...]
    column: NDArray[np.int64]
    rows: NDArray[np.int64]
    load_map: LoadMap
    chosen: NDArray[np.int64]
    laws: LawMap | None
    tables: LawMap | None
    plays: tuple[int, ...]
    document: Mapping[str, object]

    @property
    def lawful(self) -> bool:
        """Whether links follow laws, each sample of which takes an equilibrium at every phase."""
        return self.laws is not None

    @property
    def unmoved(self) -> frozenset[str]:
        """Paths of entries that move no column; `warnings` say why."""
        idle = [table for table in self.drawn_tables if not table.effect]
        return frozenset(self.entries[i].path for table in idle for i in table.entry.values())

    def evaluate(
        self,
        u: ArrayLike,
        *,
        scale: ArrayLike | None = None,
        torque: float = 1.0,
        method: ContactMethod = "auto",
        dense: bool = False,
    ) -> SampleLoads:
        """Load sharing of S samples, `SAMPLES` at a time, the last piece filled up to a power of two.

        Of the groups g that carry load; a sample in which one of them has no load of its nominal sense has failed, with
        nan in all but whether contact opens.

        Parameters
        ----------
        u : (S, d) uniform numbers in (0, 1).  scale : (E,) factors on the spread of each entry about its mean.
        torque : factor on all torques.  method : as of `sample_loads`.  dense : likewise.

        Raises
        ------
        ModelError : numbers of another shape or outside of (0, 1), a spread below zero, no such method.
        """
        uniform, factors, d = np.asarray(u, float), self._scale(scale), len(self.dimension_entry)
        if uniform.ndim != 2 or uniform.shape[1] != d:
            raise ModelError("wrong shape", path="u", given=uniform.shape, allowed=f"(samples, {d})")
        if not ((uniform > 0) & (uniform < 1)).all():
            raise ModelError("no uniform numbers", path="u", allowed="above 0 and below 1")
        if not len(uniform):
            g, w, no = len(self.group), len(self.mesh), np.zeros(0, bool)
            return SampleLoads(np.zeros((0, 2, g)), np.zeros((0, 2, w)), np.zeros((0, w)), no, no)
        pieces = [
            self._piece(uniform[first : first + SAMPLES], factors, torque, method, dense)
            for first in range(0, len(uniform), SAMPLES)
        ]
        return SampleLoads(*(np.concatenate(values) for values in zip(*pieces, strict=True)))

    def overrides(self, u_row: ArrayLike, *, scale: ArrayLike | None = None) -> dict[str, object]:
        """Overrides with which `load` resolves the train of one sample; u_row : (d,)."""
        drawn = self._draws(np.asarray(u_row, float)[None], self._scale(scale))
        overrides: dict[str, object] = {}
        for table in self.drawn_tables:
            overrides |= table.overrides({name: drawn[entry] for name, entry in table.entry.items()})
        for index in dict.fromkeys([*(number.entry for number in self.moved), *self.plays]):
            entry = self.entries[index]
            overrides[entry.path] = values_text(drawn[index][0].real.tolist(), entry.unit)
        return overrides

    def own_trains(
        self, u: Array, laws: LawMap | None, scale: Sequence[float]
    ) -> Callable[[int], HeldTrain | None] | None:
        """The train of each of S samples with the clearances that it draws; None of it where they are not allowed.

        None where no clearance is drawn.  u : (S, d) uniform numbers.  laws : of the map.  scale : (E,).
        """
        if laws is None or not self.plays:
            return None
        drawn, system = self._draws(u, scale), laws.held.system

        def own_train(sample: int) -> HeldTrain | None:
            values = {self.entries[i].path: (drawn[i][sample].real.tolist(), self.entries[i].unit) for i in self.plays}
            try:
                train = load(self.document, {path: values_text(*value) for path, value in values.items()})
            except ModelError:
                return None
            return held_train(replace(system, groups=assemble(train).groups))

        return own_train

    def with_entries(self, entries: Sequence[Tolerance]) -> ToleranceMap:
        """The same map with other distributions of the same paths; no structure is built anew.

        Raises
        ------
        ModelError : another number of uniform numbers.
        """
        new = tuple(entries)
        if not np.array_equal(_dimensions(new), self.dimension_entry):
            raise ModelError("draws of another dimension", path="entries", allowed="a number for a number")
        return replace(self, entries=new)

    def _scale(self, scale: ArrayLike | None) -> list[float]:
        """Factors (E,) on the spreads."""
        E = len(self.entries)
        values = np.ones(E) if scale is None else np.asarray(scale, float)
        if values.shape != (E,) or not (np.isfinite(values) & (values >= 0)).all():
            raise ModelError("no factors on spreads", path="scale", given=str(scale), allowed=f"{E} numbers >= 0")
        return list(map(float, values))

    def _draws(self, u: Array, scale: Sequence[float]) -> list[NDArray[np.inexact]]:
        """Draws (S, count) of every entry [SI]."""
        draws: list[NDArray[np.inexact]] = []
        at = 0
        first = {entry.path: int(np.searchsorted(self.dimension_entry, i)) for i, entry in enumerate(self.entries)}
        for correlation in self.correlations:
            u = correlation.applied(u, first)
        for entry, factor in zip(self.entries, scale, strict=True):
            value: NDArray[np.inexact] = np.zeros((len(u), 1))
            if entry.own is not None:
                own, size = entry.own.scaled(factor), entry.own.dimensions
                drawn = own.quantile(u[:, at : at + entry.count * size].reshape(len(u), entry.count, size))
                value = np.abs(drawn) if entry.phase == "marked" else drawn
                at += entry.count * size
            if entry.common is not None:
                common, size = entry.common.scaled(factor), entry.common.dimensions
                value = value + common.quantile(u[:, None, at : at + size])
                at += size
            draws.append(value)
        return draws

    def factors(self, u: Array, scale: Sequence[float], torque: float = 1.0) -> tuple[Array, Array]:
        """Factors (S, C) on the columns of the map, and stiffness (S, V) of its rows that vary [N/m].

        Parameters
        ----------
        u : (S, d) uniform numbers.  scale : (E,) factors on the spreads.  torque : factor on all torques.
        """
        drawn = self._draws(u, scale)
        sizes = np.zeros((len(u), int(self.column.max(initial=-1)) + 1))
        for table in self.drawn_tables:
            table.add(sizes, {name: drawn[entry] for name, entry in table.entry.items()})
        factors = np.zeros((len(u), len(self.load_map.stretch.column)))
        factors[:, : self.column.size] = sizes[:, self.column]
        stiffness = np.tile(self.load_map.flexible.stiffness[self.rows], (len(u), 1))
        for number in self.moved:
            change = drawn[number.entry][:, number.planet].real - number.mean
            stiffness += np.multiply.outer(change, number.slope)
            if number.column >= 0:
                factors[:, number.column] = torque * change
        return factors, stiffness

    def _piece(
        self, u: Array, scale: Sequence[float], torque: float, method: ContactMethod, dense: bool
    ) -> SampleLoads:
        """Load sharing of at most `SAMPLES` samples."""
        S = len(u)
        size = max(_LEAST_SAMPLES, 1 << (S - 1).bit_length())
        full = u if S == size else np.concatenate([u, np.broadcast_to(u[-1:], (size - S, u.shape[1]))])
        factors, stiffness = self.factors(full, scale, torque)
        if self.plays and method == "linear":
            problem = "clearances are drawn, and tangents know nothing of them"
            raise ModelError(problem, path="method", given=method, allowed="auto or static")
        laws = self.tables if method == "static" and self.tables is not None else self.laws
        loads = sample_loads(
            self.load_map,
            factors,
            torque=torque,
            rows=self.rows,
            stiffness=stiffness,
            method=method,
            count=S,
            laws=laws,
            held=self.own_trains(u, laws, scale),
            dense=dense,
        )
        k = loads.k[:, :, self.chosen]
        # without load, or with a load of the other sense, nothing is shared
        failed = loads.failed | ~np.isfinite(k).all(axis=(1, 2))
        return loads._replace(
            k=np.where(failed[:, None, None], np.nan, k),
            load=np.where(failed[:, None, None], np.nan, loads.load),
            least=np.where(failed[:, None], np.nan, loads.least),
            failed=failed,
        )


def _dimensions(entries: Sequence[Tolerance]) -> NDArray[np.int64]:
    """Entry of every uniform number, (d,): all own draws of an entry, then its common one."""
    own = [0 if entry.own is None else entry.count * entry.own.dimensions for entry in entries]
    common = [0 if entry.common is None else entry.common.dimensions for entry in entries]
    return np.repeat(np.arange(len(entries)), np.add(own, common))


def tolerance_map(train: Train, *, laws: bool = False) -> ToleranceMap:
    """The map of a train with tolerances.

    Torques and stiffnesses that are drawn stand at their mean in the map; deviations that are not drawn stay as the
    file states them.

    laws : whether samples are asked by equilibrium with the laws, also of a train without any, tables included.

    Raises
    ------
    ModelError : no tolerance; a path that is neither deviation, torque nor stiffness; no load.
    """
    entries = tolerances_of(train)
    document = {name: table for name, table in train.document.items() if name not in ("tolerance", "assumed")}
    if not entries:
        raise ModelError("no tolerance is given", path="tolerance", allowed='"PATH" = "normal(mean, deviation)"')
    stated: Any = train.document["tolerance"]
    tables: dict[str, tuple[Kind, list[str]]] = {}
    of_table: dict[str, dict[str, int]] = {}
    numbers: list[tuple[int, int]] = []  # entry and planet of each torque and stiffness
    plays = tuple(i for i, entry in enumerate(entries) if entry.path.rpartition(".")[2] in _PLAYS)
    for index, entry in enumerate(entries):
        if index in plays:
            continue
        if (seat := entry.path.rpartition(".")[0]).endswith(".internal_clearance"):
            problem, allowed = "a part of a clearance is not drawn", f'"{seat}", the clearance of the running bearing'
            raise ModelError(problem, path=f"tolerance.{entry.path}", given=stated.get(entry.path), allowed=allowed)
        if not entry.path.startswith("deviations."):
            numbers += [(index, planet) for planet in range(entry.count)]
            continue
        table, component, kind = drawn_paths(entry.path, vector=entry.vector)
        tables.setdefault(table, (kind, []))[1].append(component)
        of_table.setdefault(table, {})[component] = index
    drawn = [entries[index] for index in (*(index for index, _ in numbers), *plays)]
    at_means: dict[str, object] = {entry.path: values_text([mean_of(entry)], entry.unit) for entry in drawn}
    try:
        unit_train = load(document, {**at_means, **unit_overrides(tables, document)})
    except ModelError as error:
        if (refused := next((entry for entry in drawn if entry.path == error.path), None)) is None:
            raise
        problem, text = f"its mean {mean_of(refused):.6g} {refused.unit}: {error.problem}", stated.get(error.path)
        raise ModelError(problem, path=f"tolerance.{error.path}", given=text, allowed=error.allowed) from None
    items, keys = unit_deviations(unit_train, tables)
    names = list(dict.fromkeys(keys))
    deviated, notes = drawn_tables(document, tables, of_table, entries, names)
    bare = replace(
        unit_train,
        displacements=tuple(item for item in unit_train.displacements if item.path not in tables),
        mesh_errors=tuple(error for error in unit_train.mesh_errors if error.path not in tables),
    )
    exact = assemble(bare)
    base = linear(exact)
    for index in plays:
        check_play(document, at_means, entries[index])
    means = _assembled(document, at_means) if numbers else exact
    shifts = [shift_of(document, at_means, means, entries[index], planet) for index, planet in numbers]
    meshes, links = (
        np.flatnonzero(np.any([shift[of] for shift in shifts], axis=0)) if shifts else np.zeros(0, np.int64)
        for of in (0, 1)
    )
    torques = [force for _, _, force in shifts if force.any()]
    columns = [*unit_lines(unit_train, items), *(_torque_line(exact, force) for force in torques)]
    base_map = load_map(base, linear_columns(exact, columns), links=links)
    loaded = np.flatnonzero(nominal_signs(base_map)[1])
    if not loaded.size:
        problem = "load sharing needs a load, and no mesh carries any"
        raise ModelError(problem, path="operation.torque", allowed="a torque")
    sharing = np.zeros(len(base_map.face.name), bool)
    sharing[np.concatenate([base_map.group[i] for i in loaded])] = True
    torque_columns = iter(range(len(keys), len(columns)))
    with_tables = law_map(exact, columns, tables=True) if laws or exact.meshes.laws else None
    return ToleranceMap(
        entries=entries,
        dimension_entry=_dimensions(entries),
        mesh=base_map.face.name,
        pair=tuple(base_map.pair[i] for i in loaded),
        group=tuple(base_map.group[i] for i in loaded),
        warnings=(
            *base.warnings,
            *notes,
            *idle_warnings(base_map.face.name, sharing, "K_gamma"),
            *(text for text in train.warnings if code_of(text) == _LEFT),
        ),
        drawn_tables=tuple(deviated),
        correlations=correlations_of(train),
        moved=tuple(
            Moved(
                entry=index,
                planet=planet,
                mean=mean_of(entries[index]),
                slope=np.concatenate([mesh[meshes], link[links]]),
                column=next(torque_columns) if force.any() else -1,
            )
            for (index, planet), (mesh, link, force) in zip(numbers, shifts, strict=True)
        ),
        column=np.array([names.index(key) for key in keys], np.int64),
        rows=np.concatenate([meshes, base_map.mesh_count + base_map.far.size + np.arange(links.size)]).astype(np.int64),
        load_map=base_map,
        chosen=loaded,
        laws=with_tables if laws else law_map(exact, columns) if exact.groups else None,
        tables=with_tables,
        plays=plays,
        document={} if not plays else load(document, at_means).document,
    )


_LEFT = "tolerance-of-another-case"  # said of the train with its tolerances alone


def _torque_line(system: System, force: Array) -> Line:
    """Torques per unit of a number (n,), as a line that stands still."""
    loads = np.zeros((3, len(force)), complex)
    loads[0] = force
    return Line(
        frequency=Fraction(0),
        gap=np.zeros(len(system.meshes.name), complex),
        link_gap=np.zeros(len(system.links.name), complex),
        force=loads,
    )
