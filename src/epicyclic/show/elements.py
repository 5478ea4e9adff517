"""What a view is made of: tables, figures, sections; `console` draws them in a terminal, `report` in a page.

Rows and tables that several views share: mesh forces, largest values over speed, transmission errors as ranges over
periods with the lines that make them, counts of a status; quantities that trains or results have, and how much each
differs from the first; where the numbers of a report come from: assumed values, options of the analyses, every resolved
value, the model.  No plotly.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from ..results.dataset import largest, ranked
from .series import ARCSEC, engineering, numbers, of_first_stage, own_tones, texts

if TYPE_CHECKING:
    import plotly.graph_objects as go


@dataclass(frozen=True, slots=True, kw_only=True)
class Styled:
    """Text of a cell that is good, for caution or bad.  tone : ``good``, ``caution``, ``bad``, or empty."""

    text: str
    tone: str = ""

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Named columns of equal length, the one source of a terminal's and a page's table.

    columns : heading with its unit -> cells, numbers in the unit of the heading; nan is an empty cell.  Columns with
        nothing in them are not shown, columns without text stand to the right.
    lead : a sentence above, notes : numbered sentences below.
    digits : significant digits of numbers in a page; decimals : their decimal places instead.
    """

    title: str
    columns: Mapping[str, Sequence[Any]]
    lead: str = ""
    notes: tuple[str, ...] = ()
    digits: int = 5
    decimals: int | None = None


class FigureText(NamedTuple):
    """A figure as the page takes it.  json : without the template of the page.  height : in px."""

    json: str
    height: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drawing:
    """A figure.  anchor : its id in the page, without ``figure-``.  caption : how to read it."""

    anchor: str
    figure: go.Figure | FigureText
    caption: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Listing:
    """Text as it stands, in a type of equal widths."""

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Details:
    """Parts that are folded away until asked for.  summary : what is clicked on."""

    summary: str
    parts: Sequence[Part]


Part = Table | Drawing | Listing | Details


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """One part of the report.  anchor : its id.  title : its heading, and its entry in the list of contents."""

    anchor: str
    title: str
    parts: Sequence[Part]


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """A sentence of the first page of a report: what passes, what does not, and what would change it.

    tone : ``good`` passes, ``caution`` is to be looked at, ``bad`` fails, empty is for knowing.  text : one sentence
    with its number and its limit, where there is one.  change : what to do.  anchor : of the section that says more.
    value, limit : of a number that is held against a limit, else nan.
    """

    tone: str
    text: str
    change: str = ""
    anchor: str = ""
    value: float = np.nan
    limit: float = np.nan


KeyFigure = tuple[str, str]  # a value with its unit, and what it is
Company = Mapping[str, Any]  # kind of result -> the first Dataset of that kind in the report


# Part of the largest number of a column below which another is rounding.
_ROUNDING = 1e-9


def number(value: Any) -> str:
    """A cell as text: six significant digits, nothing for nan."""
    if isinstance(value, float | np.floating):
        return "" if np.isnan(value) else f"{value + 0.0:.6g}"  # + 0.0: no negative zero
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(number, value))}]"
    return str(value)


def _without_rounding(values: Sequence[Any]) -> Sequence[Any]:
    """Cells of a column, 0 in place of numbers that are the rounding of its largest."""
    real = [isinstance(value, float | np.floating) and bool(np.isfinite(value)) for value in values]
    least = _ROUNDING * max((abs(value) for value, known in zip(values, real, strict=True) if known), default=0.0)
    return [0.0 if known and abs(value) < least else value for value, known in zip(values, real, strict=True)]


def shown_columns(table: Table, text: Callable[[Any], str]) -> list[tuple[str, bool, list[tuple[str, str]]]]:
    """Heading, whether it holds numbers alone, and (text, tone) of every cell, of the columns that hold something.

    Parameters
    ----------
    text : how a cell that is no text is written.
    """
    found = []
    for heading, values in table.columns.items():
        if "[" in heading:  # numbers of one unit; others stand beside each other with units of their own
            values = _without_rounding(values)
        cells = [
            (str(value) if isinstance(value, str | Styled) else text(value), getattr(value, "tone", ""))
            for value in values
        ]
        if cells and not any(words for words, _ in cells):
            continue
        numeric = not any(isinstance(value, str | Styled) for value in values)
        found.append((heading, numeric, cells))
    return found


