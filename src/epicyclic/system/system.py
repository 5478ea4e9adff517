"""The System: matrices, gaps with laws, exact excitation lines (docs/design.md, The one idea).

    M q'' + (C + s G) q' + (K + s^2 Kg) q + B f(B^T q - e(t)) = F(t)        s = speed / operating speed

with one column of B a mesh row, f_m = k_m(t) <B^T q - e>_m + c_m d/dt(...), all gaps along the tooth normal
(docs/conventions.md, The mesh row).  A mesh cut along the face has a row a slice; `faces` names whole meshes and sums
over them.

Rank of rows: A q = eps of rigid connections becomes q = T p + S eps, exactly, without penalty springs, by Gauss-Jordan
elimination with prescribed pivots (derived here).  With the rows of the mean stiffness weighted by the roots of
stiffness, W = [sqrt(k) b], it is W W^T.  A rigid motion strains no mesh and no link, whatever their stiffness:
kinematics tells it by the rank of the rows (derived here), the size of an eigenvalue does not.

Cyclic symmetry of a stage is the operator that rotates it by one branch (cyclic modes: [lin1999]).

A notebook shows which bodies the meshes and links of a System couple, and its key numbers.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, is_dataclass, replace
from fractions import Fraction
from functools import lru_cache
from html import escape
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError, needs_turning
from ..warning_codes import CodedText
from .flank_laws import LawRows
from .link_laws import LawGroup, Laws, stacked

Array = NDArray[np.float64]
Index = NDArray[np.int64]
ComplexArray = NDArray[np.complex128]
Number = TypeVar("Number", bound=np.inexact)
# Relative speeds this near to 1 are 1: rounding of a speed in Hz or rpm.
_AT_SPEED = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Dofs:
    """The reduced coordinates and how they expand to all coordinates of every body.

    names : (n,) ``main/sun/x``; body, direction : the two parts.
    radius : (n,) reference radius R of an rz coordinate (u = R rz) [m], 1 for the others.
    bodies : (nb,) every body of the train, in order.
    expand : (N, n) full displacement = expand @ q: of all bodies, in order, x y z rx ry rz in the body's own axes, then
    the coordinates by which bodies bend.  elastic : index of each body that bends, and the names of these, in order.
    """

    names: tuple[str, ...]
    body: tuple[str, ...]
    direction: tuple[str, ...]
    radius: Array
    bodies: tuple[str, ...]
    expand: Array
    elastic: tuple[tuple[int, tuple[str, ...]], ...] = ()

    @property
    def rigid(self) -> Array:
        """Expansion to x y z rx ry rz of every body, (6 nb, n)."""
        return self.expand[: 6 * len(self.bodies)]

    def __repr__(self) -> str:
        """One line: number of coordinates and of bodies."""
        return f"Dofs({len(self.names)} of {len(self.bodies)} bodies)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshRows:
    """The rows whose law varies in time or is unilateral: the meshes.

    name, pair, stage, branch (0 = none), side ("" = none) : (m,) labels.
    slice : (m,) number along the face from the left, from 1, of a mesh cut into slices (name ``.../3``); 0 = a whole
        mesh.  Empty = every row is a whole mesh.  The slices of one mesh are adjacent.
    ends : (m,) names of the bodies a and b.  internal : (m,) whether b is a ring.  direction : (m,) polar angle, in the
        axes of the stage, from the centre of a to the pitch point [rad]; of a ring mesh that of the contact seen from
        the centre of the ring.  These three are empty where not given.
    B : (n, m).  stiffness : (m,) mean, normal [N/m].
    variation : (m, L) complex, with the phase in it, f the tone of the mesh:
        k_m(t) = stiffness (1 + Re sum_l variation[m, l-1] exp(2 pi i l f t)).
    tone : (m,) index into System.tones.  damping : (m,) [N s/m].  backlash : (m,) [m].
    cos_base_helix : (m,) transverse = normal * cos_base_helix for forces.
    laws : of the rows that are not linear; stiffness and variation are their tangents at the operating load, which
        linear analyses use (`statics.tangent`).  All rows with their laws: `system.gaps.flanks`.
    """

    name: tuple[str, ...]
    pair: tuple[str, ...]
    stage: tuple[str, ...]
    branch: tuple[int, ...]
    side: tuple[str, ...]
    B: Array
    stiffness: Array
    variation: ComplexArray
    tone: NDArray[np.int64]
    damping: Array
    backlash: Array
    cos_base_helix: Array
    slice: tuple[int, ...] = ()
    ends: tuple[tuple[str, str], ...] = ()
    internal: tuple[bool, ...] = ()
    direction: Array = field(default_factory=lambda: np.zeros(0))
    laws: tuple[LawRows, ...] = ()

    def __repr__(self) -> str:
        """One line: number of rows, range of the mean stiffness, orders of its variation."""
        range_ = f"{self.stiffness.min():.4g} .. {self.stiffness.max():.4g} N/m, " if self.stiffness.size else ""
        return f"MeshRows({len(self.name)} rows, {range_}{self.variation.shape[1]} orders)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FarFlanks:
    """Rows of the flanks that carry no mean load, of the meshes whose backlash is finite.

    A far flank presses where B^T q - backlash - e > 0; stiffness, damping, backlash and tone are those of its mesh.

    mesh : (c,) which mesh row it belongs to.  B : (n, c).  variation : (c, L) complex, as of `MeshRows`.
    laws : of the rows that are not linear, their numbers among the c.
    """

    mesh: NDArray[np.int64]
    B: Array
    variation: ComplexArray
    laws: tuple[LawRows, ...] = ()

    def __repr__(self) -> str:
        """One line: number of rows."""
        return f"FarFlanks({len(self.mesh)} rows)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinkRows:
    """Linear rows of links, contained in K and C; kept for energies and forces.

    name : (p,) ``main/sun/support/x``.  link : (p,) ``main/sun/support``.  B : (n, p).
    stiffness : (p,) [N/m, N m/rad].  damping : (p,) [N s/m, N m s/rad].
    skew : (p, p) terms of dampers to the housing in a turning frame at s = 1, Cskew = B skew B^T [N/m, N m/rad]; empty
        where there are none.
    preload : (p,) force beside k (B^T q - e) of a linearised law [N, N m]; empty where there is none.
    turn : (p,) of the frame of a row against the housing that holds it, exact [rev/s], 0 of rows between bodies; empty
        where no frame turns.
    """

    name: tuple[str, ...]
    link: tuple[str, ...]
    B: Array
    stiffness: Array
    damping: Array
    skew: Array = field(default_factory=lambda: np.zeros((0, 0)))
    preload: Array = field(default_factory=lambda: np.zeros(0))
    turn: tuple[Fraction, ...] = ()

    def __repr__(self) -> str:
        """One line: number of rows and of links."""
        return f"LinkRows({len(self.name)} rows of {len(set(self.link))} links)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PassingRows:
    """What varies in the stiffness of links that pass a body, beside the mean that K and the links hold.

    K(t) = K + B diag(Re sum_l wave[:, l-1] exp(2 pi i l s f t)) B^T with f of the tone of each row.

    link : (r,) ``main/ring/support/bolts``.  B : (n, r).  wave : (r, L) complex [N/m].
    tones : exact [Hz at s = 1].  tone : (r,) index into them.
    """

    link: tuple[str, ...]
    B: Array
    wave: ComplexArray
    tones: tuple[Fraction, ...]
    tone: NDArray[np.int64]


class VaryingRows(NamedTuple):
    """Rows with a stiffness that varies about its mean, v of them: those of the meshes, then those of links that pass.

    B : (n, v).  wave : (v, L) complex [N/m].  tones : exact [Hz].  tone : (v,) index into them.
    of : (v,) stage or link.
    """

    B: Array
    wave: ComplexArray
    tones: tuple[Fraction, ...]
    tone: NDArray[np.int64]
    of: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Line:
    """One spectral line of the excitation at one exact frequency, the complex sum of all its causes.

    frequency : exact, >= 0 [Hz at the operating speed, s = 1].
    gap : (m,) complex; e_m(t) = Re(gap exp(2 pi i s f t)) of each mesh [m].
    link_gap : (p,) complex, the same of each linear link row.
    force : (3, n) complex; generalised force on the right side
        Re((force[0] + s force[1] + s^2 force[2]) exp(2 pi i s f t)): link errors times their stiffness, displaced
        inertia, gravity, unbalance, loads; mesh errors are in `gap` alone.
    causes : the paths in the model file that contribute to it.
    group_gap : (R,) complex, the error of each row of the groups, in order; empty where there are none.
    far_gap : (c,) complex, the error of each far flank [m]; empty where all are zero.
    ramp_force : (n,) complex, further force per s' while the speed changes [N s]; empty where there is none.
    ripple : (n,) complex, the part of force[0] that is torque ripple of shafts [N m]; empty where there is none.
    """

    frequency: Fraction
    gap: ComplexArray
    link_gap: ComplexArray
    force: ComplexArray
    causes: tuple[str, ...] = ()
    group_gap: ComplexArray = field(default_factory=lambda: np.zeros(0, complex))
    far_gap: ComplexArray = field(default_factory=lambda: np.zeros(0, complex))
    ramp_force: ComplexArray = field(default_factory=lambda: np.zeros(0, complex))
    ripple: ComplexArray = field(default_factory=lambda: np.zeros(0, complex))

    def __repr__(self) -> str:
        """One line: frequency, largest gap of a mesh, number of causes."""
        gap = float(np.abs(self.gap).max(initial=0.0))
        return f"Line({float(self.frequency):.6g} Hz, mesh gap {gap:.4g} m, {len(self.causes)} causes)"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ErrorRows:
    """Rows of the transmission errors on the coordinates (n,), side by side as `B` (n, 2 w + s).

    mesh : (w,) names of the whole meshes, first by rotation and then by approach.
    shaft : (s,) ``main.carrier by main.sun``: the shaft and those that drive it.
    turn : speed of every shaft, exact [rev/s]; 0 where it is not known.  B : (n, 2 w + s) [m, rad].
    """

    mesh: tuple[str, ...] = ()
    shaft: tuple[str, ...] = ()
    turn: Mapping[str, Fraction] = field(default_factory=dict)
    B: Array = field(default_factory=lambda: np.zeros((0, 0)))

    def by_kind(self, values: Array) -> dict[str, tuple[str, Array]]:
        """Values (2 w + s, ..) of the errors by their kind: dimension and values; nothing where there are none."""
        if not self.mesh:
            return {}
        w = len(self.mesh)
        kinds = {"rotation": ("mesh", values[:w]), "approach": ("mesh", values[w : 2 * w])}
        return {**kinds, **({"shaft": ("shaft", values[2 * w :])} if self.shaft else {})}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensorRows:
    """Sensors as rows that turn with the material of their body against its frame.

    With phi = 2 pi turn tau, tau = integral of s dt, and x_j = Re sum_k rows[j, k] exp(i k phi) . q the signal is

        x_0 of strain, rotation and force of a bolt        s^2 x_0 + s x_1' + s' x_1 / 2 + x_2'' of an acceleration
        mesh . F + link . L of a torque, of the forces of mesh rows and linear link rows

    name, kind, bodies : (s,) texts.  direction : (s,) of accelerations.  angle : (s,) in the frame at t = 0 [rad].
    turn : (s,) exact [rev/s at s = 1].  rows : (s, 3, K + 1, n) complex.  mesh : (s, m).  link : (s, p) [m, 1].
    """

    name: tuple[str, ...] = ()
    kind: tuple[str, ...] = ()
    bodies: tuple[tuple[str, ...], ...] = ()
    direction: tuple[str, ...] = ()
    angle: Array = field(default_factory=lambda: np.zeros(0))
    turn: tuple[Fraction, ...] = ()
    rows: ComplexArray = field(default_factory=lambda: np.zeros((0, 3, 1, 0), complex))
    mesh: Array = field(default_factory=lambda: np.zeros((0, 0)))
    link: Array = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def unit(self) -> tuple[str, ...]:
        """Unit of each signal."""
        units = {"strain": "1", "acceleration": "m/s2", "angle": "rad", "torque": "N m", "force": "N"}
        return tuple(units[kind] for kind in self.kind)

    def link_weights(self, rows: int) -> Array:
        """`link` of so many link rows (s, rows): those of linearised laws stand behind."""
        return np.pad(self.link, ((0, 0), (0, rows - self.link.shape[1])))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Symmetry:
    """Turning one stage by one branch: R on q, R^N = 1, commutes with M and K where the stage is cyclic.

    stage; branches : N; operator : (n, n); holds : whether it commutes with M, K and the mean meshes.
    """

    stage: str
    branches: int
    operator: Array
    holds: bool

    def __repr__(self) -> str:
        """One line: stage, branches, whether it holds."""
        return f"Symmetry({self.stage!r}, {self.branches} branches, holds {self.holds})"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class System:
    """A train at an operating point, as numbers.

    M, C, G, K, Kg : (n, n); G and Kg at the operating speed (s = 1).  K contains the linear links, neither the meshes
    nor the groups.
    C contains dampers of connections and proportional damping; `zeta` is modal damping (ratio of every elastic mode of
    the mean system, in the frame of the coordinates), None where it is not given.
    Cskew : (n, n) stiffness-like skew terms of dampers to the housing in a turning frame; they scale with s.
    force : (n,) steady external force, torques included, without gap contributions.
    tones : mesh frequencies, exact [Hz at s = 1]; empty where no speed is given.
    lines : excitation lines, distinct frequencies, rising; the line of frequency 0 has the constant errors.
    body_mass : (nb, 6) mass and inertia of every body's six coordinates, for kinetic-energy shares.  bent_mass : (N, N)
    what bodies that bend have beside it; empty where none does.
    warnings : physical warnings of the train and its assembly.  provenance : attributes for every result.
    missing_inertia : paths of masses and inertias that a free coordinate needs but the file does not give (zero in M);
        an analysis that needs M calls `require_inertia`.
    groups : links with a law (play, rolling elements, spline); linear analyses use their tangents
        (`statics.tangent.linear`).
    body_turns : (nb,) absolute speed of every body, exact [rev/s at s = 1]; empty where no speed is given.
    stage_turns : the same of the axes of every stage, by its name.
    far : the far flanks, for analyses of contact loss; None without finite backlash.
    euler : (n, n) terms s' E q on the left side while the speed changes; empty: none are known.
    spin_up : (n,) inertial load of the nominal motion per s', on the right side [N s]; empty: none is known.
    errors : rows of the transmission errors.  sensors : of the file.
    passing : links that pass a body, for analyses whose stiffness varies in time; None: all have their mean.
    unscaled : paths of ripple at frequencies that do not follow the speed: see `require_scaling`.
    scaled : the lines without these, where there are any.
    locked : of a train that what is held locks the torque on every body that carries one [N m]; None: the train turns.
    bearings : path of every seat of several named bearings -> their names, those without stiffness among them.
    """

    dofs: Dofs
    M: Array
    C: Array
    G: Array
    K: Array
    Kg: Array
    Cskew: Array
    meshes: MeshRows
    links: LinkRows
    force: Array
    tones: tuple[Fraction, ...] = ()
    lines: tuple[Line, ...] = ()
    zeta: float | None = None
    body_mass: Array = field(default_factory=lambda: np.zeros((0, 6)))
    bent_mass: Array = field(default_factory=lambda: np.zeros((0, 0)))
    symmetries: tuple[Symmetry, ...] = ()
    warnings: tuple[CodedText, ...] = ()
    provenance: dict[str, str] = field(default_factory=dict)
    missing_inertia: tuple[str, ...] = ()
    groups: tuple[LawGroup, ...] = ()
    body_turns: tuple[Fraction, ...] = ()
    stage_turns: Mapping[str, Fraction] = field(default_factory=dict)
    far: FarFlanks | None = None
    euler: Array = field(default_factory=lambda: np.zeros((0, 0)))
    spin_up: Array = field(default_factory=lambda: np.zeros(0))
    unscaled: frozenset[str] = frozenset()
    scaled: tuple[Line, ...] = ()
    locked: Mapping[str, float] | None = None
    bearings: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    errors: ErrorRows = field(default_factory=ErrorRows)
    sensors: SensorRows = field(default_factory=SensorRows)
    passing: PassingRows | None = None

    def __post_init__(self) -> None:
        """Make the arrays read-only: what follows from a System is kept by its identity."""
        held = [getattr(self, name) for name in self.__dataclass_fields__]
        parts = [part for value in held for part in (value if isinstance(value, tuple) else (value,))]
        for part in filter(is_dataclass, (self, *parts)):
            for name in part.__dataclass_fields__:
                values = getattr(part, name)
                while isinstance(values, np.ndarray):  # and what it is a view of
                    values.flags.writeable, values = False, values.base

    def __repr__(self) -> str:
        """One line: title, numbers of coordinates, meshes, links and laws, mesh frequencies, lines and damping."""
        title = self.provenance.get("title", "")
        tones = ", ".join(f"{float(tone):.5g} Hz" for tone in self.tones) or "no speed"
        rows = f"{len(self.meshes.name)} mesh rows, {len(self.links.name)} link rows, {len(self.groups)} laws"
        return (
            f"System({title!r}: {len(self.dofs.names)} dofs, {rows}, {tones}, {len(self.lines)} lines, "
            f"damping {damping_text(self)})"
        )

    def _repr_html_(self) -> str:
        """Coupling pattern and key numbers, for notebooks: one well-formed HTML element, without outside references."""
        rows = "".join(f"<tr><td>{escape(name)}</td><td>{escape(text)}</td></tr>" for name, text in _facts(self))
        title = escape(str(self.provenance.get("title", "")))
        return f"<div><p><b>{title}</b></p>{_pattern(self)}<table>{rows}</table></div>"

    @property
    def far_flanks(self) -> FarFlanks:
        """The far flanks, none of them where no backlash is finite."""
        n, L = len(self.force), self.meshes.variation.shape[1]
        none = np.zeros(0, np.int64)
        return self.far or FarFlanks(mesh=none, B=np.zeros((n, 0)), variation=np.zeros((0, L), complex))

    def flank_gaps(self, line: Line) -> ComplexArray:
        """Errors of all mesh rows and then of all far flanks, (m + c,) [m]."""
        far = self.far_flanks.mesh.size
        return np.concatenate([line.gap, line.far_gap if line.far_gap.size else np.zeros(far, complex)])

    @property
    def flank_opening(self) -> Array:
        """What all mesh rows and then all far flanks are open by without any displacement, (m + c,) [m].

        Loaded flanks touch and far ones are open by the backlash; of a locked train, whose torque may pass through
        zero, both are open by half of it where it is finite.
        """
        loaded, far = np.zeros(len(self.meshes.name)), self.far_flanks.mesh
        behind = self.meshes.backlash[far]
        if self.locked is not None:
            behind = behind / 2
            loaded[far] = behind
        return np.concatenate([loaded, behind])

    @property
    def laws(self) -> Laws:
        """Laws of the groups as arrays."""
        return stacked(self.groups)

    @property
    def varying(self) -> VaryingRows:
        """Rows of the meshes and of links that pass a body, with what varies in their stiffness."""
        meshes, passing = self.meshes, self.passing
        wave = meshes.stiffness[:, None] * meshes.variation
        if passing is None:
            return VaryingRows(meshes.B, wave, self.tones, meshes.tone, meshes.stage)
        width = max(wave.shape[1], passing.wave.shape[1])
        waves = [np.pad(one, ((0, 0), (0, width - one.shape[1]))) for one in (wave, passing.wave)]
        return VaryingRows(
            np.concatenate([meshes.B, passing.B], axis=1),
            np.concatenate(waves),
            self.tones + passing.tones,
            np.concatenate([meshes.tone, passing.tone + len(self.tones)]),
            meshes.stage + passing.link,
        )

    @property
    def error_rows(self) -> Array:
        """Columns of the transmission errors, (n, k), none of them where they are not known."""
        return self.errors.B if self.errors.mesh else np.zeros((len(self.force), 0))

    @property
    def group_rows(self) -> Array:
        """Columns of all groups side by side, (n, R)."""
        return np.concatenate([np.zeros((len(self.force), 0)), *(group.B for group in self.groups)], axis=1)

    @property
    def damped(self) -> bool:
        """Whether any damping is given."""
        return self.zeta is not None or bool(np.any(self.C)) or bool(np.any(self.meshes.damping))

    @property
    def mean_stiffness(self) -> Array:
        """K plus the mean meshes, (n, n) [N/m]."""
        B = self.meshes.B
        return self.K + (B * self.meshes.stiffness) @ B.T

    @property
    def mean_damping(self) -> Array:
        """C plus the dampers of the meshes, (n, n) [N s/m]."""
        B = self.meshes.B
        return self.C + (B * self.meshes.damping) @ B.T

    def with_lines(self, frequencies: Iterable[Fraction]) -> System:
        """The System with a line, empty where it has none, at each of the given frequencies [Hz]."""
        n, rows, links, groups = (B.shape[-1] for B in (self.M, self.meshes.B, self.links.B, self.group_rows))
        gap, link_gap, group_gap, force = (np.zeros(size, complex) for size in (rows, links, groups, (3, n)))
        empty = Line(frequency=Fraction(0), gap=gap, link_gap=link_gap, force=force, group_gap=group_gap)
        lines = {frequency: replace(empty, frequency=frequency) for frequency in frequencies}
        lines |= {line.frequency: line for line in self.lines}
        return replace(self, lines=tuple(lines[frequency] for frequency in sorted(lines)))

    def require_turning(self) -> None:
        """Raise ModelError of a locked train, for a question that asks for speeds."""
        if self.locked is not None:
            raise needs_turning()

    @property
    def scaling(self) -> System:
        """The System without the lines whose frequencies do not follow the speed; itself where all do."""
        return replace(self, lines=self.scaled, unscaled=frozenset()) if self.unscaled else self

    def require_scaling(self, speed: Array) -> None:
        """Raise ModelError for lines whose frequency does not follow the speed, at relative speeds other than 1."""
        if self.unscaled and np.any(np.abs(speed - 1) > _AT_SPEED):
            raise ModelError(
                "does not follow the speed, and another speed than that of operation is asked for",
                path=f"{min(self.unscaled)}.frequency",
                allowed="order, which follows the speed of a shaft; or the operating speed alone",
            )

    def require_inertia(self) -> None:
        """Raise ModelError naming the first mass or inertia that is missing for a free coordinate."""
        if self.missing_inertia:
            raise ModelError(
                f"not given, and not derivable, but needed for modes and response ({len(self.missing_inertia)} such)",
                path=self.missing_inertia[0],
                allowed="a value, or `bore`, `rim` or `outer_diameter` to derive it from",
            )


# whole meshes ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Faces:
    """The w whole meshes of a System with m mesh rows.

    name : (w,) of each.  row : (m,) mesh of each row.  first : (w,) first row of each, whose labels are those of the
    mesh.  count : (w,) rows of each, 1 without slices.
    """

    name: tuple[str, ...]
    row: NDArray[np.int64]
    first: NDArray[np.int64]
    count: NDArray[np.int64]

    @property
    def cut(self) -> NDArray[np.bool_]:
        """(m,) rows that are slices of a mesh."""
        return np.asarray(self.count[self.row] > 1, bool)

    def total(self, values: NDArray[Number], axis: int = 0) -> NDArray[Number]:
        """Sums (..., w, ...) over the rows of each mesh of values (..., m, ...), in their unit, along `axis`.

        The values themselves where no mesh is cut.
        """
        return np.add.reduceat(values, self.first, axis=axis) if self.cut.any() else values

    def least(self, values: Array, axis: int = 0) -> Array:
        """Smallest value (..., w, ...) of the rows of each mesh, of values (..., m, ...), in their unit."""
        return np.minimum.reduceat(values, self.first, axis=axis)

    def load_factor(self, largest: Array, total: Array) -> Array:
        """Face-load factor (w,) [1] of largest forces of a slice and sums of all [N]; nan of a mesh in one piece."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where((self.count > 1) & (total > 0), self.count * largest / total, np.nan)

    def any(self, values: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(w,) meshes of which any row (m,) is true."""
        return np.asarray(np.logical_or.reduceat(values, self.first), bool)


@lru_cache(maxsize=32)  # of one train many ask
def faces(meshes: MeshRows) -> Faces:
    """Whole meshes of mesh rows; the slices of one mesh are adjacent."""
    number = meshes.slice or (0,) * len(meshes.name)
    names = [name.rpartition("/")[0] if k else name for name, k in zip(meshes.name, number, strict=True)]
    whole = {name: i for i, name in enumerate(dict.fromkeys(names))}
    row = np.array([whole[name] for name in names], np.int64)
    return Faces(
        name=tuple(whole),
        row=row,
        first=np.flatnonzero(np.diff(row, prepend=-1)),
        count=np.bincount(row, minlength=len(whole)),
    )


# Entries below this share of the largest one in a row are rounding of eliminations.
NEGLIGIBLE = 1e-12
# Singular values of rows of unit length that are zero: rounding of rows is 1e-15, and radii printed to eight digits fit
# one centre distance to 1e-8; rows that hold a motion on purpose have 1e-3 (a narrow face against tilt) and more.
_RANK = 1e-8
# What K has beside its links, per geometric mean of its diagonal: rounding of the sum.
REST = 1e-12


def eliminate(constraints: Array, pivots: NDArray[np.int64]) -> tuple[Array, Array, NDArray[np.int64]]:
    """Solve the constraints for as many coordinates as their rank.

    Parameters
    ----------
    constraints : (c, N) rows A of A q = eps, in units that make their entries comparable.
    pivots : (c,) the coordinate for which each row is solved if its coefficient is not negligible.

    Returns
    -------
    T : (N, n) so that q = T p satisfies A q = 0; columns of kept coordinates are unit at that coordinate.
    S : (N, c) so that q = T p + S eps satisfies A q = eps, as far as the rows are independent.
    kept : (n,) the coordinates that remain.
    """
    count, size = constraints.shape
    A = constraints.copy()
    S = np.zeros((size, count))
    active = np.ones(size, bool)
    scale = np.abs(A).max(axis=1, initial=0.0)
    pending = scale > 0
    # Rows with one free coordinate determine it, many in a pass; that may leave other rows with one.
    while True:
        live = ((np.abs(A) > NEGLIGIBLE * scale[:, None]) & active).sum(axis=1)
        pending &= live > 0
        single = np.flatnonzero(pending & (live == 1))
        if not single.size:
            break
        columns, first = np.unique(np.abs(A[single] * active).argmax(axis=1), return_index=True)
        rows = single[first]
        right = -A[rows] @ S
        right[np.arange(rows.size), rows] += 1.0
        S[columns] = right / A[rows, columns][:, None]
        active[columns] = False
        pending[rows] = False
    T = np.zeros((size, size))
    T[active, active] = 1.0
    for row in np.flatnonzero(pending).tolist():
        reduced, pivot, least = A[row] @ T, int(pivots[row]), NEGLIGIBLE * scale[row]
        if abs(reduced[pivot]) <= least:
            pivot = int(np.argmax(np.abs(reduced)))
        if abs(reduced[pivot]) <= least:
            continue
        right = -(A[row] @ S)
        right[row] += 1.0
        column = T[:, pivot].copy()
        S += np.outer(column, right / reduced[pivot])
        T -= np.outer(column, reduced / reduced[pivot])
        T[:, pivot] = 0.0
    kept = np.flatnonzero(T.any(axis=0))
    return T[:, kept], S, kept


def stiffness_rows(system: System) -> Array | None:
    """Rows W (n, R) [sqrt(N/m)] with W W^T the mean stiffness: meshes, links, and what else K holds.

    None where a part of it is negative.
    """
    meshes = system.meshes
    if np.any(system.links.stiffness < 0) or np.any(meshes.stiffness < 0):
        return None
    elastic = _elastic(system)
    return None if elastic is None else np.concatenate([meshes.B * np.sqrt(meshes.stiffness), elastic], axis=1)


def elastic_rows(system: System, without: Sequence[int] | NDArray[np.int64] = ()) -> Array:
    """Rows W (n, R) [sqrt(N/m)] with W W^T = K: links, those `without` left out of it, and what else K holds.

    Raises
    ------
    ModelError : K is negative along some motion.
    """
    elastic = _elastic(system, without)
    if elastic is None:
        raise ModelError("the stiffness of links is negative along some motion", path="stages", allowed="0 or more")
    return elastic


def _elastic(system: System, without: Sequence[int] | NDArray[np.int64] = ()) -> Array | None:
    """Rows (n, R) of links but those `without`, and of what else K holds than links; None where that is negative."""
    links, k = system.links, system.links.stiffness
    linear = np.isfinite(k) & (k > 0)
    rows = links.B[:, linear] * np.sqrt(k[linear])
    rest = system.K - rows @ rows.T
    size = np.sqrt(np.maximum(np.diag(system.K), 0.0))
    rest[np.abs(rest) <= REST * np.outer(size, size)] = 0.0
    further = _factor((rest + rest.T) / 2)
    kept = ~np.isin(np.flatnonzero(linear), without)
    return None if further is None else np.concatenate([rows[:, kept], further], axis=1)


def _factor(matrix: Array) -> Array | None:
    """F (n, r) with F F^T a symmetric matrix (n, n) without negative eigenvalues; None where it has some."""
    if not matrix.any():
        return np.zeros((len(matrix), 0))
    size = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    scale = np.where(size > 0, size, 1.0)
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    limit = REST * len(values) * float(np.abs(values).max())
    if values[0] < -limit:
        return None
    kept = values > limit
    return np.asarray(scale[:, None] * vectors[:, kept] * np.sqrt(values[kept]))


def free_motions(rows: Array) -> tuple[Array, Array]:
    """Orthonormal bases of the motions that strain no row, (n, r), and of the others, (n, n - r).

    rows : (n, R) in comparable coordinates, as those of unit mass; their lengths do not count.
    """
    length = np.linalg.norm(rows, axis=0)
    left, size, _ = np.linalg.svd(rows[:, length > 0] / length[length > 0])
    rank = int(np.count_nonzero(size > _RANK * float(size.max(initial=0.0))))
    return left[:, rank:], left[:, :rank]


# Angles and stiffnesses of a drawing carry about 1e-12 of rounding; a real asymmetry is far above.
_TOLERANCE = 1e-9


def turn_operator(size: int, *, moves: Sequence[tuple[slice, slice]], turned: Sequence[int], angle: float) -> Array:
    """Operator that rotates the displacements of a stage by one branch.

    Parameters
    ----------
    size : N, the number of all coordinates.
    moves : (from, to) coordinates of the bodies on branches; their own axes rotate with them.
    turned : indices of bodies on the axis, whose x y and rx ry rotate by `angle` [rad].

    Returns
    -------
    (N, N) [1]; identity on all other coordinates.
    """
    R = np.eye(size)
    for source, _ in moves:
        R[source, source] = 0.0
    for source, target in moves:
        R[target, source] = np.eye(source.stop - source.start)
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.array([[c, -s], [s, c]])
    for body in turned:
        for i in (6 * body, 6 * body + 3):
            R[i : i + 2, i : i + 2] = rotation
    return R


def reduced_operator(R: Array, expand: Array) -> Array | None:
    """Operator R (N, N) on the reduced coordinates, (n, n) [1]; None where rigid connections break the symmetry.

    expand : (N, n), q_full = expand @ q.
    """
    moved = R @ expand
    # every column has a unit entry of its own, so the normal equations are well conditioned; the residual is checked
    reduced = np.linalg.solve(expand.T @ expand, expand.T @ moved)
    off = np.abs(expand @ reduced - moved).max(initial=0.0)
    return np.asarray(reduced, np.float64) if off <= _TOLERANCE * max(1.0, np.abs(expand).max(initial=1.0)) else None


def commutes(R: Array, matrix: Array) -> bool:
    """Whether R' matrix R = matrix within rounding, (n, n), entry by entry on the scale of the diagonal."""
    diagonal = np.sqrt(np.abs(np.diag(matrix)))
    scale = np.maximum(np.outer(diagonal, diagonal), 1e-12 * float(np.max(diagonal, initial=0.0)) ** 2)
    difference = np.abs(R.T @ matrix @ R - matrix)
    return bool(np.all(difference <= _TOLERANCE * np.where(scale > 0, scale, 1.0)))


_CELL, _LABEL = 13, 10  # side of a cell of the pattern and size of its letters [px]
_MESH, _LINK, _BODY = "#e07b39", "#6ea8d8", "#c8c8c8"  # colours of couplings and of a body with itself


def damping_text(system: System) -> str:
    """What damping is given: the ratio of the modes, dampers of connections, or none."""
    dampers = bool(np.any(system.C)) or bool(np.any(system.meshes.damping))
    named = ([] if system.zeta is None else [f"modal {system.zeta:.4g}"]) + ["dampers"] * dampers
    return ", ".join(named) or "none"


def _facts(system: System) -> list[tuple[str, str]]:
    meshes, slices = system.meshes, sum(number > 0 for number in system.meshes.slice)
    laws = Counter(group.law.kind for group in system.groups)
    facts = [
        ("degrees of freedom", f"{len(system.dofs.names)} of {len(set(system.dofs.body))} bodies"),
        ("mesh rows", f"{len(meshes.name)}" + (f", {slices} of them slices" if slices else "")),
        ("mean mesh stiffness [N/m]", _range(meshes.stiffness)),
        ("far flanks", str(len(system.far.mesh)) if system.far is not None else "none"),
        ("meshes with a law", f"{sum(len(block.rows) for block in meshes.laws)} rows" if meshes.laws else ""),
        ("linear link rows", str(len(system.links.name))),
        ("links with a law", ", ".join(f"{count} {kind}" for kind, count in laws.items()) or "none"),
        ("mesh frequencies [Hz]", ", ".join(f"{float(tone):.5g}" for tone in system.tones) or "no speed given"),
        ("excitation lines", str(len(system.lines))),
        ("damping", damping_text(system)),
        ("cyclic stages", ", ".join(f"{s.stage} ({s.branches})" for s in system.symmetries if s.holds) or "none"),
        ("missing inertia", ", ".join(system.missing_inertia)),
    ]
    return [(name, text) for name, text in facts if text]


def _range(values: NDArray[np.float64]) -> str:
    known = values[np.isfinite(values)]
    if not known.size:
        return ""
    low, high = float(known.min()), float(known.max())
    return f"{low:.4g}" if high - low <= 1e-9 * abs(high) else f"{low:.4g} .. {high:.4g}"


def _pattern(system: System) -> str:
    """Bodies against bodies as SVG: coupled by a mesh below and by links above the diagonal, both in one cell."""
    names = list(dict.fromkeys(system.dofs.body))
    owner = np.array([names.index(body) for body in system.dofs.body])
    groups = [system.links.B, *(group.B for group in system.groups)]
    meshes, links = _coupled(system.meshes.B, owner), _coupled(np.concatenate(groups, axis=1), owner)
    left = 0.62 * _LABEL * max((len(name) for name in names), default=0) + 6
    cells = [_cell(left, i, i, _BODY, name) for i, name in enumerate(names)]
    for i, j in sorted(links | meshes):
        for row, column, by_link in ((i, j, (i, j) in links), (j, i, (i, j) not in meshes)):
            colour, kind = (_LINK, "link") if by_link else (_MESH, "mesh")
            cells.append(_cell(left, row, column, colour, f"{names[i]}, {names[j]}: {kind}"))
    labels = "".join(
        f'<text x="{left - 4:.1f}" y="{_CELL * i + _LABEL:.1f}">{escape(name)}</text>' for i, name in enumerate(names)
    )
    size, foot = _CELL * len(names), _CELL * len(names) + _LABEL + 6
    legend = (
        f'<rect x="{left:.1f}" y="{foot - 9}" width="9" height="9" fill="{_MESH}"/>'
        f'<rect x="{left + 60:.1f}" y="{foot - 9}" width="9" height="9" fill="{_LINK}"/>'
        f'<g text-anchor="start"><text x="{left + 13:.1f}" y="{foot}">mesh</text>'
        f'<text x="{left + 73:.1f}" y="{foot}">link</text></g>'
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{max(left + size, left + 110):.0f}" height="{foot + 6}" '
        f'font-family="sans-serif" font-size="{_LABEL}" text-anchor="end" fill="currentColor">'
        f"{labels}{''.join(cells)}{legend}</svg>"
    )


def _coupled(B: NDArray[np.float64], owner: NDArray[np.int64]) -> set[tuple[int, int]]:
    """Pairs i < j of bodies that some row, a column of B (n, R), couples; owner : (n,) body of each coordinate."""
    pairs: set[tuple[int, int]] = set()
    for column in np.abs(B).T:
        touched = sorted(set(owner[column > NEGLIGIBLE * column.max(initial=0.0)].tolist()))
        pairs |= {(i, j) for k, i in enumerate(touched) for j in touched[k + 1 :]}
    return pairs


def _cell(left: float, row: int, column: int, colour: str, text: str) -> str:
    return (
        f'<rect x="{left + _CELL * column:.1f}" y="{_CELL * row}" width="{_CELL - 1}" height="{_CELL - 1}" '
        f'fill="{colour}"><title>{escape(text)}</title></rect>'
    )
