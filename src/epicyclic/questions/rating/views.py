"""Views of `life`, lives of bearings and what they follow from, over load cases; of `load_factors`, the table of a gear
rating, load cycles and equivalent torques of the flanks; of `spectrum`, load cases of a history, turns of the members,
cycles of the torque.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...results.dataset import EQUAL, first_largest, largest, ranked
from ...show.elements import Company, Drawing, Finding, KeyFigure, Part, Section, Table, number
from ...show.part_tables import bearing_tables
from ...show.series import engineering, numbers, texts
from ...show.views import ResultView, in_section

_HOUR = 3600.0
_LIVES = {
    "basic": "L10 by ISO 281 [h]",
    "reference": "L10r by load zones [h]",
    "modified": "L10mr with the oil [h]",
}


def life_tables(result: xr.Dataset) -> Sequence[Table]:
    """Lives [h] over all cases; loads of each case; frequencies of defects [Hz]."""
    bearings = texts(result, "bearing")
    columns: dict[str, Any] = {"bearing": bearings}
    for name, heading in _LIVES.items():
        columns[heading] = list(numbers(result, f"bearing_duty_life_{name}", "bearing") / _HOUR)
    if len(texts(result, "case")) > 1:
        columns["most damage in"] = [_most(result, place) for place in range(len(bearings))]
    columns["C [kN]"] = list(numbers(result, "bearing_rating", "bearing") / 1e3)
    columns["C_0 [kN]"] = list(numbers(result, "bearing_static_rating", "bearing") / 1e3)
    lead = (
        "Lives that 90 % of such bearings reach. Moments count with two rows, thrust with a contact angle or on balls."
    )
    lives = Table(title="Life of rolling bearings", columns=columns, lead=lead, digits=4)
    return [lives, *_changes(result), *bearing_tables(result)]


def _changes(result: xr.Dataset) -> list[Table]:
    """What every change that was tried makes of the shortest life [h]."""
    if "change_life" not in result:
        return []
    hours = numbers(result, "change_life", "change") / _HOUR
    columns: dict[str, Any] = {
        "change": texts(result, "change"),
        "shortest L10r [h]": list(hours),
        "times": list(hours / _shortest(result)[2]),
        "fails": texts(result, "change_reason", "change"),
    }
    return [Table(title="Changes, one at a time", columns=columns, digits=4)]


def _most(result: xr.Dataset, place: int) -> str:
    """Case that takes most of the life of a bearing, with its share of the damage."""
    share = result["damage_share"].transpose("bearing", "case").values[place]
    at = largest(share)
    return f"{texts(result, 'case')[at]} {100 * share[at]:.3g} %" if share[at] > 0 else ""


def _shortest(result: xr.Dataset) -> tuple[str, int, float]:
    """Bearing that lives shortest, its number, and its reference life [h]."""
    lives = numbers(result, "bearing_duty_life_reference", "bearing") / _HOUR
    place = largest(-lives)
    return texts(result, "bearing")[place], place, float(lives[place])


def life_key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """Life of the bearing that lives shortest [h]."""
    name, _, hours = _shortest(result)
    return [(f"{engineering(hours)} h", f"life L10r of {name}, the shortest")] if np.isfinite(hours) else []


def life_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """Which bearing lives shortest, which case takes most of it, and which change that was tried helps most."""
    name, place, hours = _shortest(result)
    if not np.isfinite(hours):
        return []
    text = f"{name} lives shortest of the bearings: L10r {engineering(hours)} h"
    if len(texts(result, "case")) > 1:
        text += f", most of its damage in {_most(result, place)}"
    change = ""
    if "change_life" in result and np.isfinite(lives := numbers(result, "change_life", "change")).any():
        most = largest(np.nan_to_num(lives))
        change = f"{texts(result, 'change')[most]} makes it {engineering(lives[most] / _HOUR / hours)} times as long."
    return [Finding(tone="", text=f"{text}.", change=change, anchor="life")]


def life_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Load zones, and the tables."""
    from ...show.charts.train import load_zones

    parts: list[Part] = [Drawing(anchor="load-zones", figure=load_zones(result)), *life_tables(result)]
    return [Section(anchor="life", title="Life of bearings", parts=parts)]


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


def factor_tables(result: xr.Dataset) -> Sequence[Table]:
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


def factor_key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """Largest product of the factors, with the load of the mesh's own branch [1]."""
    return [(engineering(float(_own_product(result).max())), "largest product of load factors")]


