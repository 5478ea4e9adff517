"""`modes`: natural frequencies, kinds, shapes and energies of the vibration modes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..elements import Company, Details, Drawing, KeyFigure, Part, Section, Table
from ..figures.series import engineering, numbers, texts
from ..figures.summaries import mode_groups, summed_shares

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ORDER", "key_figures", "sections", "tables"]

ORDER = 30


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Every mode: frequency, kind, multiplicity, damping, and what holds most of its energies, branches added up."""
    columns: dict[str, Any] = {
        "mode": list(range(1, result.sizes["mode"] + 1)),
        "frequency [Hz]": list(numbers(result, "frequency")),
        "kind": texts(result, "mode_kind", "mode"),
        "multiplicity": [int(count) for count in np.nan_to_num(numbers(result, "multiplicity", "mode"), nan=1.0)],
        "damping [-]": list(numbers(result, "damping_ratio", "mode")),
        "most strain energy": _most(result, "strain_energy_share", "connection"),
        "most kinetic energy": _most(result, "kinetic_energy_share", "body"),
    }
    return [Table(title="Modes", columns=columns)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Frequencies, moving shapes, energies, the Campbell diagram where there is one, and all modes as a table."""
    from ..figures.campbell import campbell
    from ..figures.energy_shares import energy_shares
    from ..figures.frequencies import frequencies
    from ..figures.mode_shapes import mode_shapes

    check = company.get("check")
    words = "×2, ×3: so many modes at one frequency."
    parts: list[Part] = [Drawing(anchor="frequencies", figure=frequencies(result, check), caption=words)]
    if check is not None and "full_shape" in result.variables:
        words = "Move the slider to a mode and it swings; grey is the place at rest."
        parts.append(Drawing(anchor="shapes", figure=mode_shapes(check, result), caption=words))
    if "strain_energy_share" in result.variables and "kinetic_energy_share" in result.variables:
        words = "Branches and sides added up."
        parts.append(Drawing(anchor="energy", figure=energy_shares(result), caption=words))
    if "campbell" in company:
        parts.append(Drawing(anchor="campbell", figure=campbell(company["campbell"])))
    parts.append(Details(summary="All modes", parts=tables(result)))
    return [Section(anchor="modes", title="Vibration modes", parts=parts)]


def key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """The lowest natural frequency [Hz], and how many there are."""
    elastic = [one for one in mode_groups(result) if one.frequency > 1e-3]
    if not elastic:
        return []
    first, last = elastic[0], elastic[-1]
    count = sum(one.multiplicity for one in elastic)
    return [
        (f"{engineering(first.frequency)} Hz", f"lowest natural frequency, {first.kind}"),
        (str(count), f"natural frequencies above zero, the highest {engineering(last.frequency)} Hz"),
    ]


def _most(result: xr.Dataset, name: str, dim: str) -> list[str]:
    """What holds the largest share of an energy in each mode, and how much."""
    if name not in result.variables:
        return [""] * result.sizes["mode"]
    names, shares = summed_shares(texts(result, dim), result[name].transpose(dim, "mode").values)
    found = []
    for column in shares.T:
        known = bool(np.isfinite(column).all() and column.any())
        most = int(np.argmax(column)) if known else 0
        found.append(f"{names[most]} {100 * column[most]:.0f} %" if known else "")
    return found
