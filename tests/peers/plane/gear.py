"""A spur gear in plane strain as finite elements, solved with CalculiX: the independent peer of the tooth compliance.

The whole gear is meshed, every tooth of it, by one structured grid a pitch: the tooth from its tip to a cross line in
the fillet, and the body from there down to the bore (of a ring: out to the rim), which is held.  Loaded teeth are
meshed finely around the load, whose pressure is Hertz's ellipse.  Units here are those of the solver: mm, N, MPa,
thickness 1 mm.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from epicyclic.teeth.form import GearForm, Outline, tooth_outline

__all__ = [
    "SOLVER",
    "Answer",
    "Fineness",
    "Load",
    "calculix",
    "gear_mesh",
    "graded",
    "held_nodes",
    "pressed",
    "solve",
    "tip_bulge",
    "with_middles",
]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SOLVER = shutil.which("ccx")
# A mesh twice as fine everywhere moves what is measured by 3e-4.
_COARSE = (3, 4, 2)  # rows and columns of a tooth without load, columns of half a gap
_STEP = 4  # elements over the half width of contact


@dataclass(frozen=True, slots=True, kw_only=True)
class Fineness:
    """Rows and columns of a loaded tooth, columns of half a gap; rows of the body; first of these, 1: a sixth of the
    thickness of a tooth."""

    tooth: tuple[int, int, int]
    body: int
    first: float


_FINE = Fineness(tooth=(8, 8, 4), body=10, first=1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Load:
    """1 N/mm along the normal at a radius [mm] of tooth number `tooth`, spread over +- half_width [mm]."""

    tooth: int
    radius: float
    half_width: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Answer:
    """Displacements along the normal per load, (loads, loads) [mm^2/N]: row where, column which load.

    surface : mean under the pressure there.  middle : of the middle of the tooth, on the line of load.
    """

    surface: Array
    middle: Array


def solve(gear: GearForm, loads: Sequence[Load]) -> Answer:
    """Displacements under unit loads on the right flanks of a gear; teeth are numbered clockwise from the one at +y.

    Raises
    ------
    FileNotFoundError : no solver on this machine.
    """
    if SOLVER is None:
        raise FileNotFoundError("ccx")
    shape = tooth_outline(gear)
    points, cells, places = gear_mesh(gear, shape, loads)
    held = held_nodes(points, gear)
    forces = [pressed(points, places[load.tooth], shape, load) for load in loads]
    moved = calculix(points, cells, held, forces, gear)
    surface = np.array([[np.sum(f * u[n]) for u in moved] for n, f in forces])
    middle = np.array([[_middle(points, u, shape, load) for u in moved] for load in loads])
    return Answer(surface=surface, middle=middle)


# mesh ----------------------------------------------------------------------------------------------------------------


def gear_mesh(
    gear: GearForm, shape: Outline, loads: Sequence[Load], fine: Fineness = _FINE
) -> tuple[Array, Index, dict[int, Index]]:
    """Nodes (n, 2) [mm], eight-noded cells (m, 8), and per loaded tooth the node numbers of its grid."""
    found: list[Array] = []
    cells: list[Index] = []
    places: dict[int, Index] = {}
    count = 0
    for number in range(gear.teeth):
        own = [load for load in loads if load.tooth == number]
        tooth, body = _pitch(gear, shape, own, fine)
        rotation = _rotation(shape, number)
        for grid in (tooth, body):
            numbers = count + np.arange(grid.shape[0] * grid.shape[1]).reshape(grid.shape[:2])
            count += numbers.size
            found.append(grid.reshape(-1, 2) @ rotation.T)
            cells.append(_cells(numbers, grid))
            if own and grid is tooth:
                places[number] = numbers
    return _merged(np.concatenate(found), np.concatenate(cells), places)


def _pitch(gear: GearForm, shape: Outline, loads: Sequence[Load], fine: Fineness) -> tuple[Array, Array]:
    """Grids of a tooth and of the body under it, odd rows and columns mid-sides, (rows, columns, 2) [mm]."""
    line = np.column_stack([shape.x, shape.radius * np.cos(shape.psi)]) * 1e3
    corner = shape.form + int(np.searchsorted(shape.slope[shape.form :], np.pi / 4))
    rows, columns, gap = fine.tooth if loads else _COARSE
    body_rows, first = fine.body, fine.first
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    marks = _marks(along[corner], rows, [(_arc_at(shape, along, load), load.half_width) for load in loads])
    across = _across(columns, [load.half_width for load in loads], float(line[corner, 0]))
    side = np.column_stack([np.interp(marks, along, line[:, axis]) for axis in (0, 1)])
    tooth = np.empty((len(marks), len(across), 2))
    tooth[..., 0] = side[:, None, 0] * across
    tooth[..., 1] = side[:, None, 1]
    tooth[..., 1] += tip_bulge(shape, across, side) * np.exp(-((marks / (0.3 * marks[-1])) ** 2))[:, None]
    floor = along[corner] + (along[-1] - along[corner]) * np.linspace(0, 1, 2 * gap + 1)[1:]
    right = np.column_stack([np.interp(floor, along, line[:, axis]) for axis in (0, 1)])
    top = np.concatenate([right[::-1] * [-1, 1], tooth[-1], right])
    angle = np.arctan2(top[:, 0], top[:, 1])
    edge = 1e3 * gear.bore
    bottom = np.linspace(-1, 1, len(angle)) * 0.4 * angle[-1] + 0.6 * angle  # the crowded columns open towards it
    grade = graded(2 * body_rows, abs(edge - np.hypot(*top[-1])), np.pi * gear.module * 1e3 / 12 * first)
    start, end = np.hypot(*top.T), np.full(len(top), edge)
    radius = start + np.outer(grade, end - start)
    theta = angle + np.outer(np.minimum(1.0, 3 * grade), bottom - angle)
    body = np.stack([radius * np.sin(theta), radius * np.cos(theta)], axis=-1)
    return tooth, body


def _arc_at(shape: Outline, along: Array, load: Load) -> float:
    radius = shape.radius[: shape.form + 1]
    order = np.argsort(radius)
    return float(np.interp(load.radius * 1e-3, radius[order], along[: shape.form + 1][order]))


def _marks(length: float, rows: int, spots: Sequence[tuple[float, float]]) -> Array:
    """Places of the rows along the outline from the tip, element ends and mid-sides, fine around the loads [mm]."""
    dense = np.linspace(0, length, 40001)
    density = np.full_like(dense, rows / length)
    for place, half in spots:
        fine, away = _STEP / half, np.abs(dense - place)
        density += fine / (1 + (np.maximum(away - 1.5 * half, 0) / (0.5 * half))) ** 1.15
    total = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(dense))])
    count = int(np.ceil(total[-1]))
    ends = np.interp(np.linspace(0, total[-1], count + 1), total, dense)
    return with_middles(ends)


def _across(columns: int, halves: Sequence[float], half_root: float) -> Array:
    """Places of the columns over half the thickness, -1 .. 1, fine below the loaded right flank."""
    even = np.linspace(-1, 1, columns + 1)
    if halves:
        first = min(halves) / (_STEP * half_root)
        steps = [1.0]
        size = first
        while size < 2 / columns and steps[-1] - size > 0:
            steps.append(steps[-1] - size)
            size *= 1.25
        left = steps[-1]
        n = max(2, int(np.ceil(left / (2 / columns))))
        even = np.concatenate([np.linspace(-1, 0, columns // 2 + 1), np.linspace(0, left, n + 1)[1:], steps[-2::-1]])
    return with_middles(even)


def tip_bulge(shape: Outline, across: Array, side: Array) -> Array:
    """How far the tip circle stands off the straight cross line at the tip [mm]."""
    tip = shape.tip * 1e3
    return np.asarray(np.sqrt(tip**2 - (side[0, 0] * across) ** 2) - side[0, 1])


def graded(rows: int, length: float, first: float) -> Array:
    """Shares 0 .. 1 of the way, element sizes growing from the first."""
    elements = rows // 2
    low, high = 1.0 + 1e-9, 3.0
    for _ in range(80):
        ratio = 0.5 * (low + high)
        low, high = (low, ratio) if first * (ratio**elements - 1) / (ratio - 1) > length else (ratio, high)
    ends = np.concatenate([[0.0], np.cumsum(ratio ** np.arange(elements))])
    return with_middles(ends / ends[-1])


def with_middles(ends: Array) -> Array:
    found = np.empty(2 * len(ends) - 1)
    found[::2] = ends
    found[1::2] = 0.5 * (ends[1:] + ends[:-1])
    return found


def _cells(numbers: Index, grid: Array) -> Index:
    a, b = numbers[:-2:2, :-2:2], numbers[:-2:2, 2::2]
    c, d = numbers[2::2, 2::2], numbers[2::2, :-2:2]
    ab, bc, cd, da = numbers[:-2:2, 1::2], numbers[1::2, 2::2], numbers[2::2, 1::2], numbers[1::2, :-2:2]
    found = np.stack([a, b, c, d, ab, bc, cd, da], axis=-1).reshape(-1, 8)
    p = grid.reshape(-1, 2)[found - numbers.min()]
    area = np.sum(p[:, 0, 0] * (p[:, 1, 1] - p[:, 3, 1]) + p[:, 2, 0] * (p[:, 3, 1] - p[:, 1, 1]))
    return found if area > 0 else found[:, [0, 3, 2, 1, 7, 6, 5, 4]]


def _merged(points: Array, cells: Index, places: dict[int, Index]) -> tuple[Array, Index, dict[int, Index]]:
    """One node where several coincide, and only nodes that a cell uses."""
    target = np.arange(len(points))
    for i, j in sorted(cKDTree(points).query_pairs(1e-7)):
        target[j] = min(target[j], target[i])
    cells = target[cells]
    used = np.unique(cells)
    new = np.full(len(points), -1)
    new[used] = np.arange(len(used))
    return points[used], new[cells], {k: new[target[v]] for k, v in places.items()}


# loads, supports, solution -------------------------------------------------------------------------------------------


def held_nodes(points: Array, gear: GearForm) -> Index:
    return np.flatnonzero(np.abs(np.hypot(*points.T) - 1e3 * gear.bore) < 1e-6)


def pressed(points: Array, grid: Index, shape: Outline, load: Load) -> tuple[Index, Array]:
    """Nodes of the right flank and their forces, (n,) and (n, 2), of an elliptic pressure of 1 N/mm."""
    nodes = grid[:, -1]
    flank = points[nodes]
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(flank, axis=0).T))])
    radius = np.hypot(*flank.T)
    order = np.argsort(radius)
    centre = float(np.interp(load.radius, radius[order], length[order]))
    gauss, weights = np.polynomial.legendre.leggauss(12)
    share = np.zeros(len(nodes))
    for k in range(0, len(nodes) - 2, 2):
        low, high = max(length[k], centre - load.half_width), min(length[k + 2], centre + load.half_width)
        if high <= low:
            continue
        s = low + (high - low) * 0.5 * (gauss + 1)
        p = 2 / (np.pi * load.half_width) * np.sqrt(np.maximum(0, 1 - ((s - centre) / load.half_width) ** 2))
        t = 2 * (s - length[k]) / (length[k + 2] - length[k]) - 1
        w = 0.5 * (high - low) * weights * p
        share[k : k + 3] += [np.sum(w * t * (t - 1) / 2), np.sum(w * (1 - t**2)), np.sum(w * t * (t + 1) / 2)]
    share /= share.sum()
    on = np.flatnonzero(share)
    return nodes[on], share[on, None] * _direction(shape, load)


def _direction(shape: Outline, load: Load) -> Array:
    """Unit vector of the load on the right flank of a tooth, in the axes of the gear."""
    gamma = float(shape.flank_angle(np.array([load.radius * 1e-3]))[1][0])
    down = 1.0 if shape.internal else -1.0
    own = np.array([-np.cos(gamma), down * np.sin(gamma)])
    return np.asarray(_rotation(shape, load.tooth) @ own)


def _rotation(shape: Outline, tooth: int) -> Array:
    """From the axes of a tooth, itself along +y, to those of the gear."""
    turn = -2 * shape.half_pitch * tooth
    return np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])


def _middle(points: Array, moved: Array, shape: Outline, load: Load) -> float:
    """Displacement along the load of the middle of the tooth where the line of load meets it."""
    psi, gamma = (float(v[0]) for v in shape.flank_angle(np.array([load.radius * 1e-3])))
    down = 1.0 if shape.internal else -1.0
    place = load.radius * (np.cos(psi) + down * np.sin(psi) * np.tan(gamma))
    off, local = (points @ _rotation(shape, load.tooth)).T
    line = np.flatnonzero((np.abs(off) < 1e-7) & (local > 0))
    line = line[np.argsort(local[line])]
    value = CubicSpline(local[line], moved[line])(place)
    return float(value @ _direction(shape, load))


def calculix(
    points: Array,
    cells: Index,
    held: Index,
    forces: Sequence[tuple[Index, Array]],
    gear: GearForm,
    *,
    stresses: bool = False,
) -> list[Array]:
    """Displacements (n, 2) [mm] of every load case, or stresses (n, 3) [MPa], xx, yy, xy, means at the nodes."""
    with tempfile.TemporaryDirectory() as folder:
        job = Path(folder) / "gear"
        job.with_suffix(".inp").write_text(_deck(points, cells, held, forces, gear, stresses), encoding="ascii")
        done = subprocess.run([str(SOLVER), "-i", str(job)], cwd=folder, capture_output=True, text=True, check=False)
        result = job.with_suffix(".frd")
        if done.returncode or not result.exists():
            raise RuntimeError(done.stdout[-2000:] + done.stderr[-2000:])
        columns = (0, 1, 3) if stresses else (0, 1)
        return _blocks(result.read_text(encoding="ascii"), len(points), "STRESS" if stresses else "DISP", columns)


def _deck(
    points: Array, cells: Index, held: Index, forces: Sequence[tuple[Index, Array]], gear: GearForm, stresses: bool
) -> str:
    lines = ["*NODE, NSET=NALL"]
    lines += [f"{k + 1}, {x:.12g}, {y:.12g}, 0" for k, (x, y) in enumerate(points)]
    lines += ["*ELEMENT, TYPE=CPE8R, ELSET=EALL"]
    lines += [f"{k + 1}, " + ", ".join(str(n + 1) for n in cell) for k, cell in enumerate(cells)]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{gear.youngs_modulus / 1e6:.12g}, {gear.poisson}"]
    lines += ["*SOLID SECTION, ELSET=EALL, MATERIAL=M", "1."]
    lines += ["*NSET, NSET=HELD", *(f"{n + 1}," for n in held)]
    lines += ["*BOUNDARY", "HELD, 1, 2"]
    for nodes, vectors in forces:
        lines += ["*STEP", "*STATIC", "*CLOAD, OP=NEW"]
        for n, vector in zip(nodes, vectors, strict=True):
            lines += [f"{n + 1}, {axis + 1}, {value:.12g}" for axis, value in enumerate(vector)]
        lines += ["*EL FILE, OUTPUT=2D", "S"] if stresses else ["*NODE FILE, OUTPUT=2D", "U"]
        lines += ["*END STEP"]
    return "\n".join(lines) + "\n"


def _blocks(text: str, count: int, name: str, columns: tuple[int, ...]) -> list[Array]:
    """Columns of the blocks of a name in a result file, (count, columns) each."""
    found: list[Array] = []
    block: Array | None = None
    for line in text.splitlines():
        if line.startswith(f" -4  {name}"):
            block = np.full((count, len(columns)), np.nan)
        elif block is not None and line.startswith(" -1"):
            block[int(line[3:13]) - 1] = [float(line[13 + 12 * k : 25 + 12 * k]) for k in columns]
        elif block is not None and line.startswith(" -3"):
            found.append(block)
            block = None
    return found