def named_columns(headings: tuple[str, ...], rows: list[tuple[Any, ...]]) -> dict[str, list[Any]]:
    """Columns of rows of equal length."""
    return {heading: [row[i] for row in rows] for i, heading in enumerate(headings)}


def columns_of(result: xr.Dataset, dim: str, names: Mapping[str, tuple[str, float]]) -> dict[str, Any]:
    """Columns of a table over `dim`: variable -> (heading, factor from SI to the heading's unit)."""
    columns: dict[str, Any] = {dim: list(map(str, result[dim].values))}
    for name, (heading, factor) in names.items():
        if name in result:
            values = result[name].values
            columns[heading] = list(values * factor) if values.dtype.kind == "f" else [_plain(one) for one in values]
    return columns


def _plain(value: Any) -> Any:
    if isinstance(value, bool | np.bool_):
        return "yes" if value else ""
    return str(value) if isinstance(value, str) else value


def force_table(result: xr.Dataset) -> Table:
    """Mean, least and most of every mesh force [N], of mesh_force(mesh, ...), and what else is known of each mesh."""
    force, least, most = (  # extremes over the phases of the other lines too, where the result has them
        result[name if name in result else "mesh_force"].transpose("mesh", ...).values.reshape(result.sizes["mesh"], -1)
        for name in ("mesh_force", "mesh_force_least", "mesh_force_most")
    )
    columns: dict[str, Any] = {
        "mesh": list(map(str, result.mesh.values)),
        "mean [N]": list(force.mean(axis=1)),
        "least [N]": list(least.min(axis=1)),
        "most [N]": list(most.max(axis=1)),
    }
    further = {
        "mesh_force_bound": "bound over all phases [N]",
        **({} if "mesh_force_least" in result else {"mesh_force_minimum": "least over all phases [N]"}),
        "dynamic_factor": "K_v",
        "face_load_factor": "largest per mean along the face",
        "dynamic_face_load_factor": "largest at any time per mean",
        "open_share": "apart, share of time",
        "far_share": "on the far flank, share of time",
    }
    columns |= {heading: list(result[name].values) for name, heading in further.items() if name in result}
    if "contact_lost" in result:
        columns["contact lost"] = ["yes" if lost else "no" for lost in result.contact_lost.values]
    return Table(title="Mesh forces along the tooth normal", columns=columns)


_TORQUE_FACTOR = "largest per mean"


def largest_heading(result: xr.Dataset) -> str:
    """Heading of the largest radial forces: of several mesh frequencies they are a bound."""
    name = str(result["bearing_force_peak"].attrs.get("long_name", ""))
    return "largest, a bound [N]" if name.startswith("bound") else "largest [N]"


def largest_over_speed(
    result: xr.Dataset, dim: str, variable: str, heading: str, at: str = "at mesh frequency{of} [Hz]"
) -> dict[str, Any]:
    """Names, largest value of a variable (dim, speed) over the speeds, and where it is; nan where no speed has one.

    Where: the mesh's own frequency [Hz], of other things that of the first stage, which then takes the place of {of}.
    """
    values = result[variable].transpose(dim, "speed").values
    known = np.isfinite(values).any(axis=1)
    place = np.where(np.isfinite(values), values, -np.inf).argmax(axis=1)
    frequency = result.mesh_frequency.values.ravel()
    if dim == "mesh":
        own, of = own_tones(result), " of its stage" if of_first_stage(result) else ""
    else:  # of what belongs to no mesh
        own, of = np.ones(len(values)), of_first_stage(result)
    return {
        dim: list(map(str, result[dim].values)),
        heading: list(np.where(known, values[range(len(values)), place], np.nan)),
        at.format(of=of): list(np.where(known, own * frequency[place], np.nan)),
    }


