"""`sharing`: load-sharing coefficients by their definitions, and the mesh forces that they come from."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...limits import KGammaVerdict, k_gamma_verdict
from ...results.dataset import largest
from ...show.elements import (
    Company,
    Drawing,
    Finding,
    KeyFigure,
    Part,
    Section,
    Table,
    error_tables,
    force_table,
    named_columns,
)
from ...show.series import engineering, largest_coefficients, readable, short_names, stage_count, texts, unbroken
from ...show.views import ResultView

_EQUAL = 5e-4  # half of the last digit shown of a coefficient
_UNDEFINED = "undefined"  # a share of forces that sum to nothing or less


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Coefficients [1] of every mesh by every definition, the train's in the last row; mesh forces [N]."""
    coefficients = _coefficients(result, texts(result, "mesh"), texts(result, "definition"), "Load sharing")
    return [coefficients, _forces(result), *error_tables(result)]


def _forces(result: xr.Dataset) -> Table:
    """Mean, least and most of every mesh force over the whole record [N], where the result has them."""
    # least and most of the record stand in its own columns
    table = force_table(result.drop_vars("mesh_force_minimum", errors="ignore"))
    over = {"mesh_force_mean": "mean [N]", "mesh_force_minimum": "least [N]", "mesh_force_peak": "most [N]"}
    if not all(name in result for name in over):
        return replace(table, title=f"{table.title}{_part(result)}")
    columns = {**table.columns, **{heading: list(result[name].values) for name, heading in over.items()}}
    return replace(table, title=f"{table.title}, over the whole record", columns=columns)


