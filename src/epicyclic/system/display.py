"""A System as a notebook shows it: which bodies its meshes and links couple, and its key numbers."""

from __future__ import annotations

from collections import Counter
from html import escape
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .elimination import NEGLIGIBLE

if TYPE_CHECKING:
    from .system import System

_CELL, _LABEL = 13, 10  # side of a cell of the pattern and size of its letters [px]
_MESH, _LINK, _BODY = "#e07b39", "#6ea8d8", "#c8c8c8"  # colours of couplings and of a body with itself


def system_html(system: System) -> str:
    """Coupling pattern and key numbers of a system as one well-formed HTML element, without outside references."""
    rows = "".join(f"<tr><td>{escape(name)}</td><td>{escape(text)}</td></tr>" for name, text in _facts(system))
    title = escape(str(system.provenance.get("title", "")))
    return f"<div><p><b>{title}</b></p>{_pattern(system)}<table>{rows}</table></div>"


def damping_text(system: System) -> str:
    """What damping is given: the ratio of the modes, dampers of connections, or none."""
    dampers = bool(np.any(system.C)) or bool(np.any(system.meshes.damping))
    named = ([] if system.zeta is None else [f"modal {system.zeta:.4g}"]) + ["dampers"] * dampers
    return ", ".join(named) or "none"


def _facts(system: System) -> list[tuple[str, str]]:
    meshes, slices = system.meshes, sum(number > 0 for number in system.meshes.slice)
    laws = Counter(group.law.kind for group in system.groups)
    facts = [
        ("degrees of freedom", f"{len(system.dofs.names)} of {len(set(system.dofs.body))} bodies"),
        ("mesh rows", f"{len(meshes.name)}" + (f", {slices} of them slices" if slices else "")),
        ("mean mesh stiffness [N/m]", _range(meshes.stiffness)),
        ("far flanks", str(len(system.far.mesh)) if system.far is not None else "none"),
        ("meshes with a law", f"{sum(len(block.rows) for block in meshes.laws)} rows" if meshes.laws else ""),
        ("linear link rows", str(len(system.links.name))),
        ("links with a law", ", ".join(f"{count} {kind}" for kind, count in laws.items()) or "none"),
        ("mesh frequencies [Hz]", ", ".join(f"{float(tone):.5g}" for tone in system.tones) or "no speed given"),
        ("excitation lines", str(len(system.lines))),
        ("damping", damping_text(system)),
        ("cyclic stages", ", ".join(f"{s.stage} ({s.branches})" for s in system.symmetries if s.holds) or "none"),
        ("missing inertia", ", ".join(system.missing_inertia)),
    ]
    return [(name, text) for name, text in facts if text]


def _range(values: NDArray[np.float64]) -> str:
    known = values[np.isfinite(values)]
    if not known.size:
        return ""
    low, high = float(known.min()), float(known.max())
    return f"{low:.4g}" if high - low <= 1e-9 * abs(high) else f"{low:.4g} .. {high:.4g}"


def _pattern(system: System) -> str:
    """Bodies against bodies as SVG: coupled by a mesh below and by links above the diagonal, both in one cell."""
    names = list(dict.fromkeys(system.dofs.body))
    owner = np.array([names.index(body) for body in system.dofs.body])
    groups = [system.links.B, *(group.B for group in system.groups)]
    meshes, links = _coupled(system.meshes.B, owner), _coupled(np.concatenate(groups, axis=1), owner)
    left = 0.62 * _LABEL * max((len(name) for name in names), default=0) + 6
    cells = [_cell(left, i, i, _BODY, name) for i, name in enumerate(names)]
    for i, j in sorted(links):
        cells.append(_cell(left, i, j, _LINK, f"{names[i]}, {names[j]}: link"))
        if (i, j) not in meshes:
            cells.append(_cell(left, j, i, _LINK, f"{names[i]}, {names[j]}: link"))
    for i, j in sorted(meshes):
        if (i, j) not in links:
            cells.append(_cell(left, i, j, _MESH, f"{names[i]}, {names[j]}: mesh"))
        cells.append(_cell(left, j, i, _MESH, f"{names[i]}, {names[j]}: mesh"))
    labels = "".join(
        f'<text x="{left - 4:.1f}" y="{_CELL * i + _LABEL:.1f}">{escape(name)}</text>' for i, name in enumerate(names)
    )
    size, foot = _CELL * len(names), _CELL * len(names) + _LABEL + 6
    legend = (
        f'<rect x="{left:.1f}" y="{foot - 9}" width="9" height="9" fill="{_MESH}"/>'
        f'<rect x="{left + 60:.1f}" y="{foot - 9}" width="9" height="9" fill="{_LINK}"/>'
        f'<g text-anchor="start"><text x="{left + 13:.1f}" y="{foot}">mesh</text>'
        f'<text x="{left + 73:.1f}" y="{foot}">link</text></g>'
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{max(left + size, left + 110):.0f}" height="{foot + 6}" '
        f'font-family="sans-serif" font-size="{_LABEL}" text-anchor="end" fill="currentColor">'
        f"{labels}{''.join(cells)}{legend}</svg>"
    )


def _coupled(B: NDArray[np.float64], owner: NDArray[np.int64]) -> set[tuple[int, int]]:
    """Pairs i < j of bodies that some row, a column of B (n, R), couples; owner : (n,) body of each coordinate."""
    pairs: set[tuple[int, int]] = set()
    for column in np.abs(B).T:
        touched = sorted(set(owner[column > NEGLIGIBLE * column.max(initial=0.0)].tolist()))
        pairs |= {(i, j) for k, i in enumerate(touched) for j in touched[k + 1 :]}
    return pairs


def _cell(left: float, row: int, column: int, colour: str, text: str) -> str:
    return (
        f'<rect x="{left + _CELL * column:.1f}" y="{_CELL * row}" width="{_CELL - 1}" height="{_CELL - 1}" '
        f'fill="{colour}"><title>{escape(text)}</title></rect>'
    )
