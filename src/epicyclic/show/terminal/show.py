"""Results for people in a terminal: tables with units, warnings first.

Depends on: results (as Datasets only).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from .contact import contact_tables
from .contact_loss import contact_loss_tables
from .forces import any_tables, sharing_tables, static_tables, steady_tables, sweep_tables
from .model import campbell_tables, check_tables, modes_tables, stiffness_tables
from .modulation import modulation_tables
from .relief import relief_tables
from .sensitivity import sensitivity_tables, track_tables
from .stability import stability_tables
from .tables import listed, number
from .train_contact import train_contact_tables
from .transient import transient_tables

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["key_figures", "show", "show_pairs", "stdout_console", "warnings_of"]


def stdout_console() -> Console:
    """The console for results: as wide as the terminal, or 160 columns in a pipe."""
    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=160)


def show(result: xr.Dataset, console: Console) -> None:
    """Print a result of any verb: title, warnings, then its tables."""
    title = result.attrs.get("title", "")
    console.print(
        f"[bold]{escape(title)}[/bold]" + (f"  doi {escape(result.attrs['doi'])}" if result.attrs.get("doi") else "")
    )
    for warning in warnings_of(result):
        console.print(f"[yellow]warning:[/yellow] {escape(warning)}", soft_wrap=True)
    for table in _TABLES.get(str(result.attrs.get("verb")), any_tables)(result):
        console.print()
        console.print(table)


def warnings_of(result: xr.Dataset) -> list[str]:
    """The physical warnings of a result."""
    return [str(text) for text in json.loads(result.attrs.get("warnings", "[]"))]


def show_pairs(pairs: Mapping[str, str], console: Console) -> None:
    """Print names and what they are, one a line."""
    width = max(map(len, pairs), default=0)
    for name, text in pairs.items():
        console.print(f"[bold]{escape(name):{width}}[/bold]  {escape(text)}", soft_wrap=True)


def key_figures(results: Mapping[str, xr.Dataset]) -> dict[str, str]:
    """The figures of a report that are read first, by name, with units.

    Parameters
    ----------
    results : verb -> Dataset, as `run_report` returns them.
    """
    figures: dict[str, str] = {}
    if "check" in results:
        figures |= _check_figures(results["check"])
    if "modes" in results:
        frequency = results["modes"].frequency.values
        elastic = frequency[frequency > 0]
        figures["natural frequencies"] = f"{len(frequency)}, {listed(elastic[:6])} ... {number(elastic.max())} Hz"
    if "sharing" in results:
        sharing = results["sharing"]
        for definition, value in zip(sharing.definition.values, sharing.system_load_sharing.values, strict=True):
            figures[f"load sharing, {definition}"] = number(value)
        figures["mesh force, bound over all shaft phases"] = f"{number(float(sharing.mesh_force_bound.max()))} N"
        lost = sharing.mesh.values[sharing.contact_lost.values.astype(bool)]
        figures["contact lost in"] = ", ".join(map(str, lost)) or "no mesh"
    if "sweep" in results:
        sweep = results["sweep"]
        peak = sweep.mesh_force_rms.max("mesh").values
        if np.isfinite(peak).any():
            at = int(np.nanargmax(peak))
            frequency = float(sweep.mesh_frequency.values.ravel()[at])
            figures["largest dynamic mesh force (rms, linear)"] = f"{number(peak[at])} N at {number(frequency)} Hz"
    return figures


def _check_figures(check: xr.Dataset) -> dict[str, str]:
    figures: dict[str, str] = {}
    for stage, tone in zip(check.stage.values, check.mesh_frequency.values, strict=True):
        if np.isfinite(tone):
            figures[f"mesh frequency, {stage}"] = f"{number(tone)} Hz"
    speeds = dict.fromkeys(
        f"{member} {number(speed)} rpm ({number(speed * np.pi / 30)} rad/s)"
        for member, speed in zip(check.member.values, check.speed.values, strict=True)
        if np.isfinite(speed)
    )
    if speeds:
        figures["speeds"] = ", ".join(speeds)
    return figures


_TABLES: dict[str, Callable[[xr.Dataset], Sequence[Table]]] = {
    "check": check_tables,
    "modes": modes_tables,
    "campbell": campbell_tables,
    "stiffness": stiffness_tables,
    "contact": contact_tables,
    "relief": relief_tables,
    "train_contact": train_contact_tables,
    "static": static_tables,
    "steady": steady_tables,
    "sharing": sharing_tables,
    "sweep": sweep_tables,
    "sensitivity": sensitivity_tables,
    "track": track_tables,
    "contact_sweep": contact_loss_tables,
    "modulation": modulation_tables,
    "stability": stability_tables,
    "transient": transient_tables,
}
