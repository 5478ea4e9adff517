"""Draw the signs of docs/conventions.md: python docs/theory/signs/make.py

The vectors drawn are computed here from what stands on a drawing (teeth, module, angles, the sense of the torque), by
the rules of the page and without the package.  tests/unit/test_docs_signs.py compares them with the assembled train.
"""

from __future__ import annotations

from math import atan, cos, pi, sin, tan
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

__all__ = ["DRIVE", "DrawnMesh", "drawings", "leads", "meshes_of"]

HERE = Path(__file__).parent
# The stage drawn: 21/39/99 teeth, right-handed sun, driven counter-clockwise; its model file is `DRIVE`.
SUN, PLANET, RING, MODULE, HELIX, ANGLE, BRANCHES = 21, 39, 99, 10e-3, 7.5, 20.0, 4
DRIVE = {
    "format": 2,
    "title": "The stage of the drawings of signs",
    "stages": {
        "main": {
            "planets": BRANCHES,
            "module": f"{MODULE} m",
            "helix_angle": f"{HELIX} deg",
            "face_width": "200 mm",
            "sun": {"teeth": SUN},
            "planet": {"teeth": PLANET},
            "ring": {"teeth": RING, "addendum": 0.9},
            "carrier": {"mass": "900 kg", "inertia": "70 kg m^2"},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": "1000 rpm"}, "torque": {"sun": "7 kN m"}},
}
INK, PUSH, TEAL, BLUE, PALE = "#333333", "#b3261e", "#00695c", "#0b5394", "#d9d9d9"


class DrawnMesh(NamedTuple):
    """A mesh as drawn: centres (2,) [m], unit vectors e (3,) and n (3,), pitch point (3,) [m], d, hand of A."""

    name: str
    a: str
    b: str
    centre_a: Array
    centre_b: Array
    e: Array
    n: Array
    point: Array
    d: int
    hand: int

    @property
    def row(self) -> tuple[Array, Array]:
        """[n, r x n] of A, and the same of B with the other sign."""
        r_a, r_b = self.point - self.centre_a, self.point - self.centre_b
        return np.r_[self.n, np.cross(r_a, self.n)], -np.r_[self.n, np.cross(r_b, self.n)]


def meshes_of(sense: int = 1) -> tuple[DrawnMesh, DrawnMesh]:
    """Sun and ring mesh of planet 1, for a torque of the given sense (+1 counter-clockwise) on the sun.

    The sun pushes the planet the way it is driven, so d of the sun mesh is that sense.  The planet has no torque of its
    own: the ring must turn it back, so the planet pushes the ring the other way.
    """
    transverse = MODULE / cos(HELIX * pi / 180)
    centre = np.array([transverse * (SUN + PLANET) / 2, 0.0, 0.0])
    zero, e = np.zeros(3), np.array([1.0, 0.0, 0.0])
    at_sun, at_ring = np.array([transverse * SUN / 2, 0, 0]), np.array([transverse * RING / 2, 0, 0])
    return (
        DrawnMesh(
            name="main/sun-planet/1",
            a="main/sun",
            b="main/planet/1",
            centre_a=zero,
            centre_b=centre,
            e=e,
            n=_normal(sense, hand=1),
            point=at_sun,
            d=sense,
            hand=1,
        ),
        DrawnMesh(
            name="main/planet-ring/1",
            a="main/planet/1",
            b="main/ring",
            centre_a=centre,
            centre_b=zero,
            e=e,
            n=_normal(-sense, hand=-1),
            point=at_ring,
            d=-sense,
            hand=-1,
        ),
    )


def _normal(d: int, hand: int) -> Array:
    """n of docs/conventions.md, with e along x and t along y."""
    beta, alpha_n = HELIX * pi / 180, ANGLE * pi / 180
    alpha = atan(tan(alpha_n) / cos(beta))
    beta_b = atan(tan(beta) * cos(alpha))
    return np.array([cos(beta_b) * sin(alpha), d * cos(beta_b) * cos(alpha), -hand * d * sin(beta_b)])


def leads() -> list[float]:
    """Leads of the sun meshes in mesh cycles: sun mesh i leads by -z_s psi_i / 2 pi."""
    return [(-SUN * i / BRANCHES) % 1.0 for i in range(BRANCHES)]


# drawing: y is up, one metre is `SCALE` of the picture ----------------------------------------------------------------

SCALE = 1000.0


def drawings() -> dict[str, str]:
    """Name of every picture -> SVG."""
    return {"mesh": _mesh_picture(), "axes": _axes_picture(), "phases": _phases_picture()}


def _svg(width: int, height: int, parts: list[str]) -> str:
    marks = "".join(
        f'<marker id="{name}" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" '
        f'orient="auto-start-reverse"><path d="M0,1 L10,5 L0,9 z" fill="{colour}"/></marker>'
        for name, colour in (("ink", INK), ("push", PUSH), ("teal", TEAL), ("blue", BLUE))
    )
    body = "\n".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        f'font-family="Verdana, DejaVu Sans, sans-serif" font-size="14">\n<rect width="{width}" height="{height}" '
        f'fill="#ffffff"/>\n<defs>{marks}</defs>\n{body}\n</svg>\n'
    )


def _line(x1: float, y1: float, x2: float, y2: float, colour: str = INK, more: str = "") -> str:
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" {more}/>'


def _arrow(x: float, y: float, dx: float, dy: float, name: str, colour: str) -> str:
    return _line(x, y, x + dx, y - dy, colour, f'stroke-width="2.5" marker-end="url(#{name})"')


def _text(x: float, y: float, words: str, colour: str = INK, anchor: str = "start") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}">{words}</text>'


