"""Bodies that bend: what they are to matrices and rows, and the thin ring.

Beside its six coordinates a body that bends brings others, and with them a shape matrix Phi(P), the displacement of its
point P per coordinate; a row of a gap along n is n . Phi(P).  A rigid body is Phi = [1, -r x].  An axisymmetric body
has constant matrices at any speed.  Seen from a frame against which it turns at nu, d/dt of its material is d/dt + nu D
with a matrix D that turns its patterns; M D is antisymmetric.  From M, G_m (of the spin w) and K_m of the material
follow

    G = G_m + 2 nu M D      Kg = K_m + nu G_m D + nu^2 M D^2      ramps E = nu' M D + w' G_m/(2 w)      C q' + nu C D q

Derived here.

The thin ring is a curved beam that bends in its plane, by Fourier orders about its axis.  It has mean radius R, mass
per length rho A, stiffness of bending E I, of stretch E A, of shear k G A.  Radial motion w (outward) and tangential v
at the polar angle psi:

    stretch  (v' + w)/R      turn of the section  phi = (v - w')/R      curvature  phi'/R

Without E A the ring is inextensible, v' = -w.  A thicker ring is a curved beam (Timoshenko, Winkler): it shears, so
that the turn of the section in an order n is 1/(1 + E I n^2/(k G A R^2)) of that above; fibres outside the centre line
are longer, so that its bending moment is E I (phi' - stretch)/R with E I = E int y^2/(1 + y/R) dA, and its section has
a moment of inertia and a static moment.  The spin w_r of the ring pre-stresses a fibre of radius r by
N_0 = rho A r^2 w_r^2,

    U_g = N_0/(2 r) int [(v' + w)^2 + (w' - v)^2] dpsi

Of an order n >= 2 of an inextensible ring without shear, with J = [[0, 1], [-1, 0]] on the cos and sin part of w,
M = pi rho A R (1 + 1/n^2), K = pi E I (n^2 - 1)^2/R^3 and D = n J.  All is derived here by the energies of a wave.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def about_z(vectors: Array, angle: Array | float) -> Array:
    """Vectors (r, 3) turned about z by an angle [rad] each."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = vectors.T
    return np.stack([c * x - s * y, s * x + c * y, z], axis=1)


class Springs(NamedTuple):
    """Springs of a body that bends: rows (p, 6 + e) of its coordinates, stiffness (p,) [N/m], and names (p,)."""

    rows: Array
    stiffness: Array
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ElasticBody:
    """Coordinates e by which a body bends, beside x y z rx ry rz of its mean motion; matrices are of all 6 + e.

    names : (e,) of the coordinates [m].  mass : M, its block of the six is that of the file and zero here.
    springs : those whose energy is the strain energy.  foundation : those of a uniform one in the housing.
    damping : C of the material (6 + e, 6 + e), its block of the six zero.
    turn : D (6 + e, 6 + e).  waves : its highest number of waves; None of a body that turns with its frame, without D.
    spin, spin_stiffness : G_m per spin w [kg] and K_m per w^2 [kg], their blocks of the six zero.
    spin_load : (6 + e,) load of the spin per w^2 [kg m].
    shape : of points (R, 3) from its centre, in its axes [m], displacement along x, y, z and rotation about them
        per coordinate, (R, 6, e).
    cyclic : of a body that is not axisymmetric `turned`.
    """

    names: tuple[str, ...]
    mass: Array
    springs: Springs
    foundation: Springs
    damping: Array
    turn: Array
    waves: int | None
    spin: Array
    spin_stiffness: Array
    spin_load: Array
    shape: Callable[[Array], Array]
    cyclic: Callable[[float], Array | None] | None = None

    def turned(self, angle: float) -> Array | None:
        """Operator (e, e) that turns the pattern of the body by an angle [rad]; None where that is another body."""
        if self.cyclic is not None:
            return self.cyclic(angle)
        from scipy.linalg import expm

        return np.asarray(expm(-angle * self.turn[6:, 6:]))

    def __repr__(self) -> str:
        """One line: number of coordinates."""
        return f"ElasticBody({len(self.names)} coordinates)"

    def gyroscopic(self, frame_speed: float, spin: float) -> Array:
        """G in a frame of speed Omega of a body of absolute speed w, both [rad/s]."""
        return spin * self.spin + 2 * (spin - frame_speed) * self.mass @ self.turn

    def centrifugal(self, frame_speed: float, spin: float) -> Array:
        """Kg; arguments as of `gyroscopic`."""
        nu, D = spin - frame_speed, self.turn
        return spin**2 * self.spin_stiffness + nu * spin * self.spin @ D + nu**2 * self.mass @ D @ D

    def euler(self, frame_speed: float, spin: float) -> Array:
        """E, the stiffness-like terms per relative acceleration; arguments as of `gyroscopic`."""
        return (spin - frame_speed) * self.mass @ self.turn + spin / 2 * self.spin


