"""The System: matrices, gaps with laws, exact excitation lines (docs/design.md, The one idea).

    M q'' + (C + s G) q' + (K + s^2 Kg) q + B f(B^T q - e(t)) = F(t)        s = speed / operating speed

with one column of B a mesh row, f_m = k_m(t) <B^T q - e>_m + c_m d/dt(...), all gaps along the tooth normal
(docs/conventions.md, The mesh row).  A mesh cut along the face has a row a slice; `faces` names whole meshes and sums
over them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..warning_codes import CodedText
from .display import damping_text, system_html
from .flank_laws import LawRows
from .group_laws import LawGroup, Laws, stacked

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Number = TypeVar("Number", bound=np.inexact)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Dofs:
    """The reduced coordinates and how they expand to all six coordinates of every body.

    names : (n,) ``main/sun/x``; body, direction : the two parts.
    radius : (n,) reference radius R of an rz coordinate (u = R rz) [m], 1 for the others.
    bodies : (nb,) every body of the train, in order.
    expand : (6 nb, n) full displacement = expand @ q, in each body's own axes, order x y z rx ry rz.
    """

    names: tuple[str, ...]
    body: tuple[str, ...]
    direction: tuple[str, ...]
    radius: Array
    bodies: tuple[str, ...]
    expand: Array

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
    """

    frequency: Fraction
    gap: ComplexArray
    link_gap: ComplexArray
    force: ComplexArray
    causes: tuple[str, ...] = ()
    group_gap: ComplexArray = field(default_factory=lambda: np.zeros(0, complex))
    far_gap: ComplexArray = field(default_factory=lambda: np.zeros(0, complex))
    ramp_force: ComplexArray = field(default_factory=lambda: np.zeros(0, complex))

    def __repr__(self) -> str:
        """One line: frequency, largest gap of a mesh, number of causes."""
        gap = float(np.abs(self.gap).max(initial=0.0))
        return f"Line({float(self.frequency):.6g} Hz, mesh gap {gap:.4g} m, {len(self.causes)} causes)"


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
    body_mass : (nb, 6) mass and inertia of every body's six coordinates, for kinetic-energy shares.
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
        """Coupling pattern and key numbers, for notebooks."""
        return system_html(self)

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
    def laws(self) -> Laws:
        """Laws of the groups as arrays."""
        return stacked(self.groups)

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
        """Sums (..., w, ...) over the rows of each mesh of values (..., m, ...), in their unit, along `axis`."""
        if len(self.first) == len(self.row):
            return values
        summed: NDArray[Number] = np.add.reduceat(values, self.first, axis=axis)
        return summed

    def least(self, values: Array, axis: int = 0) -> Array:
        """Smallest value (..., w, ...) of the rows of each mesh, of values (..., m, ...), in their unit."""
        lowest: Array = np.minimum.reduceat(values, self.first, axis=axis)
        return lowest

    def any(self, values: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(w,) meshes of which any row (m,) is true."""
        return np.asarray(np.logical_or.reduceat(values, self.first), bool)


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
