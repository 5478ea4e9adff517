"""`efficiency`: power lost in the meshes, efficiency of the train, sliding along the path of contact."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..elements import Company, Drawing, Finding, KeyFigure, Part, Section, Table
from ..series import by_pair_and_side, engineering, losses_of_pairs, numbers, texts
from ..tables import columns_of

if TYPE_CHECKING:
    import xarray as xr

ORDER = 75
_MEMBERS = {
    "torque": ("torque [N m]", 1.0),
    "lossless_torque": ("without losses [N m]", 1.0),
    "power": ("power [kW]", 1e-3),
    "lossless_power": ("without losses [kW]", 1e-3),
}
_LEAD = "Losses of the meshes alone: bearings, seals and oil take more."


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Efficiency and power of the train, loaded members, meshes by pair and side, stages."""
    found = [
        _train(result),
        Table(title="Torques and power with losses", columns=columns_of(result, "member", _MEMBERS)),
    ]
    return [*found, _meshes(result), *_stages(result)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The losses by pair, the tables, and sliding along the path of contact."""
    from ..charts.flanks import mesh_losses, sliding

    lost = np.isfinite(result["power_loss"].values)
    bars: list[Part] = []
    if lost:
        caption = "Share of the power into the train."
        bars.append(Drawing(anchor="losses", figure=mesh_losses(result), caption=caption))
    caption = (
        "Zero is the pitch point; the tip of the first gear ends the path on the right. The load is that on one pair "
        "of teeth; of helical teeth it is a mean over mesh cycle and face."
    )
    path = Drawing(anchor="sliding", figure=sliding(result), caption=caption)
    return [Section(anchor="efficiency", title="Efficiency", parts=[*bars, *tables(result), path])]


def key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """Efficiency of the meshes [%] and the power they lose [kW]."""
    efficiency = float(result["train_efficiency"])
    if not np.isfinite(efficiency) or efficiency <= 0:
        return [("self-locking", f"friction in the meshes, {_friction(result)}")]
    loss = engineering(float(result["power_loss"]) / 1e3)
    words = f"efficiency of the meshes, {_friction(result)}: {loss} kW lost, without bearings, seals and oil"
    return [(f"{100 * efficiency:.2f} %", words)]


def findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """Efficiency of the meshes and where most is lost; whether friction locks the train."""
    efficiency = float(result["train_efficiency"])
    if not np.isfinite(efficiency) or efficiency <= 0:
        return [
            Finding(tone="bad", text=f"The train locks itself by friction, {_friction(result)}.", anchor="efficiency")
        ]
    stage, pair, most = max(
        losses_of_pairs(texts(result, "mesh"), numbers(result, "mesh_power_loss")), key=lambda row: row[2]
    )
    total = float(result["power_loss"])
    where = f"{stage} {pair}" if result.sizes["stage"] > 1 else pair
    share = f", {100 * most / total:.0f} % of it in {where}" if total > 0 else ""
    text = f"The meshes lose {100 * (1 - efficiency):.2f} % of the power, {engineering(total / 1e3)} kW{share}."
    return [Finding(tone="", text=text, anchor="efficiency")]


def _train(result: xr.Dataset) -> Table:
    names = {"power_in": "power in [kW]", "power_loss": "lost in the meshes [kW]", "power_out": "power out [kW]"}
    columns: dict[str, Any] = {heading: [float(result[name]) / 1e3] for name, heading in names.items()}
    columns = {"efficiency [%]": [100 * float(result["train_efficiency"])], **columns}
    return Table(title=f"Efficiency of the meshes, {_friction(result)}", columns=columns, lead=_LEAD)


def _friction(result: xr.Dataset) -> str:
    """How friction was stated: ``coefficient of friction 0.05``, or the oil with the range of coefficients."""
    options = json.loads(str(result.attrs.get("options", "{}")))
    values = numbers(result, "friction_coefficient")
    if "viscosity" not in options:
        return f"coefficient of friction {engineering(float(values.max()))}"
    low, high = (engineering(float(value), 2) for value in (values.min(), values.max()))
    oil = f"oil of {engineering(1e3 * options['viscosity'])} mPa s, Ra {engineering(1e6 * options['roughness'])} µm"
    return f"{oil}, coefficients of friction {low} to {high}"


def _meshes(result: xr.Dataset) -> Table:
    """A row each pair and side: what its meshes have alike, and the sums of their power."""
    names = texts(result, "mesh")
    groups = by_pair_and_side(names)
    pairs = [str(name).split(".") for name in result["mesh_pair"].values]
    friction = dict(zip((f"{p[1]}/{p[-1]}" for p in pairs), numbers(result, "friction_coefficient"), strict=True))
    rolling, loss = numbers(result, "mesh_rolling_power"), numbers(result, "mesh_power_loss")
    factor, driver = numbers(result, "loss_factor"), texts(result, "driving_gear")
    several = len({p[1] for p in pairs}) > 1
    columns: dict[str, Any] = {
        "mesh": [
            f"{pair.replace('/', ' ') if several else pair.split('/')[1]} {side}".strip() for pair, side in groups
        ],
        "meshes": [len(meshes) for meshes in groups.values()],
        "driver": [driver[meshes[0]].split("/")[1] if driver[meshes[0]] else "" for meshes in groups.values()],
        "loss factor H_V": [float(factor[meshes[0]]) for meshes in groups.values()],
        "coefficient of friction": [float(friction[pair]) for pair, _ in groups],
        "rolling power [kW]": [float(rolling[meshes].sum()) / 1e3 for meshes in groups.values()],
        "lost [kW]": [float(loss[meshes].sum()) / 1e3 for meshes in groups.values()],
        "lost [% of power in]": [100 * float(loss[meshes].sum() / result["power_in"]) for meshes in groups.values()],
    }
    return Table(title="Meshes, all branches together (driver and power in the frame of the carrier)", columns=columns)


def _stages(result: xr.Dataset) -> list[Table]:
    """Losses by stage, of several."""
    if result.sizes["stage"] < 2:
        return []
    loss = numbers(result, "stage_power_loss")
    columns: dict[str, Any] = {
        "stage": texts(result, "stage"),
        "lost [kW]": [float(value) / 1e3 for value in loss],
        "lost [% of power in]": [100 * float(value / result["power_in"]) for value in loss],
    }
    return [Table(title="Stages", columns=columns)]
