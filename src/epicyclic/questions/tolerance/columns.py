"""What sampling, statistics, shares and curves ask of a map from uniforms to load factors.

Tolerances of a train as a map from uniform numbers to load sharing: every draw moves columns of one load map.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...document.correlation import Correlations
from ...document.tolerances import Tolerance
from ...errors import ModelError
from ...statics.load_map import LawMap, LoadMap, law_map, load_map
from ...statics.sample_loads import ContactMethod, nominal_signs, sample_loads
from ...statics.tangent import linear, linear_columns
from ...system.assembly import assemble
from ...system.excitation import unit_lines
from ...system.system import Array, Line, System
from ...train.resolution import load
from ...train.tolerances import correlations_of, tolerances_of
from ...train.train import Train
from ...warning_codes import CodedText
from .sources import (
    Kind,
    Shift,
    Source,
    drawn_paths,
    shift_of,
    sources_of,
    unit_deviations,
    unit_overrides,
    values_text,
)

if TYPE_CHECKING:
    from ...document.correlation import Correlations
    from ...document.tolerances import Tolerance


class SampledValues(Protocol):
    """Values of S samples: D definitions (`MEAN_LOADS`), g groups (pair and side), w meshes; nan of failed ones."""

    @property
    def k(self) -> Array:
        """Load factor of every group, (S, D, g) [1]."""

    @property
    def load(self) -> Array:
        """N F_i / sum F of every mesh, (S, D, w) [1]."""

    @property
    def least(self) -> Array:
        """Least force of every mesh, (S, w) [N]."""

    @property
    def open(self) -> NDArray[np.bool_]:
        """Whether contact opens or a link plays, (S,)."""

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Whether there is no solution, (S,)."""


class SampleMap(Protocol):
    """A map from uniforms to load factors: E drawing entries, d uniforms."""

    @property
    def entries(self) -> tuple[Tolerance, ...]:
        """Drawing entries, (E,)."""

    @property
    def dimension_entry(self) -> NDArray[np.int64]:
        """Entry of every uniform, (d,)."""

    @property
    def mesh(self) -> tuple[str, ...]:
        """Names of the whole meshes, (w,)."""

    @property
    def pair(self) -> tuple[str, ...]:
        """Names of the groups, pair and side, (g,)."""

    @property
    def correlations(self) -> tuple[Correlations, ...]:
        """Groups of entries whose draws are correlated."""

    @property
    def lawful(self) -> bool:
        """Whether links follow laws, each sample of which takes an equilibrium at every phase."""

    @property
    def unmoved(self) -> Collection[str]:
        """Paths of entries that move no column; `warnings` say why."""

    @property
    def warnings(self) -> tuple[CodedText, ...]:
        """What the user should know of the map."""

    def evaluate(
        self,
        u: Array,
        *,
        scale: Array | None = None,
        torque: float = 1.0,
        method: ContactMethod = "auto",
        dense: bool = False,
    ) -> SampledValues:
        """Values of (S, d) uniforms; scale : (E,) factors on the spreads.  torque : factor on the load.

        dense : open contact at many slow phases.
        """

    def overrides(self, u_row: Array, *, scale: Array | None = None) -> Mapping[str, object]:
        """What makes a model file that sample."""


SAMPLES = 2**13
"""Samples that are worked on at once: products of one shape have the same bits whatever else is evaluated."""

