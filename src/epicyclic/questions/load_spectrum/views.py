"""`spectrum`: load cases of a history, turns of the members, cycles of the torque."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...results.dataset import largest, ranked
from ...show.elements import Company, Drawing, Finding, Part, Section, Table, number
from ...show.series import engineering, texts
from ...show.views import ResultView

_SHOWN = 40


def tables(result: xr.Dataset) -> Sequence[Table]:
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


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Hours over torque and speed, and ranges of the torque over the cycles that have them."""
    from ...show.charts.train import hours_over_torque, ranges_over_cycles

    parts: list[Part] = [Drawing(anchor="load-spectrum", figure=hours_over_torque(result))]
    if result.sizes.get("cycle"):
        words = "So many cycles have this range or a larger one."
        parts.append(Drawing(anchor="rainflow", figure=ranges_over_cycles(result), caption=words))
    return [Section(anchor="spectrum", title="Load spectrum", parts=[*parts, *tables(result)])]


def findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
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


VIEWS = (ResultView("spectrum", 5, tables, sections, findings=findings),)
