"""Forces in the linear links, bearings, supports and couplings, of a steady response."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...system.system import ComplexArray, System
from .response import Block, Response
from .waveform import Signal, Spectrum, by_speed, complex_rows, solved_rows

__all__ = ["lateral", "link_signal"]

Index = NDArray[np.int64]


def link_signal(ready: Response, block: Block) -> Signal:
    """Force k (B^T q - e) + c d/dt(...) + preload of every link row [N, N m] at all frequencies kept.

    Dampers to the housing in a turning frame act on the absolute velocity; their part s skew B^T q is in it.
    """
    shafts = block.shaft is not None
    return Signal(
        orders=_spectrum(ready, block, shifted=False),
        lines=_spectrum(ready, block, shifted=True) if shafts else None,
        comb=ready.comb(block.kept, shafts=shafts, dropped=False),
        cross=block.kept[-1],
    )


def _spectrum(ready: Response, block: Block, *, shifted: bool) -> Spectrum:
    links, solved = ready.system.links, solved_rows(block, shifted=shifted)
    P, _, J, n = solved.y.shape
    rows = links.B.T @ ready.modal.shapes
    # A rigid mode strains no link: what is left is rounding, which 1/omega^2 of a slow shaft order would blow up.
    rows[:, ready.modal.rigid] = 0.0
    stretch = by_speed(complex_rows((rows @ solved.y.reshape(-1, n).T).reshape(len(rows), P, 2 * J)), block)
    turned = None
    if links.skew.size:
        frame = block.speed if ready.frame_speed == "kinematic" else np.ones_like(block.speed)
        turned = frame[:, None, None] * np.tensordot(links.skew, stretch, axes=1)
    stretch -= _errors(ready, block, shifted=shifted)[:, None]
    force = links.stiffness[:, None, None, None] * stretch
    if links.damping.any():
        omega = solved.frequency.reshape(block.speed.size, -1, J)
        force += 1j * links.damping[:, None, None, None] * omega * stretch
    if turned is not None:
        force += turned
    if links.preload.size and not shifted:
        force[:, :, 0, 0] += links.preload[:, None]
    points = ready.kernel(block.kept, shifted=shifted).lattice.points
    return Spectrum(amplitude=force, points=points, mirrored=not shifted)


def _errors(ready: Response, block: Block, *, shifted: bool) -> ComplexArray:
    """Errors of the link rows at the points of the lattice, (p, S, J) [m, rad]; no speed changes them."""
    points = ready.kernel(block.kept, shifted=shifted).lattice.points.tolist()
    place = {tuple(point): i for i, point in enumerate(points)}
    count = len(ready.lines.shaft) if shifted else 1
    error = np.zeros((len(ready.system.links.name), count, len(points)), complex)
    if not shifted:
        for point, line in ready.lines.mesh:
            error[:, 0, place[point]] += line.link_gap
        error[:, 0, 0] = error[:, 0, 0].real
        return error
    for s, shaft in enumerate(ready.lines.shaft):
        for point, conjugate, line in shaft.members:
            # a . f - frequency stands at -a around +frequency once conjugated
            row = place[tuple(-order for order in point)] if conjugate else place[point]
            error[:, s, row] += line.link_gap.conj() if conjugate else line.link_gap
    return error


def lateral(system: System) -> Index:
    """Link rows x and y, or radial and tangential, of every link that has both, (k, 2)."""
    place = {name: i for i, name in enumerate(system.links.name)}
    ends = (("x", "y"), ("radial", "tangential"))
    links = dict.fromkeys(system.links.link)
    pairs = [
        (place[f"{link}/{first}"], place[f"{link}/{second}"])
        for link in links
        for first, second in ends
        if f"{link}/{first}" in place and f"{link}/{second}" in place
    ]
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)
