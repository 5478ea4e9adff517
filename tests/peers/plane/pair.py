"""A spur pair under load in plane strain: by finite elements of both gears, and by the package's compliance.

Both give the approach d of the two gears along the line of action under a load F per face width, all tooth pairs that
can touch at a place sigma bearing their share.  With finite elements the pressure of a contact is Hertz's ellipse, of
half width a^2 = 4 A p rho; the approach is what both surfaces give under it, weighted by the pressure, and what the
ellipse needs to close the gap of the two curves, whose mean is a^2/(8 rho) = A p/2.  Under another load only the
logarithm of a changes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from epicyclic.teeth import gear_pair, geometry
from epicyclic.teeth.compliance import tooth_compliance
from epicyclic.teeth.contact_solver import solve_hertzian
from epicyclic.teeth.form import GearForm
from epicyclic.teeth.gear_pair import MeshedTeeth

from .gear import Load, solve

__all__ = ["Elements", "by_elements", "by_energy", "elements", "pairs_at", "spur_pair"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Elements:
    """What the finite elements say of a pair at one place; n contacts.

    compliance : (n, n) of both gears with pressures over `half_width` (n,) [m^2/N, m].  A [m^2/N] and radius (n,) [m]
    of `gear_pair.LineContact`.
    """

    compliance: Array
    half_width: Array
    A: float
    radius: Array


def spur_pair(teeth: tuple[int, int], module: float, pressure_angle: float, *, internal: bool = False) -> MeshedTeeth:
    """Spur gears without shift; hubs of half the root diameter, a rim of 3.5 modules.  module [m], angle in degrees."""
    alpha = math.radians(pressure_angle)
    root = geometry.root_radius
    bores = [0.5 * root(z, module, 0.0) for z in teeth]
    if internal:
        bores[1] = root(teeth[1], module, 0.0, internal=True) + 3.5 * module
    a, b = (
        GearForm(teeth=z, module=module, pressure_angle=alpha, internal=internal and k == 1, bore=bores[k])
        for k, z in enumerate(teeth)
    )
    base = [geometry.base_radius(z, module, alpha, 0.0) for z in teeth]
    limits = geometry.contact_limits(
        base[0],
        a.tip,
        base[1],
        b.tip,
        working_pressure_angle=alpha,
        base_pitch=geometry.base_pitch(module, alpha, 0.0),
        internal=internal,
    )
    return MeshedTeeth(a=tooth_compliance(a), b=tooth_compliance(b), working_angle=alpha, limits=limits)


def pairs_at(mesh: MeshedTeeth, sigma: float) -> Index:
    """Whole pitches by which the pairs in contact stand ahead of the one at sigma."""
    low, high = mesh.limits
    return np.arange(math.ceil(low - sigma - 1e-9), math.floor(high - sigma + 1e-9) + 1)


def elements(mesh: MeshedTeeth, sigma: float, load: float, *, pairs: Index | None = None) -> Elements:
    """Solve both gears at a place; load : per face width, for the width of the contacts [N/m]."""
    pairs = pairs_at(mesh, sigma) if pairs is None else pairs
    line, radii = _line(mesh, sigma + pairs.astype(float))
    half = gear_pair.half_width(line, np.full(len(pairs), load / len(pairs)))
    total = np.zeros((len(pairs), len(pairs)))
    for tooth, radius, sign in ((mesh.a, radii[0], 1), (mesh.b, radii[1], -1)):
        loads = [
            Load(tooth=int(sign * j) % tooth.gear.teeth, radius=1e3 * r, half_width=1e3 * w)
            for j, r, w in zip(pairs, radius, half, strict=True)
        ]
        total += solve(tooth.gear, loads).surface * 1e-6
    return Elements(compliance=0.5 * (total + total.T), half_width=half, A=line.A, radius=line.radius)


def by_elements(found: Elements, load: float) -> tuple[float, Array]:
    """Approach [m] and loads (n,) of the contacts [N/m] under a load per face width."""
    share = np.full(len(found.half_width), load / len(found.half_width))
    one = np.ones(len(share))
    for _ in range(50):
        log = np.log(4 * found.A * share * found.radius / found.half_width**2)  # 2 ln(a/a0)
        matrix = found.compliance + np.diag(found.A * (0.5 - log))
        unit = np.linalg.solve(matrix, one)
        share = unit * load / unit.sum()
    return float(load / unit.sum()), share


def by_energy(mesh: MeshedTeeth, sigma: float, load: float, *, pairs: Index | None = None) -> tuple[float, Array]:
    """The same with the package's compliance."""
    pairs = pairs_at(mesh, sigma) if pairs is None else pairs
    line, (radius_a, radius_b) = _line(mesh, sigma + pairs.astype(float))
    number = np.arange(len(pairs))  # of the teeth, which follow each other
    shared = mesh.a.cross(radius_a, number) + mesh.b.cross(radius_b, number[::-1])
    for tooth, radius in ((mesh.a, radius_a), (mesh.b, radius_b)):
        parts = tooth.parts(radius)
        shared = shared + np.diag(parts.bending + parts.shear + parts.compression)
    found = solve_hertzian(
        shared[None],
        np.zeros((1, len(pairs))),
        np.ones((1, len(pairs)), dtype=bool),
        np.array([load]),
        lambda u, index: gear_pair.load(line, u),
        inverse=lambda force: gear_pair.approach(line, force),
    )
    return float(found.approach[0]), found.force[0]


def _line(mesh: MeshedTeeth, place: Array) -> tuple[gear_pair.LineContact, tuple[Array, Array]]:
    on_a, on_b = mesh.rolled(place)
    radii = mesh.radii(place)
    curvature = 1 / on_a + (-1 / on_b if mesh.b.gear.internal else 1 / on_b)
    line = gear_pair.line_contact(
        1 / curvature,
        mesh.a.depth(radii[0]),
        mesh.b.depth(radii[1]),
        youngs_modulus=(mesh.a.gear.youngs_modulus, mesh.b.gear.youngs_modulus),
        poisson=(mesh.a.gear.poisson, mesh.b.gear.poisson),
    )
    return line, radii