# unit of a sensor -> as shown, factor from it
SENSOR_UNITS = {
    **{"1": ("µm/m", 1e6), "m/s2": ("m/s²", 1.0), "rad": ("µrad", 1e6), "N m": ("N m", 1.0)},
    "N": ("N", 1.0),  # of bolts, and of mesh forces through a window
}


def sensor_tables(result: xr.Dataset) -> list[Table]:
    """Mean and RMS of every sensor, its extremes over time or largest lines, or its largest RMS over speed."""
    if "sensor" not in result.dims:
        return []
    shown = [SENSOR_UNITS[unit] for unit in texts(result, "sensor_unit", "sensor")]
    scale = np.array([factor for _, factor in shown])[:, None]
    pairs = zip(texts(result, "sensor_direction", "sensor"), texts(result, "sensor_kind", "sensor"), strict=True)
    columns: dict[str, Any] = {"sensor": texts(result, "sensor"), "kind": [" ".join(pair).strip() for pair in pairs]}
    columns["unit"] = [unit for unit, _ in shown]
    if "sensor_signal" in result.variables:
        wave = scale * result["sensor_signal"].transpose("sensor", "time").values
        columns |= {"mean": list(wave.mean(axis=1)), "RMS of what varies": list(wave.std(axis=1))}
        columns |= {"least": list(wave.min(axis=1)), "most": list(wave.max(axis=1))}
    elif "sensor_amplitude" in result.variables:
        columns |= {"mean": list(scale[:, 0] * result["sensor_mean"].values)}
        columns |= {"RMS of what varies": list(scale[:, 0] * result["sensor_rms"].values)}
        hertz, said = result["sensor_line_frequency"].values, []
        for row in scale * np.abs(result["sensor_amplitude"].transpose("sensor", "sensor_line").values) * (hertz > 0):
            most = [int(i) for i in ranked(row)[:_LINES_NAMED] if row[i] > 0]
            said.append("; ".join(f"{engineering(float(hertz[i]))} Hz {row[i]:.4g}" for i in most))
        columns["largest lines [Hz], amplitude"] = said
    else:
        columns |= largest_over_speed(result, "sensor", "sensor_rms", "largest RMS")
        columns["largest RMS"] = list(scale[:, 0] * columns["largest RMS"])
    return [Table(title="Sensors", columns=columns, digits=5)]


def torque_tables(result: xr.Dataset) -> list[Table]:
    """Largest torque per mean of supports, necks, shafts and couplings of a result; over speeds where it is most."""
    if "link_force_factor" not in result.variables:
        return []
    factor = result["link_force_factor"]
    if "speed" in factor.dims:
        columns = largest_over_speed(result, "link_row", "link_force_factor", _TORQUE_FACTOR)
    else:
        columns = {"link_row": list(map(str, result.link_row.values))}
        if "link_force_mean" in result.variables:
            columns["mean [N m]"] = list(result.link_force_mean.values)
            columns["largest [N m]"] = list(result.link_force_peak.values)
        columns[_TORQUE_FACTOR] = list(factor.values)
    shown = [i for i, name in enumerate(columns["link_row"]) if name.endswith("/rz") and columns[_TORQUE_FACTOR][i] > 0]
    found = {name: [column[i] for i in shown] for name, column in columns.items()}
    named = {"link": [name.removesuffix("/rz") for name in found.pop("link_row")], **found}
    return [Table(title="Torque of supports, necks, shafts and couplings", columns=named)] if shown else []