_QUARTER = np.array([[0.0, 1.0], [-1.0, 0.0]])  # J: of (cos, sin) parts the derivative of order 1
# A point nearer to the axis than this part of the radius is none of the ring: what acts there acts on the mean motion.
_AXIS = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class ThinRing:
    """A ring as drawn.

    radius : R of the centre line [m].  line_mass : rho A [kg/m].  bending : E I [N m^2].
    axial : E A [N], inf: inextensible.  shear : k G A [N], inf: sections stay square to the centre line.
    line_inertia : rho I of the section against turning [kg m].  orders : N, the highest.
    foundation : uniform radial and tangential stiffness k_r, k_t to the housing per length [N/m^2].
    """

    radius: float
    line_mass: float
    bending: float
    axial: float = math.inf
    shear: float = math.inf
    line_inertia: float = 0.0
    orders: int = 12
    foundation: tuple[float, float] = (0.0, 0.0)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the coordinates by which it bends."""
        names = [f"{part}{n}" for n in range(2, self.orders + 1) for part in "ab"]
        if math.isfinite(self.axial):
            names = ["a0", *names, *(f"{part}{n}" for n in range(1, self.orders + 1) for part in "cd")]
        return tuple(names)

    def frequency(self, n: int) -> float:
        """Natural frequency of order n >= 2 of the free inextensible ring, with shear and rotary inertia [Hz]."""
        turn = self.section_turn(n) * (n**2 - 1) / (n * self.radius)
        mass = self.line_mass * (1 + 1 / n**2) + self.line_inertia * turn * (turn - 2 / (n * self.radius))
        bent = self.bending * ((n**2 - 1) / self.radius**2) ** 2 * self.section_turn(n)
        return math.sqrt(bent / mass) / (2 * math.pi)

    def section_turn(self, n: int) -> float:
        """Turn of the section in order n per that of a ring without shear [1]."""
        return 1 / (1 + n**2 * self.slack)

    @property
    def fibres(self) -> Iterator[tuple[float, float]]:
        """Two of the section: place from the centre line [m] and mass per length of that [kg/m].

        They have its mass, its moment of inertia rho I and its static moment rho I/R: outer fibres are longer.
        """
        reach = math.sqrt(self.line_inertia / self.line_mass)
        for y in (-reach, reach):
            yield y, self.line_mass / 2 * (1 + y / self.radius)

    @property
    def slack(self) -> float:
        """Stiffness of bending per that of shear in order 1, E I/(k G A R^2) [1]; 0 of a ring without shear."""
        return self.bending / (self.shear * self.radius**2)

    def section(self, wave: _Wave) -> tuple[Array, Array, Array]:
        """Stretch, curvature times R and turn of the section in an order, cos and sin parts, (2, k) each [1/m].

        The turn minimizes the energy of bending, E I (phi' - stretch)^2, and of shear together; the curvature is that
        of a ring without shear, which `section_turn` softens.
        """
        J, w, v = wave.n * _QUARTER, wave.field[:2] / self.radius, wave.field[2:] / self.radius
        stretch = J @ v + w
        curved = stretch if self.slack else 0.0 * stretch
        return stretch, J @ (v - J @ w) - curved, self.section_turn(wave.n) * (v - J @ w - self.slack * J @ curved)


@dataclass(frozen=True, slots=True)
class _Wave:
    """Coordinates of one order: their names, indices among the rigid six and e, and field (4, k): w and v, cos, sin."""

    n: int
    index: list[int]
    field: Array

    @property
    def norm(self) -> float:
        """Integral of the square of cos n psi over the circle."""
        return math.tau if self.n == 0 else math.pi


@lru_cache(maxsize=8)
def elastic_ring(ring: ThinRing) -> ElasticBody:
    """Coordinates and matrices of a ring; a2, b2, .. are the cos and sin part of w, of order 2, .., [m].

    With a finite `axial` stiffness also a0, the breathing, and c1, d1, c2, .. of what stretches beside it.
    """
    names = ring.names
    waves = list(_waves(ring, names))
    size = 6 + len(names)
    M, D, S, K = (np.zeros((size, size)) for _ in range(4))
    load = np.zeros(size)
    springs, foundation = list[_Row](), list[_Row]()
    for wave in waves:
        n, at, F = wave.n, np.ix_(wave.index, wave.index), wave.field
        J, w, v, scale = n * _QUARTER, F[:2], F[2:], wave.norm * ring.radius
        stretch, bent, turn = ring.section(wave)
        for y, mass in ring.fibres:
            moved = np.vstack([w, v + y * turn])
            M[at] += scale * mass * moved.T @ moved
            # velocities w. - w_r v and v. + w_r w of the material: A = w_r [-v, w]
            across = np.vstack([-moved[2:], w])
            S[at] += 2 * scale * mass * moved.T @ across
            strained = np.vstack([J @ moved[2:] + w, J @ w - moved[2:]])
            K[at] += scale * mass * (strained.T @ strained - across.T @ across)
            if n == 0:
                load[wave.index] += scale * mass * (ring.radius + y) * w[0]
        D[at] = np.linalg.lstsq(F, np.vstack([J @ w, J @ v]), rcond=None)[0]
        bending, along = scale * ring.bending * ring.section_turn(n) / ring.radius**2, scale * ring.axial
        springs += _rows(
            wave, size, ("bending", bent, bending), ("stretch", stretch, along if along < math.inf else 0.0)
        )
        radial, tangential = scale * np.array(ring.foundation)
        foundation += _rows(wave, size, ("radial", w, radial), ("tangential", v, tangential))
    for block in (M, S, K):  # mean motions have the mass of the file, and the terms of a rigid body
        block[:6, :6] = 0.0
    load[:6] = 0.0
    return ElasticBody(
        names=names,
        mass=M,
        springs=_stacked([row for row in springs if row[0][6:].any()], size),
        foundation=_stacked(foundation, size),
        damping=np.zeros((size, size)),
        turn=D,
        waves=ring.orders,
        spin=S,
        spin_stiffness=K,
        spin_load=load,
        shape=partial(_shape, ring, waves, len(names)),
    )


def order_compliances(ring: ThinRing, normal: tuple[float, float], radius: float) -> Array:
    """Compliance of each order 0 .. N of a free ring along a normal at a radius, (N + 1,) [m/N]; 0 of orders 0 and 1.

    normal : parts (radial, tangential) [1].  radius : of the loaded point [m].
    """
    body, found = elastic_ring(replace(ring, axial=math.inf)), np.zeros(ring.orders + 1)
    row = np.array(normal) @ body.shape(np.array([[radius, 0.0, 0.0]]))[0, :2]
    bent = body.springs.rows[:, 6:]
    stiffness = np.einsum("pe,p,pe->e", bent, body.springs.stiffness, bent)
    np.add.at(found, np.repeat(np.arange(2, ring.orders + 1), 2), row**2 / stiffness)
    return found


def _waves(ring: ThinRing, names: tuple[str, ...]) -> Iterator[_Wave]:
    """Fields of all orders; of the rigid coordinates x, y (0, 1) are order 1 and rz (5) is order 0."""
    place = {name: 6 + i for i, name in enumerate(names)}
    zero = np.zeros((2, 2))
    for n in range(ring.orders + 1):
        if n == 0:
            parts = {5: [[0.0], [0.0], [ring.radius], [0.0]]}
            parts |= {place["a0"]: [[1.0], [0.0], [0.0], [0.0]]} if "a0" in place else {}
            yield _Wave(0, list(parts), np.hstack([np.array(part) for part in parts.values()]))
            continue
        # w = a cos + b sin and v = (b cos - a sin)/n: (a, b) -> cos and sin part of v is J/n
        index, fields = [0, 1] if n == 1 else [place[f"a{n}"], place[f"b{n}"]], [np.vstack([np.eye(2), _QUARTER / n])]
        if f"c{n}" in place:
            index += [place[f"c{n}"], place[f"d{n}"]]
            # of order 1 orthogonal to the mean motion
            fields.append(np.vstack([np.eye(2), -_QUARTER]) if n == 1 else np.vstack([zero, _QUARTER]))
        yield _Wave(n, index, np.hstack(fields))


_Row = tuple[Array, float, str]


def _rows(wave: _Wave, size: int, *springs: tuple[str, Array, float]) -> Iterator[_Row]:
    """Springs of one order, by what they strain, its cos and sin part and its stiffness: rows, stiffnesses, names."""
    for what, motion, k in springs:
        for part, name in zip(motion, "ab", strict=True):
            row = np.zeros(size)
            row[wave.index] = part
            if k and row.any():
                yield row, k, f"{what} {name}{wave.n}"


def _stacked(rows: list[_Row], size: int) -> Springs:
    matrix = np.array([row for row, _, _ in rows]).reshape(-1, size)
    return Springs(matrix, np.array([k for _, k, _ in rows]), tuple(name for _, _, name in rows))


def _shape(ring: ThinRing, waves: list[_Wave], count: int, points: Array) -> Array:
    """Motion of points (R, 3) per coordinate, (R, 6, count): the section at a point stays plane and turns about z."""
    x, y = points[:, 0], points[:, 1]
    radius, psi = np.hypot(x, y), np.arctan2(y, x)
    moved = np.zeros((len(points), 3, 6 + count))
    for wave in waves:
        w, v = wave.field[:2], wave.field[2:]
        turn = ring.section(wave)[2]
        basis = np.stack([np.cos(wave.n * psi), np.sin(wave.n * psi)], axis=1)
        moved[:, 0, wave.index] = basis @ w
        moved[:, 1, wave.index] = basis @ v + (radius - ring.radius)[:, None] * (basis @ turn)
        moved[:, 2, wave.index] = basis @ turn
    c, s = np.cos(psi)[:, None], np.sin(psi)[:, None]
    out, along, turned = moved[:, :, 6:].transpose(1, 0, 2)
    result = np.zeros((len(points), 6, count))
    result[:, 0], result[:, 1], result[:, 5] = c * out - s * along, s * out + c * along, turned
    result[radius < _AXIS * ring.radius] = 0.0
    return result
