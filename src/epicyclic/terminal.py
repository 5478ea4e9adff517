"""Results for people in a terminal: tables with units, warnings first.

Depends on: results (as Datasets only).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

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
    for table in _TABLES.get(str(result.attrs.get("verb")), _any)(result):
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
        figures["natural frequencies"] = f"{len(frequency)}, {_list(elastic[:6])} ... {_number(elastic.max())} Hz"
    if "sharing" in results:
        sharing = results["sharing"]
        for definition, value in zip(sharing.definition.values, sharing.system_load_sharing.values, strict=True):
            figures[f"load sharing, {definition}"] = _number(value)
        figures["mesh force, bound over all shaft phases"] = f"{_number(float(sharing.mesh_force_bound.max()))} N"
        lost = sharing.mesh.values[sharing.contact_lost.values.astype(bool)]
        figures["contact lost in"] = ", ".join(map(str, lost)) or "no mesh"
    if "sweep" in results:
        sweep = results["sweep"]
        peak = sweep.mesh_force_rms.max("mesh").values
        if np.isfinite(peak).any():
            at = int(np.nanargmax(peak))
            frequency = float(sweep.mesh_frequency.values.ravel()[at])
            figures["largest dynamic mesh force (rms, linear)"] = f"{_number(peak[at])} N at {_number(frequency)} Hz"
    return figures


def _check_figures(check: xr.Dataset) -> dict[str, str]:
    figures: dict[str, str] = {}
    for stage, tone in zip(check.stage.values, check.mesh_frequency.values, strict=True):
        if np.isfinite(tone):
            figures[f"mesh frequency, {stage}"] = f"{_number(tone)} Hz"
    speeds = dict.fromkeys(
        f"{member} {_number(speed)} rpm ({_number(speed * np.pi / 30)} rad/s)"
        for member, speed in zip(check.member.values, check.speed.values, strict=True)
        if np.isfinite(speed)
    )
    if speeds:
        figures["speeds"] = ", ".join(speeds)
    return figures


def _number(value: Any) -> str:
    if isinstance(value, (float, np.floating)):
        return "" if np.isnan(value) else f"{value + 0.0:.6g}"  # + 0.0: no negative zero
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_number, value))}]"
    return str(value)


def _list(values: Iterable[float]) -> str:
    return ", ".join(f"{value:.5g}" for value in values)


def _table(title: str, columns: Mapping[str, Iterable[Any]]) -> Table:
    """A table of named columns; columns with nothing in them are left out; numbers to the right."""
    table = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD, pad_edge=False)
    shown: list[list[str]] = []
    for name, values in columns.items():
        cells = [_number(value) for value in values]
        if cells and not any(cells):
            continue
        numeric = not any(isinstance(value, str) for value in values)
        table.add_column(escape(name), justify="right" if numeric else "left", overflow="fold")
        shown.append(cells)
    for row in zip(*shown, strict=True):
        table.add_row(*(escape(cell) for cell in row))
    return table


def _columns(result: xr.Dataset, dim: str, names: Mapping[str, tuple[str, float]]) -> dict[str, Any]:
    """Columns of a table over `dim`: variable -> (heading, factor from SI to the heading's unit)."""
    columns: dict[str, Any] = {dim: list(map(str, result[dim].values))}
    for name, (heading, factor) in names.items():
        if name in result:
            values = result[name].values
            columns[heading] = list(values * factor) if values.dtype.kind == "f" else [_plain(v) for v in values]
    return columns


def _plain(value: Any) -> Any:
    return (
        ("yes" if value else "")
        if isinstance(value, (bool, np.bool_))
        else value
        if not isinstance(value, str)
        else str(value)
    )


_DEGREES = 180 / np.pi


def _check(result: xr.Dataset) -> list[Table]:
    bodies = {
        "kind": ("kind", 1),
        "speed": ("speed [rpm]", 1),
        "torque": ("torque [N m]", 1),
        "power": ("power [kW]", 1e-3),
        "mass": ("mass [kg]", 1),
        "inertia": ("inertia [kg m2]", 1),
        "station": ("station [mm]", 1e3),
        "axes_angle": ("angle [deg]", _DEGREES),
    }
    gears = {
        "teeth": ("teeth", 1),
        "reference_radius": ("reference radius [mm]", 1e3),
        "base_radius": ("base radius [mm]", 1e3),
        "tip_radius": ("tip radius [mm]", 1e3),
        "root_radius": ("root radius [mm]", 1e3),
        "face_width": ("face width [mm]", 1e3),
        "profile_shift": ("shift", 1),
        "helix_angle": ("helix [deg]", _DEGREES),
    }
    meshes = {
        "phase_lead": ("lead [cycles]", 1),
        "working_pressure_angle": ("working angle [deg]", _DEGREES),
        "contact_ratio": ("contact ratio", 1),
        "overlap_ratio": ("overlap ratio", 1),
        "mean_mesh_stiffness": ("mean stiffness [N/um]", 1e-6),
    }
    stages = {
        "planets": ("branches", 1),
        "mesh_frequency": ("mesh frequency [Hz]", 1),
        "centre_distance": ("centre distance [mm]", 1e3),
        "hunting_period": ("hunting period [cycles]", 1),
    }
    tables = [
        _table("Stages", _columns(result, "stage", stages)),
        _table("Bodies", _columns(result, "body", bodies)),
        _table("Gears", _columns(result, "gear", gears)),
        _table("Meshes", _columns(result, "mesh", meshes)),
    ]
    if result.sizes.get("order_name"):
        orders = {"order_frequency": ("frequency [Hz]", 1), "order": ("mesh orders", 1)}
        tables.append(_table("Shaft and mesh frequencies", _columns(result, "order_name", orders)))
    if any(str(path).startswith("couplings.") for path in result.path.values):
        paths = {
            "path_from": ("from", 1),
            "path_to": ("to", 1),
            "path_torque": ("torque [N m]", 1),
            "path_power": ("power [kW]", 1e-3),
            "path_share": ("share of the input [%]", 100),
            "path_circulating": ("circulates", 1),
        }
        tables.append(
            _table("Power paths (from first to second, seen from the housing)", _columns(result, "path", paths))
        )
    return [*tables, _links(result), *_values(result)]


def _links(result: xr.Dataset) -> Table:
    stiffness = np.atleast_2d(result.link_stiffness.values)
    units = {"x": "N/m", "y": "N/m", "z": "N/m", "rx": "N m/rad", "ry": "N m/rad", "rz": "N m/rad"}
    columns: dict[str, Any] = {"link": list(map(str, result.link.values))}
    for at, direction in enumerate(result.direction.values):
        columns[f"{direction} [{units[str(direction)]}]"] = list(stiffness[:, at]) if len(columns["link"]) else []
    return _table("Supports, bearings, couplings (inf = rigid)", columns)


def _values(result: xr.Dataset) -> list[Table]:
    assumed = json.loads(result.attrs.get("assumed", "{}"))
    values = json.loads(result.attrs.get("values", "[]"))
    tables = []
    if assumed:
        tables.append(_table("Assumed", {"path": list(assumed), "why": [str(reason) for reason in assumed.values()]}))
    if values:
        shown = [_number(value) if not isinstance(value, str) else value for _, value, _, _ in values]
        columns = {
            "path": [path for path, *_ in values],
            "value": shown,
            "unit": [unit for _, _, unit, _ in values],
            "from": [origin for *_, origin in values],
        }
        tables.append(_table("Every value and where it came from", columns))
    return tables


def _modes(result: xr.Dataset) -> list[Table]:
    columns: dict[str, Any] = {
        "mode": list(map(int, result.mode.values)),
        "frequency [Hz]": list(result.frequency.values),
        "kind": list(map(str, result.mode_kind.values)),
        "multiplicity": list(map(int, result.multiplicity.values)),
        "damping ratio": list(result.damping_ratio.values),
        "most strain energy in": _largest(result.strain_energy_share, "connection"),
        "most kinetic energy in": _largest(result.kinetic_energy_share, "body"),
    }
    return [_table("Modes", columns)]


def _largest(share: xr.DataArray, dim: str) -> list[str]:
    values = share.transpose(dim, "mode").values
    names = share[dim].values
    texts = []
    for column in values.T:
        if not np.isfinite(column).any():
            texts.append("")
            continue
        at = int(np.nanargmax(column))
        texts.append(f"{names[at]} {column[at]:.0%}")
    return texts


def _campbell(result: xr.Dataset) -> list[Table]:
    speeds = result.relative_speed.values
    frequency = result.whirl_frequency.transpose("mode", "relative_speed").values
    picked = np.unique(np.linspace(0, len(speeds) - 1, 5).round().astype(int))
    columns: dict[str, Any] = {"mode": list(map(int, result.mode.values))}
    for at in picked:
        columns[f"{speeds[at]:.3g} x speed [Hz]"] = list(frequency[:, at])
    return [_table("Natural frequencies over speed", columns)]


def _stiffness(result: xr.Dataset) -> list[Table]:
    history = result.mesh_stiffness.transpose("mesh", "mesh_phase").values * 1e-6
    columns: dict[str, Any] = {
        "mesh": list(map(str, result.mesh.values)),
        "mean [N/um]": list(result.mean_mesh_stiffness.values * 1e-6),
        "least [N/um]": list(history.min(axis=1)),
        "most [N/um]": list(history.max(axis=1)),
    }
    return [_table("Mesh stiffness along the tooth normal", columns)]


def _forces(result: xr.Dataset) -> Table:
    force = result.mesh_force.transpose("mesh", ...).values.reshape(result.sizes["mesh"], -1)
    columns: dict[str, Any] = {
        "mesh": list(map(str, result.mesh.values)),
        "mean [N]": list(force.mean(axis=1)),
        "least [N]": list(force.min(axis=1)),
        "most [N]": list(force.max(axis=1)),
    }
    if "mesh_force_bound" in result:
        columns["bound over all shaft phases [N]"] = list(result.mesh_force_bound.values)
    if "face_load_factor" in result:
        columns["largest per mean along the face"] = list(result.face_load_factor.values)
    if "contact_lost" in result:
        columns["contact lost"] = ["yes" if lost else "no" for lost in result.contact_lost.values]
    return _table("Mesh forces along the tooth normal", columns)


def _sharing(result: xr.Dataset) -> list[Table]:
    coefficients = result.load_sharing.transpose("mesh", "definition")
    columns: dict[str, Any] = {"mesh": [*map(str, result.mesh.values), "train"]}
    for definition in result.definition.values:
        column = coefficients.sel(definition=definition).values
        columns[str(definition)] = [*column, result.system_load_sharing.sel(definition=definition).item()]
    return [_table("Load sharing", columns), _forces(result)]


def _sweep(result: xr.Dataset) -> list[Table]:
    frequency = result.mesh_frequency.values.ravel()
    rms = result.mesh_force_rms.transpose("mesh", "speed").values
    peak = result.mesh_force_peak.transpose("mesh", "speed").values
    rows = []
    for mesh, series, top in zip(result.mesh.values, rms, peak, strict=True):
        if np.isfinite(series).any():
            at = int(np.nanargmax(series))
            rows.append((str(mesh), float(series[at]), float(frequency[at]), float(np.nanmax(top))))
    headings = ("mesh", "largest rms [N]", "at mesh frequency [Hz]", "largest force [N]")
    status = result.status.values.astype(str)
    points = dict(zip(*np.unique(status, return_counts=True), strict=True))
    columns = {heading: [row[i] for row in rows] for i, heading in enumerate(headings)}
    title = f"{len(frequency)} speeds, {_number(frequency.min())} to {_number(frequency.max())} Hz"
    return [
        _table(f"Dynamic mesh forces, {title}", columns),
        _table("Points", {"status": list(map(str, points)), "points": [int(count) for count in points.values()]}),
    ]


def _steady(result: xr.Dataset) -> list[Table]:
    if not result.sizes.get("line"):
        return [_forces(result)]
    columns: dict[str, Any] = {
        "cause": list(map(str, result.line.values)),
        "frequency [Hz]": list(result.line_frequency.values),
        "largest amplitude of a mesh force [N]": list(result.line_amplitude.max("mesh").values),
    }
    return [_forces(result), _table("Shaft frequencies", columns)]


def _static(result: xr.Dataset) -> list[Table]:
    """Mesh forces, and what twists under a torque: necks, shafts, couplings."""
    force = result.link_force.transpose("link_row", "time").values
    twist = result.link_deflection.transpose("link_row", "time").values
    largest = float(np.abs(force).max(initial=0.0))
    rows = [i for i, name in enumerate(result.link_row.values) if str(name).endswith("/rz")]
    # a torque below 1e-9 of the largest force is rounding
    loaded = [i for i in rows if np.abs(force[i]).max() > 1e-9 * largest]
    columns: dict[str, Any] = {
        "link": [str(result.link_row.values[i]).removesuffix("/rz") for i in loaded],
        "mean torque [N m]": [float(force[i].mean()) for i in loaded],
        "mean twist [urad]": [float(twist[i].mean()) * 1e6 for i in loaded],
        "most [urad]": [float(np.abs(twist[i]).max()) * 1e6 for i in loaded],
    }
    torsion = [_table("Torsion of supports, necks, shafts and couplings", columns)] if loaded else []
    return [_forces(result), *torsion]


def _any(result: xr.Dataset) -> Sequence[Table]:
    """Tables of a result whose verb has none of its own: its forces, or each variable and its range."""
    if "mesh_force" in result:
        return [_forces(result)]
    names = [str(name) for name, values in result.data_vars.items() if values.dtype.kind == "f"]
    columns: dict[str, Any] = {
        "variable": names,
        "unit": [str(result[name].attrs.get("units", "")) for name in names],
        "least": [float(result[name].min()) for name in names],
        "most": [float(result[name].max()) for name in names],
    }
    return [_table("Variables", columns)]


_TABLES: dict[str, Callable[[xr.Dataset], Sequence[Table]]] = {
    "check": _check,
    "modes": _modes,
    "campbell": _campbell,
    "stiffness": _stiffness,
    "static": _static,
    "steady": _steady,
    "sharing": _sharing,
    "sweep": _sweep,
}
