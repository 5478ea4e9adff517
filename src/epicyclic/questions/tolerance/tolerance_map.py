"""Tolerances of a train as a map from uniform numbers to load sharing: every draw moves columns of one load map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...document.tolerances import Correlations, Tolerance
from ...errors import ModelError
from ...statics.load_map import LawMap, LoadMap, law_map, load_map
from ...statics.sample_loads import ContactMethod, nominal_signs, sample_loads
from ...statics.tangent import linear, linear_columns
from ...system.assembly import assemble
from ...system.excitation import unit_lines
from ...system.system import Array, Line, System
from ...train.resolution import correlations_of, load, tolerances_of
from ...train.train import Train
from ...warning_codes import CodedText
from .drawn_deviations import (
    DrawnTable,
    Kind,
    drawn_paths,
    drawn_tables,
    mean_of,
    shift_of,
    unit_deviations,
    unit_overrides,
    values_text,
)

SAMPLES = 2**13
"""Samples that are worked on at once: products of one shape have the same bits whatever else is evaluated."""

# samples that a piece is filled up to at least: fewer cost hardly less
_LEAST_SAMPLES = 2**8


class SampleValues(NamedTuple):
    """Load sharing of S samples, definitions D "mean-load" and "mean-load-turning".

    k : (S, D, g) coefficient of every group [1].  load : (S, D, w) N F_i / sum F of each mesh [1].
    least : (S, w) least force of each mesh at any slow phases [N]; 0 or less: it separates; nan of pairs without load.
    open, failed : (S,) whether contact opens or a far flank touches; whether no state was found or a group carries no
        load of its nominal sense, with nan in all else.
    """

    k: Array
    load: Array
    least: Array
    open: NDArray[np.bool_]
    failed: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Moved:
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
    laws, tables : of a train whose links have laws, and of one whose meshes have tables, which ``static`` asks too.
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
    ) -> SampleValues:
        """Load sharing of S samples, `SAMPLES` at a time, the last piece filled up to a power of two.

        Parameters
        ----------
        u : (S, d) uniform numbers in (0, 1).  scale : (E,) factors on the spread of each entry about its mean.
        torque : factor on all torques.  method : as of `sample_loads`.  dense : likewise.

        Raises
        ------
        ModelError : numbers of another shape or outside of (0, 1), a spread below zero, no such method.
        """
        uniform = np.asarray(u, float)
        d = len(self.dimension_entry)
        if uniform.ndim != 2 or uniform.shape[1] != d:
            raise ModelError("wrong shape", path="u", given=uniform.shape, allowed=f"(samples, {d})")
        if not ((uniform > 0) & (uniform < 1)).all():
            raise ModelError("no uniform numbers", path="u", allowed="above 0 and below 1")
        factors = self._scale(scale)
        if not len(uniform):
            g, w, no = len(self.group), len(self.mesh), np.zeros(0, bool)
            return SampleValues(np.zeros((0, 2, g)), np.zeros((0, 2, w)), np.zeros((0, w)), no, no)
        pieces = [
            self._piece(uniform[first : first + SAMPLES], factors, torque, method, dense)
            for first in range(0, len(uniform), SAMPLES)
        ]
        return SampleValues(*(np.concatenate(values) for values in zip(*pieces, strict=True)))

    def overrides(self, u_row: ArrayLike, *, scale: ArrayLike | None = None) -> dict[str, object]:
        """Overrides with which `load` resolves the train of one sample; u_row : (d,)."""
        drawn = self._draws(np.asarray(u_row, float)[None], self._scale(scale))
        overrides: dict[str, object] = {}
        for table in self.drawn_tables:
            overrides |= table.overrides({name: drawn[entry] for name, entry in table.entry.items()})
        for index in dict.fromkeys(number.entry for number in self.moved):
            entry = self.entries[index]
            overrides[entry.path] = values_text(drawn[index][0].real.tolist(), entry.unit)
        return overrides

    def with_entries(self, entries: Sequence[Tolerance]) -> ToleranceMap:
        """The same map with other distributions of the same paths; no structure is built anew.

        Raises
        ------
        ModelError : another path, or another number of uniform numbers.
        """
        new = tuple(entries)
        paths = [entry.path for entry in self.entries]
        if [entry.path for entry in new] != paths:
            raise ModelError("other paths", path="entries", allowed=", ".join(paths))
        if not np.array_equal(_dimensions(new), self.dimension_entry):
            raise ModelError("draws of another dimension", path="entries", allowed="a number for a number")
        return replace(self, entries=new)

    def _scale(self, scale: ArrayLike | None) -> list[float]:
        """Factors (E,) on the spreads."""
        E = len(self.entries)
        values = np.ones(E) if scale is None else np.asarray(scale, float)
        if values.shape != (E,) or not (np.isfinite(values) & (values >= 0)).all():
            raise ModelError("no factors on spreads", path="scale", given=str(scale), allowed=f"{E} numbers >= 0")
        result: list[float] = values.tolist()
        return result

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
    ) -> SampleValues:
        """Load sharing of at most `SAMPLES` samples."""
        S = len(u)
        size = max(_LEAST_SAMPLES, 1 << (S - 1).bit_length())
        full = u if S == size else np.concatenate([u, np.broadcast_to(u[-1:], (size - S, u.shape[1]))])
        factors, stiffness = self.factors(full, scale, torque)
        loads = sample_loads(
            self.load_map,
            factors,
            torque=torque,
            rows=self.rows,
            stiffness=stiffness,
            method=method,
            count=S,
            laws=self.tables if method == "static" and self.tables is not None else self.laws,
            dense=dense,
        )
        k = loads.k[:, :, self.chosen]
        # without load, or with a load of the other sense, nothing is shared
        failed = loads.failed | ~np.isfinite(k).all(axis=(1, 2))
        return SampleValues(
            k=np.where(failed[:, None, None], np.nan, k),
            load=np.where(failed[:, None, None], np.nan, loads.load),
            least=np.where(failed[:, None], np.nan, loads.least),
            open=loads.open,
            failed=failed,
        )


def _dimensions(entries: Sequence[Tolerance]) -> NDArray[np.int64]:
    """Entry of every uniform number, (d,): all own draws of an entry, then its common one."""
    own = [0 if entry.own is None else entry.count * entry.own.dimensions for entry in entries]
    common = [0 if entry.common is None else entry.common.dimensions for entry in entries]
    return np.repeat(np.arange(len(entries)), np.add(own, common))


def tolerance_map(train: Train) -> ToleranceMap:
    """The map of a train with tolerances.

    Torques and stiffnesses that are drawn stand at their mean in the map; deviations that are not drawn stay as the
    file states them.

    Raises
    ------
    ModelError : no tolerance; a path that is neither deviation, torque nor stiffness; no load.
    """
    entries = tolerances_of(train)
    document = {name: table for name, table in train.document.items() if name not in ("tolerance", "assumed")}
    if not entries:
        raise ModelError("no tolerance is given", path="tolerance", allowed='"PATH" = "normal(mean, deviation)"')
    tables: dict[str, tuple[Kind, list[str]]] = {}
    of_table: dict[str, dict[str, int]] = {}
    numbers: list[tuple[int, int]] = []  # entry and planet of each torque and stiffness
    for index, entry in enumerate(entries):
        if not entry.path.startswith("deviations."):
            numbers += [(index, planet) for planet in range(entry.count)]
            continue
        table, component, kind = drawn_paths(entry.path, vector=entry.vector)
        tables.setdefault(table, (kind, []))[1].append(component)
        of_table.setdefault(table, {})[component] = index
    drawn = [entries[index] for index, _ in numbers]
    at_means: dict[str, object] = {entry.path: values_text([mean_of(entry)], entry.unit) for entry in drawn}
    unit_train = load(document, {**at_means, **unit_overrides(tables, document)})
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
    shifts = [shift_of(document, at_means, entries[index], planet) for index, planet in numbers]
    links = np.flatnonzero(np.any([shift.link for shift in shifts], axis=0)) if shifts else np.zeros(0, np.int64)
    meshes = np.flatnonzero(np.any([shift.mesh for shift in shifts], axis=0)) if shifts else np.zeros(0, np.int64)
    torques = [shift.force for shift in shifts if shift.force.any()]
    columns = [*unit_lines(unit_train, items), *(_torque_line(exact, force) for force in torques)]
    base_map = load_map(base, linear_columns(exact, columns), links=links)
    loaded = np.flatnonzero(nominal_signs(base_map)[1])
    if not loaded.size:
        problem = "load sharing needs a load, and no mesh carries any"
        raise ModelError(problem, path="operation.torque", allowed="a torque")
    torque_columns = iter(range(len(keys), len(columns)))
    return ToleranceMap(
        entries=entries,
        dimension_entry=_dimensions(entries),
        mesh=base_map.face.name,
        pair=tuple(base_map.pair[i] for i in loaded),
        group=tuple(base_map.group[i] for i in loaded),
        warnings=(*base.warnings, *notes),
        drawn_tables=tuple(deviated),
        correlations=correlations_of(train),
        moved=tuple(
            Moved(
                entry=index,
                planet=planet,
                mean=shift.mean,
                slope=np.concatenate([shift.mesh[meshes], shift.link[links]]),
                column=next(torque_columns) if shift.force.any() else -1,
            )
            for (index, planet), shift in zip(numbers, shifts, strict=True)
        ),
        column=np.array([names.index(key) for key in keys], np.int64),
        rows=np.concatenate([meshes, base_map.mesh_count + base_map.far.size + np.arange(links.size)]).astype(np.int64),
        load_map=base_map,
        chosen=loaded,
        laws=law_map(exact, columns) if exact.groups else None,
        tables=law_map(exact, columns, tables=True) if exact.meshes.laws else None,
    )


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
