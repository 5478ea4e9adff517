"""`load_factors`: the table of a gear rating, and load cycles and equivalent torques of the flanks."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...results.dataset import EQUAL, first_largest, largest
from ...show.elements import Company, Finding, KeyFigure, Table, number
from ...show.series import engineering, texts
from ...show.views import ResultView, in_section

_OF_MESH = {
    "k_gamma": ("K_gamma", 1.0),
    "dynamic_factor": ("K_v", 1.0),
    "face_load_factor": ("K_Hbeta", 1.0),
    "transverse_load_factor": ("K_Halpha", 1.0),
    "accuracy_load_factor": ("of deviations", 1.0),
    "load_factor_product": ("product", 1.0),
    "direct_load_factor": ("direct", 1.0),
    "branch_load": ("branch load", 1.0),
    "coincidence_factor": ("coincidence", 1.0),
    "largest_load_per_length": ("largest load [N/mm]", 1e-3),
    "largest_pressure": ("pressure [MPa]", 1e-6),
}
_DIRECT = (
    "Direct is K_v times the largest load per length of contact in the train per nominal one. It is the product times "
    "branch load / K_gamma, below 1 where another branch carries most, and times the coincidence: below 1 worst place "
    "along the face and worst phase of the pairs of teeth do not meet, above 1 the load is uneven along a line.",
    "K_Halpha counts from an equal share of as many pairs of teeth as the contact ratio has; a rating with Z_eps takes "
    "K_Halpha / (eps_alpha Z_eps^2), and of deviations is K_Halpha as ISO 6336-1 defines it.",
    "Loads, pressures and root stresses are those of contact, without K_v.",
)


def _pair_name(path: str) -> str:
    """``main/sun-planet`` of ``stages.main.meshes.sun-planet``."""
    _, stage, _, pair = path.split(".", 3)
    return f"{stage}/{pair}"


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Factors of the mesh with the largest product, by case and pair; cycles and equivalent torque of every flank."""
    return [_factors(result), _flanks(result)]


def _factors(result: xr.Dataset) -> Table:
    known = {name: row for name, row in _OF_MESH.items() if name in result}
    heads = ["case", "pair", "flank", "torque a [N m]", "torque b [N m]", "cycles a", "cycles b"]
    heads += [head for head, _ in known.values()]
    stressed = "largest_root_stress" in result
    heads += ["root a [MPa]", "root b [MPa]"] * stressed
    rows: list[list[Any]] = []
    mesh = np.array(texts(result, "mesh"))
    for case in texts(result, "case"):
        for pair in texts(result, "mesh_pair"):
            stage, gears = _pair_name(pair).split("/")
            at = result.sel(case=case, mesh_pair=pair).isel(
                mesh=[
                    i
                    for i, name in enumerate(mesh)
                    if name.startswith(f"{stage}/{gears}/") or name == f"{stage}/{gears}"
                ]
            )
            worst = at.isel(mesh=largest(_own_product(at).values, equal=EQUAL))
            row = [case, _pair_name(pair), float(at.flank), *at.pair_torque.values, *at.load_cycles.values]
            row += [scale * float(worst[name]) for name, (_, scale) in known.items()]
            rows.append([*row, *(1e-6 * at.largest_root_stress.values.max(axis=0) if stressed else ())])
    columns = {head: list(cells) for head, cells in zip(heads, zip(*rows, strict=True), strict=True)}
    # what K_Hbeta of every mesh is of, in the first case that has a result
    bases = (next(filter(None, map(str, column)), "") for column in result.face_load_basis.values.T)
    without = [name for name, basis in zip(mesh, bases, strict=True) if basis.startswith("not")]
    lead = "Of each pair the mesh with the largest load; torques of one mesh under equal share."
    if "direct_load_factor" not in result:
        lead += " K_Halpha is not known without contact, and counts as 1."
        lead += f" K_Hbeta is not known without slices, and counts as 1: {', '.join(without)}." if without else ""
    return Table(
        title="Load factors", columns=columns, lead=lead, notes=_DIRECT if "direct_load_factor" in result else ()
    )


def _own_product(result: xr.Dataset) -> xr.DataArray:
    """Product of the factors with the load of the mesh's own branch in place of K_gamma [1].

    K_v is about a mesh's own mean, and so is largest where a branch carries least.
    """
    own: xr.DataArray = result.load_factor_product * result.branch_load / result.k_gamma
    return own


def _flanks(result: xr.Dataset) -> Table:
    columns: dict[str, list[Any]] = {"pair": [], "flank": []}
    gears = ("a", "b")
    columns |= {f"{what} {gear}{unit}": [] for what, unit in (("cycles", ""), ("torque", " [N m]")) for gear in gears}
    for pair in texts(result, "mesh_pair"):
        for flank in result.loaded_flank.values:
            at = result.sel(mesh_pair=pair, loaded_flank=flank)
            values = (*at.flank_cycles.values, *at.flank_equivalent_torque.values)
            for cells, value in zip(columns.values(), (_pair_name(pair), int(flank), *values), strict=True):
                cells.append(value)
    exponent = json.loads(result.attrs["options"])["exponent"]
    lead = f"Of all cases that load the flank, equivalent by Miner's rule with the exponent {number(exponent)}."
    if np.isnan(result.flank_cycles).all():
        lead += " Cycles are not known: state durations in the cases, or --life for shares of it."
    return Table(title="Load cycles and equivalent torque of every flank", columns=columns, lead=lead)


def key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """Largest product of the factors, with the load of the mesh's own branch [1]."""
    return [(engineering(float(_own_product(result).max())), "largest product of load factors")]


def findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """The largest product, with the load of the mesh's own branch, and where it is."""
    product = _own_product(result).transpose("case", "mesh")
    if not np.isfinite(product).any():
        return []
    worst = product.isel(dict(zip(product.dims, first_largest(product.values), strict=True)))
    where = f"{worst.mesh.item()} in case {worst.case.item()}"
    text = f"The product K_gamma K_v K_Hbeta K_Halpha is largest at {where}: {engineering(float(worst))}."
    return [Finding(tone="", text=text, anchor="load-factors")]


_SECTIONS = in_section("load-factors", "Load factors for a rating", tables)
VIEWS = (ResultView("load_factors", 36, tables, _SECTIONS, key_figures=key_figures, findings=findings),)