# samples that a piece is filled up to at least: fewer cost hardly less
_LEAST_SAMPLES = 2**8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampleValues:
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
    sources, moved : what entries draw.  correlations : of own draws.
    column : number of the sources' sizes that each of the first columns of the map follows; behind them are torques.
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
    sources: tuple[Source, ...]
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
        return frozenset(self.entries[i].path for one in self.sources if not one.effect for i in one.entry.values())

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
        pieces = [
            self._piece(uniform[first : first + SAMPLES], factors, torque, method, dense)
            for first in range(0, len(uniform), SAMPLES)
        ]
        names = ("k", "load", "least", "open", "failed")
        g, w = len(self.group), len(self.mesh)
        empty = {"k": (0, 2, g), "load": (0, 2, w), "least": (0, w), "open": (0,), "failed": (0,)}
        if not pieces:
            return SampleValues(
                **{name: np.zeros(shape, bool if len(shape) == 1 else float) for name, shape in empty.items()}
            )
        return SampleValues(**{name: np.concatenate([getattr(piece, name) for piece in pieces]) for name in names})

    def overrides(self, u_row: ArrayLike, *, scale: ArrayLike | None = None) -> dict[str, object]:
        """Overrides with which `load` resolves the train of one sample; u_row : (d,)."""
        drawn = self._draws(np.asarray(u_row, float)[None], self._scale(scale))
        found: dict[str, object] = {}
        for source in self.sources:
            found |= source.overrides({name: drawn[entry] for name, entry in source.entry.items()})
        for place in dict.fromkeys(one.entry for one in self.moved):
            own = self.entries[place]
            found[own.path] = values_text(drawn[place][0].real.tolist(), own.unit)
        return found

    def with_entries(self, entries: Sequence[Tolerance]) -> ToleranceMap:
        """The same map with other distributions of the same paths; no structure is built anew.

        Raises
        ------
        ModelError : another path, or another number of uniform numbers.
        """
        new = tuple(entries)
        if [one.path for one in new] != [one.path for one in self.entries]:
            raise ModelError("other paths", path="entries", allowed=", ".join(one.path for one in self.entries))
        places = _dimensions(new)
        if not np.array_equal(places, self.dimension_entry):
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
        found: list[NDArray[np.inexact]] = []
        at = 0
        first = {entry.path: int(np.searchsorted(self.dimension_entry, i)) for i, entry in enumerate(self.entries)}
        for correlation in self.correlations:
            u = correlation.applied(u, first)
        for entry, factor in zip(self.entries, scale, strict=True):
            value: NDArray[np.inexact] = np.zeros((len(u), 1))
            if entry.own is not None:
                own, size = entry.own.scaled(factor), entry.own.dimensions
                part = u[:, at : at + entry.count * size].reshape(len(u), entry.count, size)
                drawn = own.quantile(part)
                value = np.abs(drawn) if entry.phase == "marked" else drawn
                at += entry.count * size
            if entry.common is not None:
                common, size = entry.common.scaled(factor), entry.common.dimensions
                value = value + common.quantile(u[:, None, at : at + size])
                at += size
            found.append(value)
        return found

    def factors(self, u: Array, scale: Sequence[float], torque: float = 1.0) -> tuple[Array, Array]:
        """Factors (S, C) on the columns of the map, and stiffness (S, V) of its rows that vary [N/m].

        Parameters
        ----------
        u : (S, d) uniform numbers.  scale : (E,) factors on the spreads.  torque : factor on all torques.
        """
        drawn = self._draws(u, scale)
        sizes = np.zeros((len(u), int(self.column.max(initial=-1)) + 1))
        for source in self.sources:
            source.add(sizes, {name: drawn[entry] for name, entry in source.entry.items()})
        factors = np.zeros((len(u), len(self.load_map.stretch.column)))
        factors[:, : self.column.size] = sizes[:, self.column]
        stiffness = np.tile(self.load_map.flexible.stiffness[self.rows], (len(u), 1))
        for one in self.moved:
            change = drawn[one.entry][:, one.planet].real - one.mean
            stiffness += np.multiply.outer(change, one.slope)
            if one.column >= 0:
                factors[:, one.column] = torque * change
        return factors, stiffness

    def _piece(
        self, u: Array, scale: Sequence[float], torque: float, method: ContactMethod, dense: bool
    ) -> SampleValues:
        """Load sharing of at most `SAMPLES` samples."""
        S = len(u)
        size = max(_LEAST_SAMPLES, 1 << (S - 1).bit_length())
        full = u if S == size else np.concatenate([u, np.broadcast_to(u[-1:], (size - S, u.shape[1]))])
        factors, stiffness = self.factors(full, scale, torque)
        found = sample_loads(
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
        k = found.k[:, :, self.chosen]
        # without load, or with a load of the other sense, nothing is shared
        failed = found.failed | ~np.isfinite(k).all(axis=(1, 2))
        return SampleValues(
            k=np.where(failed[:, None, None], np.nan, k),
            load=np.where(failed[:, None, None], np.nan, found.load),
            least=np.where(failed[:, None], np.nan, found.least),
            open=found.open,
            failed=failed,
        )


def _dimensions(entries: Sequence[Tolerance]) -> NDArray[np.int64]:
    """Entry of every uniform number, (d,): all own draws of an entry, then its common one."""
    counts = [
        (0 if one.own is None else one.count * one.own.dimensions)
        + (0 if one.common is None else one.common.dimensions)
        for one in entries
    ]
    return np.repeat(np.arange(len(entries)), counts)


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
    moved: list[tuple[int, int]] = []
    for place, entry in enumerate(entries):
        if not entry.path.startswith("deviations."):
            moved += [(place, planet) for planet in range(entry.count)]
            continue
        table, component, kind = drawn_paths(entry.path, vector=entry.vector)
        tables.setdefault(table, (kind, []))[1].append(component)
        of_table.setdefault(table, {})[component] = place
    at_means: dict[str, object] = {
        entries[place].path: values_text([_mean(entries[place])], entries[place].unit) for place, _ in moved
    }
    unit_train = load(document, {**at_means, **unit_overrides(tables, document)})
    items, keys = unit_deviations(unit_train, tables)
    names = list(dict.fromkeys(keys))
    sources, notes = sources_of(document, tables, of_table, entries, names)
    bare = replace(
        unit_train,
        displacements=tuple(one for one in unit_train.displacements if one.path not in tables),
        mesh_errors=tuple(one for one in unit_train.mesh_errors if one.path not in tables),
    )
    exact = assemble(bare)
    base = linear(exact)
    shifts = [shift_of(document, at_means, entries[place], planet) for place, planet in moved]
    links = np.flatnonzero(np.any([shift.link for shift in shifts], axis=0)) if shifts else np.zeros(0, np.int64)
    meshes = np.flatnonzero(np.any([shift.mesh for shift in shifts], axis=0)) if shifts else np.zeros(0, np.int64)
    columns = [
        *unit_lines(unit_train, items),
        *(_torque_line(exact, shift.force) for shift in shifts if shift.force.any()),
    ]
    made = load_map(base, linear_columns(exact, columns), links=links)
    loaded = np.flatnonzero(nominal_signs(made)[1])
    if not loaded.size:
        allowed = "a torque"
        raise ModelError("load sharing needs a load, and no mesh carries any", path="operation.torque", allowed=allowed)
    place_of = {key: i for i, key in enumerate(names)}
    return ToleranceMap(
        entries=entries,
        dimension_entry=_dimensions(entries),
        mesh=made.face.name,
        pair=tuple(made.pair[i] for i in loaded),
        group=tuple(made.group[i] for i in loaded),
        warnings=(*base.warnings, *notes),
        sources=tuple(sources),
        correlations=correlations_of(train),
        moved=tuple(_moved(moved, shifts, meshes, links, len(keys))),
        column=np.array([place_of[key] for key in keys], np.int64),
        rows=np.concatenate([meshes, made.mesh_count + made.far.size + np.arange(links.size)]).astype(np.int64),
        load_map=made,
        chosen=loaded,
        laws=law_map(exact, columns) if exact.groups else None,
        tables=law_map(exact, columns, tables=True) if exact.meshes.laws else None,
    )


def _mean(entry: Tolerance) -> float:
    """Mean of the number of an entry [SI]."""
    return sum(float(one.mean.real) for one in (entry.own, entry.common) if one is not None)


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


def _moved(
    places: Sequence[tuple[int, int]],
    shifts: Sequence[Shift],
    meshes: NDArray[np.int64],
    links: NDArray[np.int64],
    column: int,
) -> Iterator[Moved]:
    """What the numbers of entries move; column : of the first torque among those of the map."""
    for (place, planet), shift in zip(places, shifts, strict=True):
        torque = bool(shift.force.any())
        yield Moved(
            entry=place,
            planet=planet,
            mean=shift.mean,
            slope=np.concatenate([shift.mesh[meshes], shift.link[links]]),
            column=column if torque else -1,
        )
        column += torque
