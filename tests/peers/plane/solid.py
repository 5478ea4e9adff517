"""A tooth with its gear body in three dimensions, solved with CalculiX: the peer of the coupling along the face.

One loaded tooth, one more on each side, and the whole ring under them down to the bore (of a ring: out to the rim),
which is held.  The section is extruded along the axis and turned with the helix; layers of quadratic bricks.  A unit
load on a layer acts on the flank along the contact line; what is read is the displacement along the normal of the
middle of the tooth under it, as the line contact reaches from the flank to there.  Units are those of the solver: mm,
N, MPa.
"""

from __future__ import annotations

import math
import re
import subprocess
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from epicyclic.teeth import geometry
from epicyclic.teeth.form import GearForm, Outline, tooth_outline

from .gear import SOLVER, graded, tip_bulge, with_middles

__all__ = ["FaceCompliance", "SolidMesh", "face_compliance", "spur_motion", "transverse"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class SolidMesh:
    """Elements: layers of the face, rows of the tooth above and below the load, columns of the tooth, of half a gap,
    rows of the body, columns of the ring away from the teeth."""

    layers: int = 10
    above: int = 2
    below: int = 4
    columns: int = 4
    gap: int = 1
    body: int = 5
    rest: int = 12


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FaceCompliance:
    """Mean displacement of layer i per force on layer j, (layers, layers) [mm/N]; radius : (layers,) of load [mm]."""

    matrix: Array
    radius: Array


def transverse(gear: GearForm) -> GearForm:
    """Spur gear whose section is the transverse section of a helical one."""
    if gear.helix_angle == 0:
        return gear
    slant = math.cos(gear.helix_angle)
    return replace(
        gear,
        module=gear.module / slant,
        pressure_angle=math.atan(math.tan(gear.pressure_angle) / slant),
        helix_angle=0.0,
        profile_shift=gear.profile_shift * slant,
        addendum=gear.addendum * slant,
        dedendum=gear.dedendum * slant,
        tip_rounding=slant * (0.38 if gear.tip_rounding is None else gear.tip_rounding),
        tip_radius=gear.tip,
    )


def face_compliance(
    gear: GearForm, width: float, radius: float, *, mesh: SolidMesh, oblique: bool = False
) -> FaceCompliance:
    """Compliance of a tooth along its face, loaded along a contact line.

    width : of the face [m].  radius : of the load in the middle of the face [m].  oblique : along the contact line of a
    helical tooth, else along the helix at that radius.

    Raises
    ------
    FileNotFoundError : no solver on this machine.
    ValueError : a contact line that leaves the flank.
    """
    if SOLVER is None:
        raise FileNotFoundError("ccx")
    section = transverse(gear)
    shape = tooth_outline(section)
    base = shape.base
    slope = math.tan(geometry.base_helix_angle(gear.pressure_angle, gear.helix_angle))
    zeta = np.linspace(-0.5, 0.5, 2 * mesh.layers + 1) * width
    # right flank, whose tooth turns towards -x along the axis: the line of a tooth without runs down towards its root
    lead = (slope if gear.internal else -slope) if oblique else 0.0
    roll = math.sqrt(radius**2 - base**2) + lead * zeta
    radii = np.hypot(base, roll)
    if not (min(shape.tip, shape.form_radius) < radii.min() and radii.max() < max(shape.tip, shape.form_radius)):
        raise ValueError("the contact line leaves the flank")
    turn = zeta * math.tan(gear.helix_angle) / (0.5 * gear.teeth * section.module)
    layers = [_section(section, shape, mesh, float(r) * 1e3) for r in radii]
    points, cells, tooth = _extruded(layers, zeta * 1e3, turn)
    normals = _normals(shape, radii, turn, slope)
    held = np.flatnonzero(np.abs(np.hypot(points[:, 0], points[:, 1]) - 1e3 * section.bore) < 1e-6)
    row = 2 * mesh.above
    flank, middle = tooth[:, row, -1], tooth[:, ::2, tooth.shape[2] // 2]
    places = _crossings(shape, radii, slope, math.tan(gear.helix_angle) / (0.5 * gear.teeth * section.module))
    places = np.column_stack([places[:, 0] * 1e3, np.clip(zeta + places[:, 1], zeta[0], zeta[-1]) * 1e3])
    forces = []
    mirrored = gear.helix_angle == 0
    for j in range((mesh.layers + 1) // 2 if mirrored else mesh.layers):
        forces.append(
            [(int(flank[2 * j + k]), normals[2 * j + k] * share) for k, share in enumerate((1 / 6, 4 / 6, 1 / 6))]
        )
    moved = _calculix(points, cells, held, forces, np.unique(middle), section)
    found = np.empty((mesh.layers, mesh.layers))
    for j, u in enumerate(moved):
        at = np.sum(_middle(points, u, middle, zeta * 1e3, places) * normals, axis=1)
        found[:, j] = (at[:-2:2] + 4 * at[1::2] + at[2::2]) / 6
        if mirrored:
            found[:, -1 - j] = found[::-1, j]
    return FaceCompliance(matrix=found, radius=radii[1::2] * 1e3)


def spur_motion(gear: GearForm, width: float, radius: float, *, mesh: SolidMesh) -> tuple[Array, Array]:
    """Right side of a spur tooth below the load, points (2 layers + 1, n, 3) [mm], and its motion under 1 N on each of
    the layers of the first half of the face, (layers/2, 2 layers + 1, n, 3) [mm]; nan where a brick has no node.

    width : of the face [m].  radius : of the load [m].
    """
    shape = tooth_outline(gear)
    zeta = np.linspace(-0.5, 0.5, 2 * mesh.layers + 1) * width * 1e3
    sections = [_section(gear, shape, mesh, radius * 1e3) for _ in zeta]
    still = np.zeros(len(zeta))
    points, cells, tooth = _extruded(sections, zeta, still)
    normals = _normals(shape, np.full(len(zeta), radius), still, 0.0)
    held = np.flatnonzero(np.abs(np.hypot(points[:, 0], points[:, 1]) - 1e3 * gear.bore) < 1e-6)
    row = 2 * mesh.above
    flank, side = tooth[:, row, -1], tooth[:, row:, -1]
    forces = [
        [(int(flank[2 * j + k]), normals[2 * j + k] * share) for k, share in enumerate((1 / 6, 4 / 6, 1 / 6))]
        for j in range(mesh.layers // 2)
    ]
    moved = _calculix(points, cells, held, forces, np.unique(side), gear)
    return points[side], np.array([u[side] for u in moved])


# mesh ----------------------------------------------------------------------------------------------------------------


def _section(gear: GearForm, shape: Outline, mesh: SolidMesh, radius: float) -> list[Array]:
    """Grids of one section, odd rows and columns mid-sides, (rows, columns, 2) [mm]; the first is the loaded tooth."""
    line = np.column_stack([shape.x, shape.radius * np.cos(shape.psi)]) * 1e3
    corner = shape.form + int(np.searchsorted(shape.slope[shape.form :], np.pi / 4))
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    flank = shape.radius[: shape.form + 1] * 1e3
    order = np.argsort(flank)
    load = float(np.interp(radius, flank[order], along[: shape.form + 1][order]))
    rows = np.concatenate([np.linspace(0, load, mesh.above + 1), np.linspace(load, along[corner], mesh.below + 1)[1:]])
    marks = with_middles(rows)
    across = with_middles(np.linspace(-1, 1, mesh.columns + 1))
    side = np.column_stack([np.interp(marks, along, line[:, axis]) for axis in (0, 1)])
    tooth = np.empty((len(marks), len(across), 2))
    tooth[..., 0] = side[:, None, 0] * across
    tooth[..., 1] = side[:, None, 1]
    tooth[..., 1] += tip_bulge(shape, across, side) * np.exp(-((marks / (0.3 * marks[-1])) ** 2))[:, None]
    floor = along[corner] + (along[-1] - along[corner]) * np.linspace(0, 1, 2 * mesh.gap + 1)[1:]
    right = np.column_stack([np.interp(floor, along, line[:, axis]) for axis in (0, 1)])
    top = np.concatenate([right[::-1] * [-1, 1], tooth[-1], right])
    angle = np.arctan2(top[:, 0], top[:, 1])
    edge = 1e3 * gear.bore
    bottom = np.linspace(-1, 1, len(angle)) * angle[-1]
    grade = graded(2 * mesh.body, abs(edge - np.hypot(*top[-1])), np.pi * gear.module * 1e3 / 8)
    start = np.hypot(*top.T)
    body = _polar(angle + np.outer(np.minimum(1.0, 3 * grade), bottom - angle), start + np.outer(grade, edge - start))
    found = []
    for number in (0, -1, 1):
        rotation = _rotation(-2 * shape.half_pitch * number)
        found += [grid @ rotation.T for grid in (tooth, body)]
    # the ring without teeth: from the edge of the last tooth all the way round, wider and wider columns
    left = np.pi - 3 * shape.half_pitch
    half = np.asarray(graded(mesh.rest, left, 2 * shape.half_pitch / (mesh.columns + 2 * mesh.gap)))
    across = np.concatenate([half * left, 2 * left - (half * left)[-2::-1]]) + 3 * shape.half_pitch
    root = float(np.hypot(*top[-1]))
    found.append(_polar(np.broadcast_to(across, (len(grade), len(across))), root + (grade * (edge - root))[:, None]))
    return found


def _polar(angle: Array, radius: Array) -> Array:
    """Points (..., 2) at angles clockwise from y and radii."""
    return np.stack([radius * np.sin(angle), radius * np.cos(angle)], axis=-1)


def _rotation(turn: float) -> Array:
    return np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])


def _extruded(layers: list[list[Array]], zeta: Array, turn: Array) -> tuple[Array, Index, Index]:
    """Nodes (n, 3), twenty-noded cells (m, 20), and node numbers of the loaded tooth (layers, rows, columns).

    zeta : (layers,) places along the axis, odd ones in the middle of the elements [mm].  turn : (layers,) [rad].
    """
    count, points, cells, tooth = 0, [], [], None
    for g in range(len(layers[0])):
        grid = np.stack([layer[g] for layer in layers])
        numbers = count + np.arange(grid[..., 0].size).reshape(grid.shape[:3])
        count += numbers.size
        c, s = np.cos(turn)[:, None, None], np.sin(turn)[:, None, None]
        x, y = c * grid[..., 0] - s * grid[..., 1], s * grid[..., 0] + c * grid[..., 1]
        points.append(np.stack([x, y, np.broadcast_to(zeta[:, None, None], x.shape)], axis=-1).reshape(-1, 3))
        cells.append(_bricks(numbers, grid[0]))
        tooth = numbers if tooth is None else tooth
    assert tooth is not None
    return _merged(np.concatenate(points), np.concatenate(cells), tooth)


def _bricks(numbers: Index, section: Array) -> Index:
    """Cells (m, 20) of a grid of node numbers (layers, rows, columns), whose even places are corners."""
    low, mid, high = slice(None, -2, 2), slice(1, None, 2), slice(2, None, 2)

    def at(layer: slice, row: slice, column: slice) -> Index:
        return numbers[layer, row, column].reshape(-1)

    ring = [(low, low), (low, high), (high, high), (high, low)]
    sides = [(low, mid), (mid, high), (high, mid), (mid, low)]
    p = section[::2, ::2]
    a, b = p[0, 1] - p[0, 0], p[1, 0] - p[0, 0]
    if a[0] * b[1] - a[1] * b[0] < 0:
        ring, sides = [ring[n] for n in (0, 3, 2, 1)], [sides[n] for n in (3, 2, 1, 0)]
    found = [at(low, *n) for n in ring] + [at(high, *n) for n in ring]
    found += [at(low, *n) for n in sides] + [at(high, *n) for n in sides] + [at(mid, *n) for n in ring]
    return np.stack(found, axis=-1)


def _merged(points: Array, cells: Index, tooth: Index) -> tuple[Array, Index, Index]:
    """One node where several coincide, and only nodes that a cell uses; -1 in the tooth where none does."""
    target = np.arange(len(points))
    for i, j in sorted(cKDTree(points).query_pairs(1e-6)):
        target[j] = min(target[j], target[i])
    cells = target[cells]
    used = np.unique(cells)
    new = np.full(len(points), -1)
    new[used] = np.arange(len(used))
    return points[used], new[cells], new[target[tooth]]


# loads, solution -----------------------------------------------------------------------------------------------------


def _normals(shape: Outline, radii: Array, turn: Array, slope: float) -> Array:
    """Unit vectors (layers, 3) of the load on the right flank."""
    gamma = shape.flank_angle(radii)[1]
    down = 1.0 if shape.internal else -1.0
    own = np.stack([-np.cos(gamma), down * np.sin(gamma)], axis=-1)
    turned = np.stack([_rotation(t) @ n for t, n in zip(turn, own, strict=True)])
    # the tooth moves towards -x with z where the turn rises, so that the right flank looks ahead along z
    axial = np.full(len(radii), -slope)
    return np.column_stack([turned, axial]) / math.hypot(1.0, slope)


def _crossings(shape: Outline, radii: Array, slope: float, twist: float) -> Array:
    """Where the normals meet the middle of the tooth (layers, 2): its radius, and how far along the axis [m].

    slope : tan of the base helix.  twist : turn of the section per length [rad/m].
    """
    psi, gamma = shape.flank_angle(radii)
    down = 1.0 if shape.internal else -1.0
    x, y = radii * np.sin(psi), radii * np.cos(psi)
    reach = x / (np.cos(gamma) + slope * twist * y)  # of the normal in the section; the middle line turns towards it
    return np.column_stack([np.hypot(x - reach * np.cos(gamma), y + down * reach * np.sin(gamma)), -slope * reach])


def _middle(points: Array, moved: Array, middle: Index, zeta: Array, places: Array) -> Array:
    """Displacements (layers, 3) of the middle of the tooth at places (layers, 2): radius and along the axis [mm].

    middle : (layers, n) nodes of the middle of the tooth at zeta (layers,).
    """
    there = np.empty((len(zeta), len(places), 3))
    for k, line in enumerate(middle):
        away = np.hypot(points[line, 0], points[line, 1])
        order = np.argsort(away)
        there[k] = CubicSpline(away[order], moved[line[order]])(places[:, 0])
    return np.array([CubicSpline(zeta, there[:, n])(place) for n, place in enumerate(places[:, 1])])


def _calculix(
    points: Array, cells: Index, held: Index, forces: list[list[tuple[int, Array]]], wanted: Index, gear: GearForm
) -> list[Array]:
    """Displacements (n, 3) [mm] of every load case, of the wanted nodes; nan elsewhere."""
    with tempfile.TemporaryDirectory() as folder:
        job = Path(folder) / "tooth"
        job.with_suffix(".inp").write_text(_deck(points, cells, held, forces, wanted, gear), encoding="ascii")
        done = subprocess.run([str(SOLVER), "-i", str(job)], cwd=folder, capture_output=True, text=True, check=False)
        result = job.with_suffix(".dat")
        if done.returncode or not result.exists():
            raise RuntimeError(done.stdout[-2000:] + done.stderr[-2000:])
        return _printed(result.read_text(encoding="ascii"), len(points))


def _deck(
    points: Array, cells: Index, held: Index, forces: list[list[tuple[int, Array]]], wanted: Index, gear: GearForm
) -> str:
    lines = ["*NODE, NSET=NALL"]
    lines += [f"{k + 1}, {x:.12g}, {y:.12g}, {z:.12g}" for k, (x, y, z) in enumerate(points)]
    lines += ["*ELEMENT, TYPE=C3D20R, ELSET=EALL"]
    for k, cell in enumerate(cells):
        names = [str(n + 1) for n in cell]
        lines += [f"{k + 1}, " + ", ".join(names[:12]) + ",", ", ".join(names[12:])]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{gear.youngs_modulus / 1e6:.12g}, {gear.poisson}"]
    lines += ["*SOLID SECTION, ELSET=EALL, MATERIAL=M"]
    lines += ["*NSET, NSET=HELD", *(f"{n + 1}," for n in held)]
    lines += ["*NSET, NSET=MIDDLE", *(f"{n + 1}," for n in wanted)]
    lines += ["*BOUNDARY", "HELD, 1, 3"]
    for nodes in forces:
        lines += ["*STEP", "*STATIC", "*CLOAD, OP=NEW"]
        total: dict[tuple[int, int], float] = {}
        for n, vector in nodes:
            for axis, value in enumerate(vector):
                total[n, axis] = total.get((n, axis), 0.0) + float(value)
        lines += [f"{n + 1}, {axis + 1}, {value:.12g}" for (n, axis), value in total.items()]
        lines += ["*NODE PRINT, NSET=MIDDLE", "U", "*END STEP"]
    return "\n".join(lines) + "\n"


def _printed(text: str, count: int) -> list[Array]:
    """Displacements of every step in the printed file."""
    found: list[Array] = []
    for block in re.split(r"displacements[^\n]*\n", text)[1:]:
        values = np.full((count, 3), np.nan)
        for line in block.splitlines():
            parts = line.split()
            if len(parts) == 4:
                # an exponent of three digits has no letter: as good as zero
                values[int(parts[0]) - 1] = [float(p) if "E" in p else 0.0 for p in parts[1:]]
        found.append(values)
    return found