def factor_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """The largest product, with the load of the mesh's own branch, and where it is."""
    product = _own_product(result).transpose("case", "mesh")
    if not np.isfinite(product).any():
        return []
    worst = product.isel(dict(zip(product.dims, first_largest(product.values), strict=True)))
    where = f"{worst.mesh.item()} in case {worst.case.item()}"
    text = f"The product K_gamma K_v K_Hbeta K_Halpha is largest at {where}: {engineering(float(worst))}."
    return [Finding(tone="", text=text, anchor="load-factors")]


_SECTIONS = in_section("load-factors", "Load factors for a rating", factor_tables)


_SHOWN = 40


def spectrum_tables(result: xr.Dataset) -> Sequence[Table]:
    """Load cases, of many the most damaging ones, and turns of the members."""
    shown = result.isel(case=np.sort(ranked(result.case_damage.values)[:_SHOWN]))
    cases: dict[str, Any] = {
        "case": texts(shown, "case"),
        "torque bin [kN m]": [f"{number(a / 1e3)} to {number(b / 1e3)}" for a, b in _ends(shown, "torque")],
        "speed bin [rpm]": [f"{number(a)} to {number(b)}" for a, b in _ends(shown, "speed")],
        "equivalent torque [kN m]": list(shown.case_torque.values / 1e3),
        "mean speed [rpm]": list(shown.case_speed.values),
        "hours [h]": list(shown.case_hours.values),
        "time [%]": list(100 * shown.case_share.values),
        "revolutions": list(shown.case_revolutions.values),
        "damage [%]": list(100 * shown.case_damage.values),
    }
    columns = ("speed_ratio", "revolutions", "frame_revolutions", "hours")
    headings = ("speed per that of the history", "revolutions", "relative to its carrier", "hours [h]")
    turns = {head: list(result[f"member_{one}"].values) for head, one in zip(headings, columns, strict=True)}
    few = f", the {_SHOWN} most damaging" if result.sizes["case"] > _SHOWN else ""
    title = f"{result.sizes['case']} load cases of {number(float(result.case_hours.sum()))} h{few}"
    words = f"Together they do the damage of {engineering(float(result.equivalent_torque) / 1e3)} kN m."
    if result.sizes.get("cycle"):
        swing = engineering(float(result.equivalent_range) / 1e3)
        words += f" The torque swings as {number(float(result.cycle_count.sum()))} cycles with a range of {swing} kN m."
    members = {"member": texts(result, "member"), **turns}
    return [Table(title=title, columns=cases, lead=words), Table(title="Turns of the members", columns=members)]


def spectrum_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Hours over torque and speed, and ranges of the torque over the cycles that have them."""
    from ...show.charts.train import hours_over_torque, ranges_over_cycles

    parts: list[Part] = [Drawing(anchor="load-spectrum", figure=hours_over_torque(result))]
    if result.sizes.get("cycle"):
        words = "So many cycles have this range or a larger one."
        parts.append(Drawing(anchor="rainflow", figure=ranges_over_cycles(result), caption=words))
    return [Section(anchor="spectrum", title="Load spectrum", parts=[*parts, *spectrum_tables(result)])]


def spectrum_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """Where most of the hours are, and which bin does most damage."""
    top = np.abs(_ends(result, "torque")).max(axis=1)
    level = float(top[top >= top.max() / 2].min())
    below = float(result.case_share.values[top <= level].sum())
    worst = result.isel(case=largest(result.case_damage.values))
    (low, high), (slow, fast) = _ends(worst, "torque") / 1e3, _ends(worst, "speed")
    text = (
        f"{below:.0%} of the hours below {engineering(level / 1e3)} kN m; most damaging is {worst.case.item()}, "
        f"{number(low)} to {number(high)} kN m at {number(slow)} to {number(fast)} rpm: "
        f"{float(worst.case_damage):.0%} of the damage in {float(worst.case_share):.1%} of the hours."
    )
    return [Finding(tone="", text=text.replace("%", " %"), anchor="spectrum")]


def _ends(result: xr.Dataset, name: str) -> Any:
    """Edges of the bin of every case, (case, 2) [N m or rpm], of one case (2,)."""
    edges, at = result[f"{name}_edge"].values, result[f"{name}_bin"].values
    return np.stack([edges[at], edges[at + 1]], axis=-1)


VIEWS = (
    ResultView("life", 78, life_tables, life_sections, key_figures=life_key_figures, findings=life_findings),
    ResultView("load_factors", 36, factor_tables, _SECTIONS, key_figures=factor_key_figures, findings=factor_findings),
    ResultView("spectrum", 5, spectrum_tables, spectrum_sections, findings=spectrum_findings),
)