def relative_speed(result: xr.Dataset) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Speeds (P,) per operating speed [1] of a sweep; nan where it does not say."""
    return numbers(result, "speed", "speed")


def speed_range_of(result: xr.Dataset) -> str:
    """The range that a sweep was asked for, ``operation`` or ``modes``; "" of speeds given."""
    return str(json.loads(str(result.attrs.get("options", "{}"))).get("speed_range") or "")


def extent(result: xr.Dataset) -> str:
    """Range of the speeds of a sweep: mesh frequencies, and per cent of the operating speed."""
    hertz, speed = result["mesh_frequency"].values, 100 * relative_speed(result)
    share = f", {engineering(speed.min())} to {engineering(speed.max())} % of operation" if len(speed) else ""
    shown = share if np.isfinite(speed).all() else ""
    of = of_first_stage(result)
    return f"{engineering(hertz.min(), 6)} to {engineering(hertz.max(), 6)} Hz{of and f' mesh frequency{of}'}{shown}"


def loaded(columns: dict[str, Any], heading: str) -> dict[str, Any]:
    """The rows of a table whose value is more than rounding, 1e-9 of the largest."""
    values = np.nan_to_num(np.array(columns[heading], dtype=float))
    shown = np.flatnonzero(values > 1e-9 * values.max(initial=0.0))
    return {name: [column[i] for i in shown] for name, column in columns.items()}


def status_table(result: xr.Dataset) -> Table:
    """How many points have which status, of status with any dims."""
    names, counts = np.unique(result.status.values.astype(str), return_counts=True)
    return Table(title="Points", columns={"status": list(map(str, names)), "points": [int(one) for one in counts]})


# kind -> what the rows are, unit shown, factor from SI, words
ERROR_KINDS = {
    "rotation": ("mesh", "µm", 1e6, "rotation of the gears"),
    "approach": ("mesh", "µm", 1e6, "approach with moving centres"),
    "shaft": ("shaft", "arcsec", ARCSEC, "shaft to shaft"),
}
# Lines named in a table.
_LINES_NAMED = 3


def error_tables(result: xr.Dataset) -> Sequence[Table]:
    """Ranges of transmission errors over their periods and their largest lines, or the largest range over speed.

    Of meshes that with the largest range of its pair [µm]; of shafts all [arcsec].
    """
    tables = []
    for title, kinds in (("meshes", ("rotation", "approach")), ("shafts", ("shaft",))):
        columns: dict[str, list[Any]] = {}
        for kind in kinds:
            for heading, cells in _error_columns(result, kind).items():
                columns.setdefault(heading, []).extend(cells)
        if columns:
            tables.append(Table(title=f"Transmission error of {title}", columns=columns, digits=4))
    return tables


def _error_columns(result: xr.Dataset, kind: str) -> dict[str, list[Any]]:
    """Rows of one kind of error, none of a result without."""
    dim, unit, scale, words = ERROR_KINDS[kind]
    name = f"transmission_error_{kind}"
    if f"{name}_range" in result.variables:
        spans = scale * result[f"{name}_range"].transpose(dim, "period").values
        columns: dict[str, list[Any]] = {dim: texts(result, dim)}
        columns |= {f"{one} [{unit}]": list(spans[:, i]) for i, one in enumerate(texts(result, "period"))}
        if result.sizes["error_line"]:
            columns[f"largest lines, amplitude [{unit}]"] = _largest_lines(result, f"{name}_line", dim, scale)
        rank = spans[:, -1]
    elif f"{name}_peak_to_peak" in result.variables and result[f"{name}_peak_to_peak"].dims == (dim, "speed"):
        heading = f"largest peak to peak [{unit}]"
        columns = largest_over_speed(result, dim, f"{name}_peak_to_peak", heading)
        columns[heading] = [scale * value for value in columns[heading]]
        rank = np.nan_to_num(columns[heading])
    elif f"{name}_peak_to_peak" in result.variables and result[f"{name}_peak_to_peak"].dims == (dim,):
        rank = scale * result[f"{name}_peak_to_peak"].values
        columns = {dim: texts(result, dim), f"peak to peak [{unit}]": list(rank)}
    else:
        return {}
    if kind == "shaft" and "wind_up" in result.variables:
        columns["mean wind-up [arcsec]"] = list(ARCSEC * result["wind_up"].values)
    if dim == "mesh":
        pairs = [tuple(name.split("/")[:2]) for name in columns["mesh"]]
        best = {pairs[place]: place for place in ranked(rank)[::-1]}
        columns = {heading: [cells[place] for place in sorted(best.values())] for heading, cells in columns.items()}
        columns["by"] = [words] * len(best)
    return columns


def _largest_lines(result: xr.Dataset, name: str, dim: str, scale: float) -> list[str]:
    """The largest lines of every row, in words."""
    labels, words = texts(result, "error_line"), []
    for row in scale * result[name].transpose(dim, "error_line").values:
        most = [int(place) for place in np.argsort(-row, kind="stable")[:_LINES_NAMED] if row[place] > 0]
        words.append("; ".join(f"{labels[place]} {row[place]:.3g}" for place in most))
    return words


# Relative change that is none: rounding of eigenvalues and of linear solves.
_SAME = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparedRow:
    """One quantity of all trains.

    group : modes, sharing, ...  name : of the quantity.  unit : of `value`, one a train, nan where there is none.
    note : of each train, behind the value.  first : what each is compared with, the first value where empty.
    """

    group: str
    name: str
    unit: str
    value: tuple[float, ...]
    note: tuple[str, ...] = ()
    first: tuple[float, ...] = ()

    @property
    def change(self) -> tuple[float, ...]:
        """Change from the first train [%], nan where it is not known or from 0."""
        first = self.first or (self.value[0],) * len(self.value)
        return tuple(100 * (b - a) / abs(a) if a else math.nan for a, b in zip(first, self.value, strict=True))

    @property
    def largest(self) -> float:
        """Size of the largest change [%]; 0 where nothing changes."""
        known = [abs(one) for one in self.change if math.isfinite(one)]
        return max(known) if known and max(known) > 100 * _SAME else 0.0


def letters(result: xr.Dataset) -> tuple[str, ...]:
    """Letters of the trains, A the first."""
    return tuple(chr(ord("A") + i) for i in range(result.sizes["train"]))


def percent(value: float) -> str:
    """A change in per cent with its sign; empty where it is not known, = where it is none."""
    if not math.isfinite(value):
        return ""
    return "=" if abs(value) <= 100 * _SAME else f"{value:+.3g} %"


def compared_rows(result: xr.Dataset) -> list[ComparedRow]:
    """Rows of a Dataset of kind `compare`, those that no train has left out; variables of results, or effects."""
    kinds = (_variables,) if "largest_difference" in result else (_speeds, _modes, _loads)
    return [row for kind in kinds for row in kind(result) if np.isfinite(row.value).any()]


def _speeds(result: xr.Dataset) -> Iterator[ComparedRow]:
    """Ratio, speeds that differ, mesh frequencies."""
    ratio = _numbers(result["transmission_ratio"].values)
    yield ComparedRow(group="speeds", name="ratio, driving to driven", unit="", value=ratio)
    for name, values in zip(texts(result, "member"), result["speed"].values, strict=True):
        row = ComparedRow(group="speeds", name=f"speed of {name}", unit="rpm", value=_numbers(values))
        if not np.isfinite(values).all() or row.largest:
            yield row
    for name, values in zip(texts(result, "stage"), result["mesh_frequency"].values, strict=True):
        words = f"mesh frequency of {name}" if result.sizes["stage"] > 1 else "mesh frequency"
        yield ComparedRow(group="speeds", name=words, unit="Hz", value=_numbers(values))


def _modes(result: xr.Dataset) -> Iterator[ComparedRow]:
    """Elastic natural frequencies, equal ones once, with the modal assurance where it is low."""
    if "frequency" not in result:
        return
    seen = set()
    values, kinds, shared = (result[name].values for name in ("frequency", "mode_kind", "modal_assurance"))
    for mode, row, kind, criterion in zip(result["mode"].values, values, kinds, shared, strict=True):
        key = tuple(f"{value:.6g}" for value in row)
        if not row[0] > 0 or key in seen:
            continue
        seen.add(key)
        note = tuple("" if not np.isfinite(one) or one > 0.95 else f"MAC {one:.2f}" for one in criterion)
        name = f"natural frequency {mode}, {kind[0]}"
        yield ComparedRow(group="modes", name=name, unit="Hz", value=_numbers(row), note=note)


def _loads(result: xr.Dataset) -> Iterator[ComparedRow]:
    """K_gamma with its mesh; the largest mean and largest mesh force, of one stage each where there are several."""
    note = tuple(texts(result, "worst_mesh"))
    yield ComparedRow(group="sharing", name="K_gamma", unit="", value=_numbers(result["k_gamma"].values), note=note)
    method = next((str(one) for one in result["force_method"].values if one), "")
    at = {"steady": "dynamic", "static": "at rest"}.get(method, "")
    named = {"mesh_force_mean": "largest mean mesh force", "mesh_force_peak": f"largest mesh force, {at}"}
    for name, words in named.items():
        values = result[name].values
        if values.size and np.isfinite(values).any():
            yield ComparedRow(group="forces", name=words, unit="kN", value=_numbers(np.fmax.reduce(values) / 1e3))


def _variables(result: xr.Dataset) -> Iterator[ComparedRow]:
    """Values of saved results where they differ most from the first."""
    for i, name in enumerate(texts(result, "variable")):
        first, other = result["first_value"].values[i], result["other_value"].values[i]
        places = tuple(map(str, result["difference_place"].values[i]))
        worst = largest(result["largest_difference"].values[i])
        value = (float(first[worst]), *(float(one) for one in other[1:]))
        against = (float(first[worst]), *(float(one) for one in first[1:]))
        unit = str(result["variable_unit"].values[i])
        unit = "" if unit == "1" else unit
        yield ComparedRow(group="variable", name=name, unit=unit, value=value, note=places, first=against)


def _numbers(values: Sequence[float] | np.ndarray) -> tuple[float, ...]:
    return tuple(float(one) for one in values)


def shown(value: float, unit: str) -> str:
    """A value with its unit; empty where there is none."""
    return "" if not math.isfinite(value) else f"{engineering(value, 4)} {unit}".rstrip()


def provenance(results: Mapping[str, xr.Dataset]) -> Section:
    """The last section of a report: the model of the first result that says it, and every analysis with its options."""
    assumed, values, model = (  # of the first result that has each
        next((result for result in results.values() if result.attrs.get(name)), None)
        for name in ("assumed", "values", "model")
    )
    parts: list[Part] = [] if assumed is None else [*assumed_tables(assumed)]
    attributes = [result.attrs for result in results.values()]
    runs = {
        "analysis": list(results),
        "options": [_options(str(one.get("options", "{}"))) for one in attributes],
        "package": [str(one.get("package", "")) for one in attributes],
        "version": [str(one.get("version", "")) for one in attributes],
    }
    parts.append(Table(title="", columns=runs))
    if values is not None:
        parts += [Details(summary=one.title, parts=[replace(one, title="")]) for one in value_tables(values)]
    if model is not None:
        parts.append(Details(summary="Resolved model", parts=[Listing(text=_indented(str(model.attrs["model"])))]))
    return Section(anchor="model", title="Model and provenance", parts=parts)


def assumed_tables(result: xr.Dataset) -> list[Table]:
    """Values that the source does not print, by path, and why they were chosen; none where all are printed."""
    assumed = json.loads(result.attrs.get("assumed", "{}"))
    columns = {"path": list(assumed), "why": [str(reason) for reason in assumed.values()]}
    return [Table(title="Assumed values", columns=columns)] if assumed else []


def value_tables(result: xr.Dataset) -> list[Table]:
    """Every resolved value of the model, its unit and its origin."""
    values = json.loads(result.attrs.get("values", "[]"))
    columns = {
        "path": [path for path, *_ in values],
        "value": [_number(value) for _, value, *_ in values],
        "unit": [unit or "" for _, _, unit, _ in values],
        "from": [origin or "" for *_, origin in values],
    }
    return [Table(title="Every resolved value", columns=columns, digits=7)] if values else []


def _number(value: Any) -> Any:
    """A value as it was resolved: numbers stay numbers, text that reads as one becomes one."""
    if value is None:
        return ""
    if isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            return value
    return str(value) if isinstance(value, bool) else value


def _options(text: str) -> str:
    try:
        found = json.loads(text)
    except json.JSONDecodeError:
        return text
    words = {key: json.dumps(value) if isinstance(value, list | dict) else str(value) for key, value in found.items()}
    return "; ".join(f"{key}: {word if len(word) <= 120 else f'{word[:117]}...'}" for key, word in words.items())


def _indented(text: str) -> str:
    try:
        return json.dumps(json.loads(text), indent=2, ensure_ascii=False)
    except json.JSONDecodeError:
        return text