def _circle(x: float, y: float, r: float, colour: str, fill: str = "none") -> str:
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r:.1f}" stroke="{colour}" fill="{fill}" stroke-width="1.5"/>'


def _mesh_picture() -> str:
    """Both meshes of planet 1: e, t, n and the forces on the bodies."""
    ox, oy, parts = 130.0, 260.0, []
    sun, ring = meshes_of()
    planet = sun.centre_b[0] * SCALE
    parts += [_circle(ox, oy, sun.point[0] * SCALE, BLUE, "#e8f0fa"), _text(ox - 32, oy + 5, "A: sun", BLUE)]
    radius = (sun.centre_b[0] - sun.point[0]) * SCALE
    parts += [_circle(ox + planet, oy, radius, TEAL, "#e6f2f0")]
    parts += [_text(ox + planet, oy + 90, "planet: B of the sun mesh,", TEAL, "middle")]
    parts += [_text(ox + planet, oy + 108, "A of the ring mesh", TEAL, "middle")]
    rim = ring.point[0] * SCALE
    arc = 250.0 / rim
    parts += [
        f'<path d="M{ox + rim * cos(arc):.1f},{oy + rim * sin(arc):.1f} A{rim:.1f},{rim:.1f} 0 0 0 '
        f'{ox + rim * cos(arc):.1f},{oy - rim * sin(arc):.1f}" stroke="{INK}" fill="none" stroke-width="1.5"/>'
    ]
    parts += [_text(ox + rim + 14, oy + 215, "B: ring")]
    for mesh, label in ((sun, "sun mesh"), (ring, "ring mesh")):
        px, py = ox + mesh.point[0] * SCALE, oy
        parts += [_circle(px, py, 4, INK, INK)]
        parts += [_arrow(px, py, 62, 0, "ink", INK), _text(px + 66, py + 18, "e")]
        parts += [_arrow(px, py, 0, 62, "ink", INK), _text(px - 16, py - 56, "t")]
        parts += [_arrow(px, py, 130 * mesh.n[0], 130 * mesh.n[1], "push", PUSH)]
        up = -1 if mesh.n[1] > 0 else 1
        parts += [_text(px + 52, py + up * 118, "n: force on B", PUSH)]
        parts += [_text(px + 52, py + up * 140, f"{label}, d = {mesh.d:+d}")]
    sense = f"M{ox - 40:.0f},{oy - 40:.0f} A56,56 0 0 0 {ox - 40:.0f},{oy + 40:.0f}"
    parts += [f'<path d="{sense}" stroke="{BLUE}" fill="none" stroke-width="2.5" marker-end="url(#blue)"/>']
    parts += [
        _text(ox - 118, oy - 150, "torque on the sun,", BLUE),
        _text(ox - 118, oy - 132, "counter-clockwise", BLUE),
    ]
    return _svg(840, 520, parts)


