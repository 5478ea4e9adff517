"""A planar planetary set written row by row, so that the analyses are tested without the rest of the package."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from epicyclic.system.system import Dofs, LinkRows, MeshRows, Symmetry, System

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Planar:
    """Lin & Parker's set: sun, ring, carrier and N planets with x, y, rz each; SI units, u-inertias I/r^2 [kg]."""

    N: int = 4
    angles: tuple[float, ...] | None = None
    mass: tuple[float, float, float, float] = (0.4, 2.35, 5.43, 0.66)  # sun, ring, carrier, planet
    inertia: tuple[float, float, float, float] = (0.39, 3.00, 6.29, 0.61)
    radius: tuple[float, float, float, float] = (0.07742 / 2, 0.27503 / 2, 0.1768 / 2, 0.10035 / 2)
    mesh: tuple[float, float] = (5e8, 5e8)  # sun-planet, planet-ring
    lateral: tuple[float, float, float, float] = (1e8, 1e8, 1e8, 1e8)  # sun, ring, carrier, pin
    torsion: tuple[float, float, float] = (0.0, 1e9, 0.0)  # on u: sun, ring, carrier
    pressure_angle: float = float(np.radians(24.6))

    @property
    def psi(self) -> Array:
        return 2 * np.pi * np.arange(self.N) / self.N if self.angles is None else np.array(self.angles)

    def row(self, a: int, b: int | None, psi: float, at_a: Array, at_b: Array) -> Array:
        """A row with entries at bodies a and b in branch axes; central bodies (< 3) are turned into stage axes."""
        row = np.zeros(3 * (self.N + 3))
        for body, entry in ((a, at_a), (b, at_b)):
            if body is not None:
                c, s = np.cos(psi), np.sin(psi)
                x, y, rz = entry
                row[3 * body : 3 * body + 3] = (c * x - s * y, s * x + c * y, rz) if body < 3 else entry
        return row

    def mesh_rows(self) -> Array:
        S, C = np.sin(self.pressure_angle), np.cos(self.pressure_angle)
        rs, rr, _, rp = self.radius
        sun = [self.row(0, 3 + i, p, np.array([S, C, rs]), np.array([-S, -C, rp])) for i, p in enumerate(self.psi)]
        ring = [self.row(3 + i, 1, p, np.array([S, -C, -rp]), np.array([-S, C, rr])) for i, p in enumerate(self.psi)]
        return np.array(sun + ring).T

    def link_rows(self) -> tuple[list[str], list[Array], list[float]]:
        names, rows, values = [], [], []
        none = np.zeros(3)
        for body, member in enumerate(("sun", "ring", "carrier")):
            torsion = self.torsion[body] * self.radius[body] ** 2
            for axis, k in zip(("x", "y", "rz"), (self.lateral[body], self.lateral[body], torsion), strict=True):
                names.append(f"main/{member}/support/{axis}")
                rows.append(self.row(body, None, 0.0, np.eye(3)[("x", "y", "rz").index(axis)], none))
                values.append(k)
        for i, p in enumerate(self.psi):
            for axis, arm in (("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, self.radius[2]])):
                names.append(f"main/planet/{i + 1}/bearing/{axis}")
                at_planet = -np.array([1.0, 0.0, 0.0] if axis == "x" else [0.0, 1.0, 0.0])
                rows.append(self.row(2, 3 + i, p, np.array(arm), at_planet))
                values.append(self.lateral[3])
        return names, rows, values

    def symmetry(self) -> Symmetry:
        N = self.N
        R = np.zeros((3 * (N + 3),) * 2)
        c, s = np.cos(2 * np.pi / N), np.sin(2 * np.pi / N)
        for body in range(3):
            R[3 * body : 3 * body + 3, 3 * body : 3 * body + 3] = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
        for i in range(N):
            j = (i + 1) % N
            R[9 + 3 * j : 12 + 3 * j, 9 + 3 * i : 12 + 3 * i] = np.eye(3)
        return Symmetry(stage="main", branches=N, operator=R, holds=self.angles is None)

    def system(self) -> System:
        N = self.N
        members = ["main/sun", "main/ring", "main/carrier", *(f"main/planet/{i + 1}" for i in range(N))]
        which = [0, 1, 2] + [3] * N
        n = 3 * len(members)
        mass = np.array([v for w in which for v in (self.mass[w], self.mass[w], self.inertia[w] * self.radius[w] ** 2)])
        radius = np.array([v for w in which for v in (1.0, 1.0, self.radius[w])])
        expand = np.zeros((6 * len(members), n))
        body_mass = np.zeros((len(members), 6))
        for b in range(len(members)):
            for j, direction in enumerate((0, 1, 5)):
                expand[6 * b + direction, 3 * b + j] = 1.0
                body_mass[b, direction] = mass[3 * b + j]
        names, rows, values = self.link_rows()
        k = np.array(values)
        B = np.array(rows).T
        zeros = np.zeros((n, n))
        m = 2 * N
        pairs = [f"stages.main.meshes.{pair}" for pair in ("sun-planet", "planet-ring")]
        return System(
            dofs=Dofs(
                names=tuple(f"{b}/{d}" for b in members for d in ("x", "y", "rz")),
                body=tuple(b for b in members for _ in range(3)),
                direction=("x", "y", "rz") * len(members),
                radius=radius,
                bodies=tuple(members),
                expand=expand,
            ),
            M=np.diag(mass),
            C=zeros,
            G=zeros,
            K=(B * k) @ B.T,
            Kg=zeros,
            Cskew=zeros,
            meshes=MeshRows(
                name=tuple(f"main/{p}/{i + 1}" for p in ("sun-planet", "planet-ring") for i in range(N)),
                pair=tuple(p for p in pairs for _ in range(N)),
                stage=("main",) * m,
                branch=tuple(i + 1 for _ in pairs for i in range(N)),
                side=("",) * m,
                B=self.mesh_rows(),
                stiffness=np.repeat(self.mesh, N).astype(float),
                variation=np.zeros((m, 0), complex),
                tone=np.zeros(m, np.int64),
                damping=np.zeros(m),
                backlash=np.full(m, np.inf),
                cos_base_helix=np.ones(m),
            ),
            links=LinkRows(
                name=tuple(names),
                link=tuple(name.rsplit("/", 1)[0] for name in names),
                B=B,
                stiffness=k,
                damping=np.zeros(len(k)),
            ),
            force=np.zeros(n),
            body_mass=body_mass,
            symmetries=(self.symmetry(),),
        )


def _reduced(system: System, T: Array, names: tuple[str, ...], radius: Array) -> System:
    """The system in coordinates p with q = T p."""
    meshes, links, dofs = system.meshes, system.links, system.dofs
    square = {name: T.T @ getattr(system, name) @ T for name in ("M", "C", "G", "K", "Kg", "Cskew")}
    parts = [name.rsplit("/", 1) for name in names]
    return replace(
        system,
        dofs=replace(
            dofs,
            names=names,
            body=tuple(p[0] for p in parts),
            direction=tuple(p[1] for p in parts),
            radius=radius,
            expand=dofs.expand @ T,
        ),
        meshes=replace(meshes, B=T.T @ meshes.B),
        links=replace(links, B=T.T @ links.B),
        force=T.T @ system.force,
        symmetries=(),
        **square,
    )


def _side_by_side(one: System, two: System) -> System:
    """Two systems that do not touch, as two stages of one."""
    n, m = len(one.M), len(two.M)

    def block(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(scipy.linalg.block_diag(a, b))

    def both(name: str) -> NDArray[np.float64]:
        return block(getattr(one, name), getattr(two, name))

    first, second = one.symmetries[0], two.symmetries[0]
    rename = {name: name.replace("main", "second") for name in (*two.dofs.names, *two.dofs.bodies, *two.links.name)}
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(one.meshes, name), getattr(two.meshes, name)])
        for name in ("stiffness", "variation", "tone", "damping", "backlash", "cos_base_helix")
    }
    meshes = replace(
        one.meshes,
        name=(*one.meshes.name, *(name.replace("main", "second") for name in two.meshes.name)),
        pair=one.meshes.pair + two.meshes.pair,
        stage=one.meshes.stage + ("second",) * len(two.meshes.stage),
        branch=one.meshes.branch + two.meshes.branch,
        side=one.meshes.side + two.meshes.side,
        B=block(one.meshes.B, two.meshes.B),
        **arrays,
    )
    links = replace(
        one.links,
        name=one.links.name + tuple(rename[name] for name in two.links.name),
        link=one.links.link + tuple(name.replace("main", "second") for name in two.links.link),
        B=block(one.links.B, two.links.B),
        stiffness=np.concatenate([one.links.stiffness, two.links.stiffness]),
        damping=np.concatenate([one.links.damping, two.links.damping]),
    )
    dofs = replace(
        one.dofs,
        names=one.dofs.names + tuple(rename[name] for name in two.dofs.names),
        body=one.dofs.body + tuple(name.replace("main", "second") for name in two.dofs.body),
        direction=one.dofs.direction + two.dofs.direction,
        radius=np.concatenate([one.dofs.radius, two.dofs.radius]),
        bodies=one.dofs.bodies + tuple(rename[name] for name in two.dofs.bodies),
        expand=block(one.dofs.expand, two.dofs.expand),
    )
    return replace(
        one,
        dofs=dofs,
        meshes=meshes,
        links=links,
        force=np.zeros(n + m),
        body_mass=np.vstack([one.body_mass, two.body_mass]),
        symmetries=(
            replace(first, operator=block(first.operator, np.eye(m))),
            replace(second, stage="second", operator=block(np.eye(n), second.operator)),
        ),
        M=both("M"),
        C=both("C"),
        G=both("G"),
        K=both("K"),
        Kg=both("Kg"),
        Cskew=both("Cskew"),
    )


@dataclass(frozen=True, slots=True)
class Builders:
    """What the tests build systems with."""

    planar: type[Planar] = Planar
    reduced: Callable[[System, Array, tuple[str, ...], Array], System] = field(default=_reduced)
    side_by_side: Callable[[System, System], System] = field(default=_side_by_side)
