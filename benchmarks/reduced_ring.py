"""A ring of bricks: mesh, matrices by CalculiX, reduction to the file that tests keep.

python benchmarks/reduced_ring.py [FILE]     writes tests/unit/bodies/ring.npz

The ring has the mass and inertia of the ring gear of [lin1999]: 2.35 kg, mean radius 155.379 mm.
"""

from __future__ import annotations

import itertools
import math
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

from epicyclic.bodies.files import native_bytes, read_body
from epicyclic.bodies.joined_body import Interface, reduced
from epicyclic.bodies.reduced_body import ReducedBody, checked

MASS, WIDTH, DENSITY, YOUNG, POISSON = 2.35, 0.0254, 7850.0, 2.07e11, 0.3
RADIUS = 0.13752 * math.sqrt(3 / MASS)
HEIGHT = MASS / (2 * math.pi * RADIUS * DENSITY * WIDTH)
SECTORS, PLANETS, MODES = 48, 4, 60
KEPT = Path(__file__).parents[1] / "tests" / "unit" / "bodies" / "ring.npz"
# of a brick of 20 nodes: half sectors, half heights, half widths
CORNERS = [(0, 0, 0), (0, 2, 0), (2, 2, 0), (2, 0, 0), (0, 0, 2), (0, 2, 2), (2, 2, 2), (2, 0, 2)]
MIDDLES = [(0, 1, 0), (1, 2, 0), (2, 1, 0), (1, 0, 0), (0, 1, 2), (1, 2, 2), (2, 1, 2), (1, 0, 2)]
POSTS = [(0, 0, 1), (0, 2, 1), (2, 2, 1), (2, 0, 1)]


@dataclass(frozen=True)
class Mesh:
    """Elements round the ring, its height [m] and elements over it, one over the width; ratio of Poisson [1]."""

    sectors: int = SECTORS
    height: float = HEIGHT
    layers: int = 1
    poisson: float = POISSON

    def places(self) -> dict[tuple[int, int, int], tuple[int, float, float, float]]:
        """Number and place [m] of the node at each half sector, half layer and half width."""
        found: dict[tuple[int, int, int], tuple[int, float, float, float]] = {}
        for sector, layer in itertools.product(range(self.sectors), range(self.layers)):
            for key in self._cell(sector, layer):
                angle = math.pi * key[0] / self.sectors
                radius = RADIUS + (key[1] / self.layers - 1) * self.height / 2
                place = radius * math.cos(angle), radius * math.sin(angle), (key[2] - 1) * WIDTH / 2
                found.setdefault(key, (len(found) + 1, *place))
        return found

    def _cell(self, sector: int, layer: int) -> list[tuple[int, int, int]]:
        """Keys of the 20 nodes of an element, in the order of CalculiX."""
        own = CORNERS + MIDDLES + POSTS
        return [((2 * sector + turn) % (2 * self.sectors), 2 * layer + up, along) for turn, up, along in own]

    def lines(self, element: str = "C3D20") -> list[str]:
        """The mesh as CalculiX reads it; numbers have at most 20 characters, as it cuts longer ones."""
        nodes = self.places()
        lines = ["*NODE", *(f"{n}, {x:.12e}, {y:.12e}, {z:.12e}" for n, x, y, z in nodes.values())]
        lines += [f"*ELEMENT, TYPE={element}, ELSET=RING"]
        for i, of in enumerate(itertools.product(range(self.sectors), range(self.layers)), start=1):
            cell = [str(nodes[key][0]) for key in self._cell(*of)]
            lines += [f"{i}, {', '.join(cell[:10])},", ", ".join(cell[10:])]
        lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", f"{YOUNG:.12g}, {self.poisson}", "*DENSITY", f"{DENSITY}"]
        return [*lines, "*SOLID SECTION, ELSET=RING, MATERIAL=STEEL"]


def run(folder: Path, name: str, lines: list[str]) -> None:
    """A deck, written into a folder and solved there by CalculiX."""
    (folder / f"{name}.inp").write_text("\n".join(lines) + "\n", encoding="ascii")
    subprocess.run([str(shutil.which("ccx")), "-i", name], cwd=folder, capture_output=True, check=True)


def solved(folder: Path, element: str = "C3D20", mesh: Mesh = Mesh()) -> Path:
    """Matrices of the ring, written by CalculiX into a folder: the .sti, with .mas, .dof and .inp beside it."""
    matrices = ["*STEP", "*FREQUENCY, SOLVER=MATRIXSTORAGE", "1", "*END STEP"]
    run(folder, "ring", mesh.lines(element) + matrices)
    return folder / "ring.sti"


def planets() -> tuple[Interface, ...]:
    """Two nodes at mid-width, inside and outside, at each of the planets."""
    nodes, step = Mesh().places(), 2 * SECTORS // PLANETS
    pairs = [(nodes[step * i, 0, 1][0], nodes[step * i, 2, 1][0]) for i in range(PLANETS)]
    return tuple(Interface(name=f"planet-{i + 1}", nodes=pair, spider="nodes") for i, pair in enumerate(pairs))


def reduced_ring(ring: ReducedBody, modes: int = MODES) -> ReducedBody:
    """The ring in 24 coordinates of the planets and modes with these held."""
    body, _ = reduced(ring, planets(), modes, "ring")
    text = f"{SECTORS} C3D20 of CalculiX, {len(ring.dof_dir)} coordinates: benchmarks/reduced_ring.py"
    return checked(replace(body, mass=MASS, source=text), "ring")[0]


def main(target: Path) -> None:
    """Write the kept file."""
    with tempfile.TemporaryDirectory() as folder:
        ring, _ = read_body(solved(Path(folder)), units="kg m s")
    target.write_bytes(native_bytes(reduced_ring(ring)))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else KEPT)