def _part(result: xr.Dataset) -> str:
    """Which part of the record the forces over time are, empty where they are all of it."""
    units = {"mesh cycles" if name == "cycles" else name: value for name, value in result.attrs.items()}
    unit = next((name for name in units if name == "mesh cycles" or name.startswith("turns")), "")
    count, kept = int(units.get(unit, 0)), result.sizes["time"] // max(int(result.attrs.get("samples", 1)), 1)
    return f", the first {kept} of {count} {unit}" if kept < count else ""


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Coefficients as bars and as a table, the ratio of each branch and the mesh forces over time."""
    from ...show.charts.over_time import mesh_forces
    from ...show.charts.sharing import load_history, load_sharing

    parts: list[Part] = []
    if "load_sharing" in result.variables:
        words = (
            "1: every branch carries the same. Cycle peak and worst case count the size of a deviation: a mesh that "
            "carries too little has a coefficient above 1 too."
        )
        parts.append(Drawing(anchor="sharing", figure=load_sharing(result), caption=words))
        definitions = [readable(name) for name in texts(result, "definition")]
        title = "Load-sharing coefficients by definition"
        parts.append(_coefficients(result, short_names(texts(result, "mesh")), definitions, title))
    if "load_sharing_history" in result.variables:
        parts.append(Drawing(anchor="history", figure=load_history(result), caption=_caption(result)))
    if "mesh_force" in result.variables:
        parts.append(Drawing(anchor="forces", figure=mesh_forces(result), caption=_caption(result)))
        parts.append(_forces(result))
    return [Section(anchor="sharing", title="Load sharing", parts=parts)]


def _caption(result: xr.Dataset) -> str:
    """What part of the record a figure over time shows."""
    part = _part(result).removeprefix(", the ")
    return f"{part.capitalize()} of the record." if part else ""


def key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """The largest coefficient [1], by the first definition and by all; the bound of a mesh force [kN]; contact loss."""
    found: list[KeyFigure] = []
    stages = stage_count(texts(result, "mesh"))
    if "load_sharing" in result.variables:
        rows = largest_coefficients(result)
        shown = dict.fromkeys([*rows[:1], *sorted(rows, key=lambda row: -row[1])[:1]])
        for name, value, mesh in shown:
            words = f"load sharing, {name}: {unbroken(mesh, stages=stages)}"
            found.append((_UNDEFINED if np.isinf(value) else f"{value:.3f}", words))
    if "mesh_force_bound" in result.variables and np.isfinite(result.mesh_force_bound.values).any():
        at = largest(result.mesh_force_bound.values)
        mesh = unbroken(str(result.mesh.values[at]), stages=stages)
        words = f"largest mesh force at the operating point, any shaft phases: {mesh}"
        found.append((f"{engineering(float(result.mesh_force_bound.values[at]) / 1e3)} kN", words))
    if "contact_lost" in result.variables:
        loaded = _loaded(result)
        lost = int(np.sum(result.contact_lost.values[loaded] > 0))
        idle = "" if loaded.all() else f", {np.count_nonzero(~loaded)} without load left out"
        words = f"meshes whose teeth part at the operating point{idle}"
        found.append((f"{lost or 'none'} of {np.count_nonzero(loaded)}", words))
    return found


def findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """Whether teeth part at the operating point; which mesh carries most."""
    found: list[Finding] = []
    stages = stage_count(texts(result, "mesh"))
    if "contact_lost" in result.variables:
        loaded = _loaded(result)
        open_ = result.contact_lost.values.astype(bool) & loaded
        lost = [name for name, one in zip(texts(result, "mesh"), open_, strict=True) if one]
        count = np.count_nonzero(loaded)
        which = f"{count} meshes" if loaded.all() else f"{count} meshes that carry a load"
        if lost:
            # differential sun-planet
            own = (name.split("/")[:2] if stages > 1 else name.split("/")[1:2] for name in lost)
            pairs = ", ".join(dict.fromkeys(map(" ".join, own)))
            text = f"Teeth part at the operating point in {len(lost)} of {which}: {pairs}."
            found.append(Finding(tone="bad", text=text, change=_CHANGE, anchor="sharing"))
        else:
            text = f"Teeth stay in contact in all {which} at the operating point."
            found.append(Finding(tone="good", text=text, anchor="sharing"))
    if "mean-load" in texts(result, "definition"):
        found += _k_gamma(result, company)
    return found


def _verdict(result: xr.Dataset) -> tuple[KGammaVerdict | None, float]:
    """K_gamma beside its limit, if any, and the largest coefficient while turning [1]; nan where it is not known."""
    # of definitions that a result is without nothing is known
    unknown = np.full(result.sizes["mesh"], np.nan)
    known = dict(
        zip(texts(result, "definition"), result.load_sharing.transpose("definition", "mesh").values, strict=True)
    )
    mean, turning = (known.get(name, unknown) for name in ("mean-load", "mean-load-turning"))
    most = turning[np.isfinite(turning)].max(initial=-np.inf)
    return k_gamma_verdict(result, "mesh", mean.tolist()), most if np.isfinite(most) else np.nan


_CHANGE = "Linear forces do not hold there: relieve the resonance, or follow the motion with teeth that part."


def _k_gamma(result: xr.Dataset, company: Company) -> list[Finding]:
    """The mesh-load factor as drawn, against its limit where no tolerances tell what it is of nearly all trains."""
    verdict, most = _verdict(result)
    if verdict is None:
        return []
    turns = f", {most:.3f} while turning" if np.isfinite(most) else ""
    limit = f"; {verdict.text}" if "tolerance" not in company else ""
    if not verdict.value > 1 + _EQUAL:
        text = f"Every branch carries the same mean load, K_gamma 1.000 as drawn{turns}{limit}."
        change = "The drawing states no error that tells branches apart: tolerances decide."
        return [Finding(tone="", text=text, change=change, anchor="sharing")]
    mesh = unbroken(verdict.name, stages=stage_count(texts(result, "mesh")))
    text = (
        f"K_gamma {verdict.value:.3f} as drawn{turns}{limit}. "
        f"{mesh} carries {100 * (verdict.value - 1):.1f} % more than its share in the mean."
    )
    if not limit:
        return [Finding(tone="", text=text, anchor="sharing")]
    drawing = json.loads(str(result.attrs.get("model", "{}")))
    change = "That of toleranced trains is told by epicyclic tolerance." if drawing.get("tolerance") else ""
    judged = {"value": verdict.value, "limit": verdict.limit}
    return [Finding(tone=verdict.tone, text=text, change=change, anchor="sharing", **judged)]


def over_cases(whole: xr.Dataset, cases: Mapping[str, xr.Dataset]) -> list[Table]:
    """K_gamma of every case, in the mean and while turning, beside the limit that is nearest, and its mesh."""
    rows = []
    for name, result in cases.items():
        verdict, most = _verdict(result)
        if verdict is not None:
            rows.append((name, verdict.value, most, verdict.limit, verdict.name))
    columns = named_columns(("case", "K_gamma", "while turning", "limit", "mesh"), rows)
    return [Table(title="K_gamma over the load cases", columns=columns, decimals=4)] if rows else []


def _loaded(result: xr.Dataset) -> NDArray[np.bool_]:
    """Meshes (m,) that carry a load in the mean; the teeth of others rattle, which is no loss of contact."""
    if "load_sharing" not in result.variables:
        return np.ones(result.sizes["mesh"], bool)
    loaded: NDArray[np.bool_] = np.isfinite(result.load_sharing.transpose("mesh", ...).values).any(axis=1)
    return loaded


def _coefficients(result: xr.Dataset, meshes: Sequence[str], definitions: Sequence[str], title: str) -> Table:
    values = result.load_sharing.transpose("definition", "mesh").values
    whole = result.system_load_sharing.values
    columns: dict[str, Any] = {"mesh": [*meshes, "whole train"]}
    for name, row, one in zip(definitions, values, whole, strict=True):
        columns[name] = [_UNDEFINED if np.isinf(value) else value for value in (*row, one)]
    if "contact_lost" in result.variables:
        state = zip(result.contact_lost.values, _loaded(result), strict=True)
        columns["contact"] = [*(("lost" if lost else "") if loaded else "no load" for lost, loaded in state), ""]
    return Table(title=title, columns=columns, decimals=4)


VIEWS = (
    ResultView("sharing", 70, tables, sections, key_figures=key_figures, findings=findings, over_cases=over_cases),
)
