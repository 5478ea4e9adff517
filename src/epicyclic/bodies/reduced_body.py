"""A body by matrices: what it is, its rigid motions and units, and whether it is that of a free body.

A body has coordinates q.  A coordinate is the displacement or rotation of a node, or a mode without place.  Body axes
have z along the axis of the gear; nodes stand where they are undeformed.

Of a body that is free, mass and frequencies are found.  Tolerances are those of a file of ten digits.  Matrices are
compared after their coordinates are scaled to a unit diagonal, so that no check depends on units.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh, splu

from ..errors import ConvergenceError, ModelError

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Matrix: TypeAlias = Any  # an Array, a csr_array of scipy, or None where there is none

# of the masses [kg] and lengths [m] of a file
UNITS = {"kg m s": (1.0, 1.0), "t mm s": (1e3, 1e-3)}
MAX_BYTES, MAX_DENSE, MAX_DOFS = 1 << 29, 3000, 200_000
UNIT_WORDS = ", ".join(f'"{one}"' for one in UNITS)
MATRICES = ("M", "K", "C", "G1", "KG1", "D")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReducedBody:
    """A body in n coordinates, SI: M q'' + (C + s G1) q' + (K + s^2 KG1) q = forces, s its speed [rad/s].

    M, K : (n, n), symmetric; dense, or sparse where a whole mesh is meant.
    C, G1, KG1 : (n, n) damping, gyroscopic terms per rad/s, stiffness per (rad/s)^2.
    D : (n, n) derivative along the angle of an axisymmetric body: its pattern turned back by psi is exp(psi D) q.
    node_id : (k,); node_xyz : (k, 3) [m].
    dof_node, dof_dir : (n,) node and direction of each coordinate: 1 to 3 x, y, z [m], 4 to 6 about them [rad], 0 a
        mode, whose mass is 1.
    shape_node, shape_dir, shape : (r,), (r,), (r, n) motion of nodes that are no coordinates.
    mass [kg], centre (3,) [m], inertia (3, 3) about it [kg m^2] : what is expected.
    units : of the file that was read.
    """

    M: Matrix
    K: Matrix
    C: Matrix = None
    G1: Matrix = None
    KG1: Matrix = None
    D: Array | None = None
    node_id: Index
    node_xyz: Array
    dof_node: Index
    dof_dir: Index
    shape_node: Index | None = None
    shape_dir: Index | None = None
    shape: Array | None = None
    mass: float | None = None
    centre: Array | None = None
    inertia: Array | None = None
    source: str = ""
    units: str = "kg m s"

    @property
    def modal(self) -> NDArray[np.bool_]:
        """(n,) which coordinates are modes."""
        return np.equal(self.dof_dir, 0)

    def places(self, nodes: Index) -> Array:
        """(m, 3) coordinates of nodes [m]; KeyError of one that is not there."""
        at = {int(node): i for i, node in enumerate(self.node_id)}
        return self.node_xyz[[at[int(node)] for node in nodes]].reshape(-1, 3)


def rigid_rows(places: Array, directions: Index, point: Array | None = None) -> Array:
    """Rows (m, 6): what directions 1 to 6 at places (m, 3) [m] see of the motion x y z, rx ry rz of a point (3,)."""
    x, y, z = (places - (0.0 if point is None else point)).T
    zero, row = np.zeros_like(x), np.arange(len(places))
    cross = np.array([[zero, z, -y], [-z, zero, x], [y, -x, zero]]).transpose(2, 0, 1)  # rotation to displacement
    block = np.tile(np.eye(6), (len(places), 1, 1))
    block[:, :3, 3:] = cross
    return block[row, directions - 1]


def rigid_motion(body: ReducedBody) -> Array:
    """Motions (n, 6) of the coordinates as the body moves rigidly: x y z, rx ry rz about the origin.

    Modes follow from the stiffness, which is not strained, and from the shape of nodes.
    """
    modal = body.modal
    motion = np.zeros((len(modal), 6))
    motion[~modal] = rigid_rows(body.places(body.dof_node[~modal]), body.dof_dir[~modal])
    if not modal.any():
        return motion
    own = dense(body.K[modal])
    size = np.abs(own).max(initial=0.0) or 1.0
    strained, wanted = own[:, modal] / size, -own @ motion / size
    if body.shape is not None and body.shape_node is not None and body.shape_dir is not None:
        seen = rigid_rows(body.places(body.shape_node), body.shape_dir) - body.shape @ motion
        strained, wanted = np.vstack([strained, body.shape[:, modal]]), np.vstack([wanted, seen])
    motion[modal] = np.linalg.lstsq(strained, wanted, rcond=None)[0]
    return motion


def refused(where: str, name: str, problem: str, allowed: str, **given: object) -> ModelError:
    """What is wrong with something in a file."""
    return ModelError(problem, path=f"{where}: {name}", allowed=allowed, **given)


# --- units -----------------------------------------------------------------------------------------------------------


def in_si(body: ReducedBody, where: str) -> ReducedBody:
    """A body whose matrices, places and mass are in `body.units`, in SI.

    Raises
    ------
    ModelError : units that are not known, at `where`: units.
    """
    if body.units not in UNITS:
        raise refused(where, "units", "not known, and never guessed", UNIT_WORDS, given=body.units)
    mass, length = UNITS[body.units]
    if (mass, length) == (1.0, 1.0):
        return body
    energy = mass * length**2
    size = np.array([energy**0.5, *[length] * 3, *[1.0] * 3])  # of a coordinate, by its direction
    own = size[body.dof_dir]
    found: dict[str, Any] = {name: scaled(getattr(body, name), energy / own, 1 / own) for name in MATRICES[:-1]}
    if body.shape is not None:
        found["shape"] = scaled(body.shape, size[body.shape_dir], 1 / own)
    found |= {"D": scaled(body.D, own, 1 / own), "node_xyz": body.node_xyz * length}
    for name, factor in (("mass", mass), ("centre", length), ("inertia", energy)):
        value = getattr(body, name)
        found[name] = None if value is None else value * factor
    return replace(body, **found)


def dense(matrix: Matrix) -> Array:
    """A matrix as an array."""
    return np.asarray(matrix.toarray() if sparse.issparse(matrix) else matrix, float)


def scaled(matrix: Matrix, rows: Array, columns: Array) -> Matrix:
    """A matrix, or None, with its rows and columns multiplied."""
    if sparse.issparse(matrix):
        return (sparse.diags_array(rows) @ matrix @ sparse.diags_array(columns)).tocsr()
    return None if matrix is None else matrix * np.outer(rows, columns)


# checks ---------------------------------------------------------------------------------------------------------------

_SYMMETRY, _NEGATIVE, _RIGID, _MODAL = 1e-9, 1e-9, 1e-8, 1e-6
_MASS_WRONG, _MASS_SAID = 1e-3, 1e-6
_NOISE, _SHIFT = 1e-12, 1e-10  # of squared frequencies over the largest ratio of the diagonals
_Solve = Callable[[Array], Array]
_HUGE = 1e100  # squares of it are finite
_ON_AXIS = 1e-9  # place of the centre of mass, per size of the body, that is rounding
_MODES, _SMALL = 6, 300  # frequencies that are said; coordinates of what is solved at once
# what a factor of a mass or inertia usually is, by its power of ten
_FACTORS = {
    3: "tonnes against kilograms, or a length in mm against m",
    6: "areas in mm^2 against m^2",
    9: "volumes in mm^3 against m^3: a density per m^3 in a mesh in mm",
    12: "volumes in mm^3 against m^3 and tonnes against kilograms",
}


@dataclass(frozen=True, slots=True, eq=False)
class BodyFacts:
    """What the checks found: mass [kg], centre (3,) [m], inertia (3, 3) about it [kg m^2], the first free elastic
    frequencies [Hz], the rigid motions (n, 6) about the origin, and what is to be said."""

    mass: float
    centre: Array
    inertia: Array
    frequencies: Array
    rigid: Array
    remarks: tuple[str, ...]


def checked(body: ReducedBody, where: str) -> tuple[ReducedBody, BodyFacts]:
    """A body with symmetric matrices, and what was found.

    where : name of the file, before the name of a matrix in errors.

    Raises
    ------
    ModelError : sizes, numbers, symmetry, definiteness, modes, rigid motions or mass that do not fit.
    """
    _require_structure(body, where)
    symmetric: dict[str, Any] = {name: _halved(body, name, sign, where) for name, sign in _SIGNS.items()}
    body = replace(body, **symmetric)
    for name in ("M", "K", "C"):
        if getattr(body, name) is not None and (count := _below(getattr(body, name), -_NEGATIVE)):
            raise refused(where, name, f"has {count} negative eigenvalues", f"none below {-_NEGATIVE:g} of the largest")
    for name in ("M", "K") if body.D is not None else ():
        moved = getattr(body, name) @ body.D
        if (error := _norm(moved + moved.T)) > _RIGID * max(_norm(moved), 1e-300):
            problem = f"does not commute with {name}, by {error / _norm(moved):.3g} of their product"
            raise refused(where, "D", problem, f"antisymmetric in {name}, within {_RIGID:g}")
    _require_modes(body, where)
    rigid = rigid_motion(body)
    if body.D is not None:
        _require_turn(body.D, rigid, where)
    mass, centre, inertia = _mass_properties(body, rigid, where)
    _require_free(body, rigid, where)
    squares, _ = elastic_modes(body, rigid, _MODES, where)
    rounding = np.abs(np.sum(rigid * (body.K @ rigid), axis=0) / np.sum(rigid * (body.M @ rigid), axis=0)).max()
    if free := int(np.sum(squares < max(_NOISE * _largest_ratio(body), 10 * rounding))):
        raise refused(where, "K", f"{6 + free} motions without stiffness: a mechanism", "the six of a rigid body")
    remarks = tuple(_against_expected(body, (mass, centre, inertia), where))
    if empty := _below(body.M, _NOISE):
        remarks += (f"{where}: M: {empty} of {len(rigid)} motions have no mass: lumped rotations, or hollow elements",)
    return body, BodyFacts(mass, centre, inertia, np.sqrt(squares) / (2 * math.pi), rigid, remarks)


# --- structure -------------------------------------------------------------------------------------------------------

_SIGNS = {"M": 1, "K": 1, "C": 1, "G1": -1, "KG1": 1}


def _require_structure(body: ReducedBody, where: str) -> None:
    """Sizes, numbers, nodes and directions."""
    count, known = len(body.dof_dir), set(body.node_id.tolist())
    for name in ("M", "K", "C", "G1", "KG1", "D", "node_xyz", "shape", "mass", "centre", "inertia"):
        value = getattr(body, name)
        if value is not None and not np.all(np.abs(value.data if sparse.issparse(value) else value) < _HUGE):
            raise refused(where, name, "not finite", f"numbers below {_HUGE:g}")
    if not 6 <= count <= (MAX_DOFS if sparse.issparse(body.K) and sparse.issparse(body.M) else MAX_DENSE):
        allowed = f"6 to {MAX_DENSE} coordinates, of sparse matrices to {MAX_DOFS}"
        raise refused(where, "K", "too small or too large", allowed, given=count)
    if len(known) < len(body.node_id) or len(body.node_xyz) != len(body.node_id):
        raise refused(where, "node_id", "a node twice, or not as many places", "each node once, with its place")
    lengths = {None if one is None else len(one) for one in (body.shape, body.shape_node, body.shape_dir)}
    if len(lengths) > 1:
        raise refused(where, "shape", "not of one length with shape_node and shape_dir", "all three or none")
    for part, node, direction in (("dof", body.dof_node, body.dof_dir), ("shape", body.shape_node, body.shape_dir)):
        if node is None or direction is None:
            continue
        if outside := set(direction.tolist()) - set(range(part == "shape", 7)):
            raise refused(where, f"{part}_dir", "no direction", "1 to 6, and 0 of a mode", given=min(outside))
        placed = [one for one in zip(node.tolist(), direction.tolist(), strict=True) if one[1]]
        if unknown := {one for one, _ in placed} - known:
            raise refused(where, f"{part}_node", "an unknown node", "nodes of node_id", given=min(unknown))
        if len(set(placed)) < len(placed):
            given = Counter(placed).most_common(1)[0][0]
            raise refused(where, f"{part}_node", "a coordinate twice", "each node and direction once", given=given)


def _halved(body: ReducedBody, name: str, sign: int, where: str) -> Matrix:
    """A matrix, symmetric to the last bit, or antisymmetric where the sign is -1."""
    matrix = getattr(body, name)
    if matrix is None:
        return None
    if (error := _norm(matrix - sign * matrix.T)) > _SYMMETRY * _norm(matrix):
        problem = f"not {'symmetric' if sign > 0 else 'antisymmetric'}: off by {error / _norm(matrix):.3g} of its norm"
        raise refused(where, name, problem, f"{_SYMMETRY:g}")
    half = 0.5 * (matrix + sign * matrix.T)
    return half.tocsr() if sparse.issparse(half) else half


def _norm(matrix: Matrix) -> float:
    return float(np.linalg.norm(matrix.data if sparse.issparse(matrix) else matrix))


def _unit_diagonal(matrix: Matrix) -> tuple[Matrix, Array]:
    """A matrix with a unit diagonal, and what its coordinates were multiplied with (n,)."""
    diagonal = matrix.diagonal()
    largest = np.abs(diagonal).max() or 1.0
    size = 1 / np.sqrt(np.where(diagonal > 1e-30 * largest, diagonal, largest))
    return scaled(matrix, size, size), size


def _below(matrix: Matrix, share: float) -> int:
    """How many eigenvalues of a matrix, scaled, are below a share of its norm; of a sparse one by its pivots."""
    unit, _ = _unit_diagonal(matrix)
    limit = share * float(np.max(abs(unit).sum(axis=0)))
    if not sparse.issparse(unit):
        return int(np.sum(np.linalg.eigvalsh(unit) < limit))
    shifted, options = sparse.csc_array(unit - limit * sparse.eye_array(unit.shape[0])), {"SymmetricMode": True}
    try:
        factors = splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    except RuntimeError:  # an exact zero on the way
        return 1
    off = int(np.sum(factors.perm_r != factors.perm_c))  # a pivot of zero was avoided
    return off or int(np.sum(factors.U.diagonal() < 0))


def _require_modes(body: ReducedBody, where: str) -> None:
    """Modes have the mass 1 and a stiffness, and are not coupled with each other."""
    modal = np.flatnonzero(body.modal)
    if not len(modal) or body.D is not None:
        return
    squares = body.K.diagonal()[modal]
    for name, want, problem, allowed in (
        ("M", np.ones(len(modal)), "modes are not of mass 1", "1 on their diagonal"),
        ("K", squares, "modes are coupled, or one has no stiffness", "squared frequencies on their diagonal"),
    ):
        block = dense(getattr(body, name)[modal][:, modal])
        off = np.abs(block - np.diag(want)).max(axis=0) / np.maximum(want, 1e-300)
        if not np.all(off <= _MODAL) or not np.all(want > 0):
            raise refused(where, name, problem, allowed, given=f"mode {body.dof_node[modal[int(off.argmax())]]}")


# --- rigid motions, mass ---------------------------------------------------------------------------------------------


def _require_turn(derivative: Array, rigid: Array, where: str) -> None:
    """D takes x to -y and y to x, likewise rx and ry, z and rz to nothing; whole numbers of waves."""
    quarter = np.zeros((6, 6))
    quarter[[0, 3], [1, 4]], quarter[[1, 4], [0, 3]] = 1.0, -1.0
    size = np.linalg.norm(rigid, axis=0)
    off = np.linalg.norm(derivative @ rigid - rigid @ quarter, axis=0) / size
    waves = np.abs(np.linalg.eigvals(derivative).imag)
    if off.max() > _MODAL or (part := np.abs(waves - np.round(waves)).max()) > _MODAL:
        problem = "is not the derivative along the angle: of x it is -y, of y x, and it has whole numbers of waves"
        given = f"off by {off.max():.2g}" if off.max() > _MODAL else f"waves off by {part:.2g}"
        raise refused(where, "D", problem, f"within {_MODAL:g}", given=given)


def _require_free(body: ReducedBody, rigid: Array, where: str) -> None:
    """The stiffness lets the body move rigidly."""
    if (residual := _strained(body, rigid)) <= _RIGID:
        return
    problem, allowed = f"a rigid motion meets stiffness, {residual:.3g} of its norm", f"a free body, within {_RIGID:g}"
    for factor in (1e3, 1e-3) if np.any(body.dof_dir > 3) else ():
        other = replace(body, node_xyz=body.node_xyz * factor)
        if _strained(other, rigid_motion(other)) <= _RIGID:
            problem += f", and none with places {factor:g} times as large"
            raise refused(where, "node_xyz", problem, "places in the unit of length of the matrices")
    squares, _ = elastic_modes(body, np.empty((len(rigid), 0)), 8, where)
    free = int(np.sum(squares < 1e2 * _NOISE * _largest_ratio(body)))
    name, why = ("K", "the body is grounded") if free < 6 else ("node_xyz", "places or directions are not those of K")
    raise refused(where, name, f"{problem}; {free} motions meet none: {why}", allowed)


def _strained(body: ReducedBody, rigid: Array) -> float:
    """Largest force of a rigid motion, over the norm of the stiffness and of the motion."""
    matrix, size = _unit_diagonal(body.K)
    motion = rigid / size[:, None]
    force = np.linalg.norm(matrix @ motion, axis=0) / np.maximum(np.linalg.norm(motion, axis=0), 1e-300)
    return float(force.max()) / (_norm(matrix) or 1.0)


def _largest_ratio(body: ReducedBody) -> float:
    """Largest stiffness over mass on the diagonals [1/s^2]: as large as the largest squared frequency."""
    mass = body.M.diagonal()
    return float(np.max(body.K.diagonal()[mass > 0] / mass[mass > 0], initial=0.0)) or 1.0


def _mass_properties(body: ReducedBody, rigid: Array, where: str) -> tuple[float, Array, Array]:
    """Mass [kg], centre (3,) [m], inertia (3, 3) about it [kg m^2]."""
    found = rigid.T @ (body.M @ rigid)
    mass = float(np.trace(found[:3, :3])) / 3
    if not mass > 0 or np.linalg.matrix_rank(rigid) < 6 or np.linalg.eigvalsh(found)[0] <= 0:
        allowed = "coordinates that tell six rigid motions apart, with mass"
        raise refused(where, "M", "a rigid motion without mass", allowed, given=f"{mass:.3g} kg")
    if np.abs(found[:3, :3] / mass - np.eye(3)).max() > _MASS_WRONG:
        given = ", ".join(f"{one:.6g}" for one in np.diag(found)[:3])
        raise refused(where, "M", "another mass in each direction", "one mass", given=f"{given} kg")
    turned = found[:3, 3:] / mass  # motion of the centre as the body turns about each axis
    centre = 0.5 * np.array([turned[1, 2] - turned[2, 1], turned[2, 0] - turned[0, 2], turned[0, 1] - turned[1, 0]])
    reach = math.sqrt(np.trace(found[3:, 3:]) / mass)
    centre = np.where(np.abs(centre) > _ON_AXIS * reach, centre, 0.0)  # a lever of rounding would couple what is free
    return mass, centre, found[3:, 3:] - mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))


def _against_expected(body: ReducedBody, facts: tuple[Any, ...], where: str) -> Iterator[str]:
    """What is said of mass, centre and inertia that are a little off."""
    mass, _, inertia = facts
    size = math.sqrt(np.trace(inertia) / mass)
    for name, found, want in zip(
        ("mass", "centre", "inertia"), facts, (body.mass, body.centre, body.inertia), strict=True
    ):
        if want is None:
            continue
        has, wanted = float(np.linalg.norm(found)), max(float(np.linalg.norm(want)), 1e-300)
        off = float(np.linalg.norm(np.subtract(found, want))) / (size if name == "centre" else wanted)
        given, expected = (np.array2string(np.asarray(one), precision=7).replace("\n", "") for one in (found, want))
        text = f"the matrices have {given}, expected is {expected}, off by {off:.2g}"
        if off > _MASS_WRONG:
            power = 3 * round(math.log10(max(has / wanted, 1e-300)) / 3)
            if abs(power) in _FACTORS and abs(has / wanted / 10.0**power - 1) < 10 * _MASS_WRONG:
                text += f": {10.0**power:g} times, a wrong unit ({_FACTORS[abs(power)]})"
            raise refused(where, name, text, f"within {_MASS_WRONG:g}")
        if off > _MASS_SAID:
            yield f"{where}: {name}: {text}"


# --- free modes ------------------------------------------------------------------------------------------------------


def elastic_modes(body: ReducedBody, rigid: Array, count: int, where: str) -> tuple[Array, Array]:
    """Least squared frequencies (m,) [1/s^2] and modes (n, m) of mass 1 beside the rigid motions, m up to count.

    The mass may be semidefinite: M v = mu (K + sigma M) v is solved for the largest mu.

    Raises
    ------
    ModelError : a motion has neither mass nor stiffness.  ConvergenceError : as of `lowest_modes`.
    """
    shift = _SHIFT * _largest_ratio(body)
    held = body.K + shift * body.M
    basis = rigid @ np.linalg.inv(np.linalg.cholesky(rigid.T @ (body.M @ rigid))).T if rigid.size else rigid
    momentum = body.M @ basis
    try:
        if sparse.issparse(held) and len(rigid) > _SMALL:
            solve = splu(sparse.csc_array(held)).solve
            return lowest_modes(body, count, lambda load: _freed(solve, load, basis, momentum), shift)
        lifted = dense(held) + 1e3 * _largest_ratio(body) * momentum @ momentum.T  # rigid motions above all others
        parts, modes = scipy.linalg.eigh(
            dense(body.M), lifted, subset_by_index=[max(len(rigid) - count, 0), len(rigid) - 1]
        )
    except (np.linalg.LinAlgError, RuntimeError):
        raise refused(where, "K", "a motion has neither mass nor stiffness", "one of them for each motion") from None
    kept = np.flatnonzero(parts > 1e-14 * parts[-1])[::-1]  # what has no mass has no frequency
    modes = modes[:, kept] / np.sqrt(np.sum(modes[:, kept] * (body.M @ modes[:, kept]), axis=0))
    return 1 / parts[kept] - shift, modes


def _freed(solve: _Solve, load: Array, basis: Array, momentum: Array) -> Array:
    """A solution without the part along the rigid motions."""
    found = solve(load - momentum @ (basis.T @ load))
    return np.asarray(found - basis @ (momentum.T @ found))


def lowest_modes(body: ReducedBody, count: int, solve: _Solve, shift: float = 0.0) -> tuple[Array, Array]:
    """Least squared frequencies (count,) [1/s^2] and modes (n, count) of mass 1, given the solution of K + shift M.

    Raises
    ------
    ConvergenceError : the Lanczos iteration does not end.
    """
    inverse = LinearOperator(body.K.shape, solve, dtype=float)
    start = solve(np.random.default_rng(0).normal(size=len(body.dof_dir)))
    try:
        squares, modes = eigsh(body.K, count, body.M, sigma=-shift, OPinv=inverse, v0=start)
    except ArpackError as error:
        raise ConvergenceError(f"{count} modes of {body.source} are not found ({error}): ask for fewer") from None
    order = np.argsort(squares)
    return squares[order], modes[:, order]