def _axes_picture() -> str:
    """Axes of the stage, and the own axes of each planet."""
    ox, oy, radius, parts = 260.0, 250.0, 150.0, []
    parts += [_circle(ox, oy, radius, PALE), _circle(ox, oy, 40, BLUE, "#e8f0fa")]
    parts += [_arrow(ox, oy, 235, 0, "ink", INK), _text(ox + 210, oy + 22, "x: through branch 1")]
    parts += [_arrow(ox, oy, 0, 225, "ink", INK), _text(ox + 10, oy - 215, "y")]
    parts += [_text(ox - 34, oy + 60, "stage axes", BLUE)]
    for i in range(3):
        psi = 2 * pi * i / 3
        px, py = ox + radius * cos(psi), oy - radius * sin(psi)
        parts += [_circle(px, py, 46, TEAL, "#e6f2f0"), _circle(px, py, 3, TEAL, TEAL)]
        parts += [_arrow(px, py, 72 * cos(psi), 72 * sin(psi), "teal", TEAL)]
        parts += [_arrow(px, py, -72 * sin(psi), 72 * cos(psi), "push", PUSH)]
        beside = px + 78 * cos(psi) - 20 * sin(psi), py - 78 * sin(psi) - 20 * cos(psi) + 5
        parts += [_text(*beside, f"x{i + 1}", TEAL, "middle")]
        parts += [_text(px - 90 * sin(psi) - 6, py - 90 * cos(psi) + 8, f"y{i + 1}", PUSH)]
        parts += [_text(px - 24 * cos(psi), py + 24 * sin(psi) + 14, f"planet {i + 1}", TEAL, "middle")]
    parts += [
        f'<path d="M{ox + 52:.0f},{oy - 20:.0f} A56,56 0 0 0 {ox + 20:.0f},{oy - 52:.0f}" stroke="{INK}" '
        f'fill="none" stroke-width="2" marker-end="url(#ink)"/>'
    ]
    parts += [
        _text(560, 60, "z towards the viewer:"),
        _text(560, 80, "counter-clockwise is positive"),
        _text(560, 100, "for every body"),
    ]
    parts += [
        _text(560, 150, "x_i outward through the pin,", TEAL),
        _text(560, 170, "y_i = z cross x_i: a pin with", PUSH),
        _text(560, 190, "position.y &gt; 0 is displaced", PUSH),
        _text(560, 210, "counter-clockwise", PUSH),
    ]
    return _svg(840, 500, parts)


def _phases_picture() -> str:
    """Place of the contact of the four sun meshes at t = 0, and where it goes."""
    left, width, parts = 190.0, 420.0, []
    parts += [_text(left + width / 2, 34, "sigma, in base pitches from the pitch point", INK, "middle")]
    for tick in (0.0, 0.25, 0.5, 0.75, 1.0):
        x = left + tick * width
        parts += [_line(x, 60, x, 300, PALE), _text(x, 54, f"{tick:g}", INK, "middle")]
    for i, lead in enumerate(leads()):
        y = 95.0 + 55 * i
        parts += [_line(left, y, left + width, y, INK), _text(left - 20, y + 5, f"sun mesh {i + 1}", INK, "end")]
        parts += [_circle(left + lead * width, y, 7, PUSH, PUSH)]
        parts += [_arrow(left + lead * width + 10, y, 60, 0, "push", PUSH)]
        parts += [_text(left + width + 30, y + 5, f"lead {lead:g}", PUSH)]
    parts += [_text(left, 330, "at t = 0; D = +1: the contact moves along n")]
    return _svg(840, 350, parts)


if __name__ == "__main__":
    for name, text in drawings().items():
        (HERE / f"{name}.svg").write_text(text, encoding="utf-8")
