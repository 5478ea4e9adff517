"""Views of `compare`, `track`, `sensitivity` and `detune`.

`compare`: what differs between drawings, and what it does; or what differs between saved results.

`track`: natural frequencies along a number of the model file, crossings and veerings.

`sensitivity`: what moves a natural frequency or a mesh force most.

`detune`: changes of the drawing that move a resonance away from operation, and what each gives.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...limits import ResonanceVerdict
from ...results.dataset import largest
from ...show.elements import (
    Company,
    ComparedRow,
    Drawing,
    Finding,
    KeyFigure,
    Part,
    Section,
    Table,
    compared_rows,
    letters,
    named_columns,
    number,
    percent,
    shown,
)
from ...show.series import engineering as number_of
from ...show.series import texts
from ...show.views import ResultView, in_section

# Differences of the drawing, natural frequencies and variables in the table; the Dataset has all of them.
_MOST = 12


def compared_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The changes as bars about the first train, and the table."""
    from ...show.charts.effects import compared

    words = "Change of each quantity from A, the largest at the top; what does not change is left out."
    parts: list[Part] = [Drawing(anchor="compared", figure=compared(result), caption=words), *compared_tables(result)]
    return [Section(anchor="compared", title="Beside each other", parts=parts)]


def key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """The three largest changes, each with the values."""
    rows = sorted((row for row in compared_rows(result) if row.largest), key=lambda row: -row.largest)[:3]
    found: list[KeyFigure] = []
    for row in rows:
        place = max(range(len(row.change)), key=lambda i: abs(row.change[i]) if math.isfinite(row.change[i]) else -1.0)
        ends = f"{shown(row.value[0], row.unit)} to {shown(row.value[place], row.unit)}"
        found.append((percent(row.change[place]), f"{letters(result)[place]} against A: {row.name}, {ends}"))
    return found


def compared_tables(result: xr.Dataset) -> Sequence[Table]:
    """One table: paths of the drawing that differ, then what they do, each with its change from A.

    Its notes say what is left out of it.
    """
    signs = letters(result)
    differing, notes = _differences(result) if "difference" in result.sizes else ([], [])
    effects, left = _effects(result)
    changes = ["change"] if len(signs) == 2 else [f"{sign} to A" for sign in signs[1:]]
    columns = named_columns(("", "what", *signs, *changes), [*differing, *map(_row, effects)])
    lead = "; ".join(f"{sign} = {name}" for sign, name in zip(signs, texts(result, "train"), strict=True))
    return [Table(title="Beside each other", columns=columns, lead=lead, notes=(*notes, *left))]


def _differences(result: xr.Dataset) -> tuple[list[tuple[str, ...]], list[str]]:
    """Rows of the drawing, and a note of those left out."""
    paths, values = texts(result, "difference"), result["difference_text"].values
    blank = [""] * result.sizes["train"]
    rows = []
    for path, row, numbers in zip(paths[:_MOST], values, result["difference_value"].values, strict=False):
        change = ComparedRow(group="drawing", name=path, unit="", value=tuple(map(float, numbers))).change
        # a dash where the file says nothing
        cells = [(one if len(one) <= 32 else f"{one[:29]}...") or "-" for one in map(str, row)]
        rows.append(("drawing", path, *cells, *map(percent, change[1:])))
    if not paths:
        return [("drawing", "no difference", *blank, *blank[1:])], []
    if len(paths) <= _MOST:
        return rows, []
    heads = Counter(".".join(path.split(".")[:2]) for path in paths[_MOST:])
    listed = ", ".join(f"{count} of {head}" for head, count in heads.items())
    return rows, [f"{len(paths) - _MOST} more differences of the drawings: {listed}; all with --json or -o"]


def _effects(result: xr.Dataset) -> tuple[list[ComparedRow], list[str]]:
    """Rows of effects: natural frequencies and variables that change most, all others; a note of what is left out."""
    rows = compared_rows(result)
    many = [row for row in rows if row.group in ("modes", "variable")]
    changed = sorted((row for row in many if row.largest), key=lambda row: -row.largest)
    kept = {id(row) for row in changed[:_MOST]}
    shown_rows = [row for row in rows if row.group not in ("modes", "variable") or id(row) in kept]
    notes = []
    words = "variables" if "largest_difference" in result else "natural frequencies"
    if len(changed) > _MOST:
        notes.append(f"{len(changed) - _MOST} more {words} change, by {changed[_MOST].largest:.3g} % at most")
    alone = sum(not any(math.isfinite(one) for one in row.change[1:]) for row in many)
    if same := len(many) - len(changed) - alone:
        notes.append(f"{same} {words} do not change")
    if alone:
        notes.append(f"{alone} {words} of A have no pair" if words != "variables" else f"{alone} {words} begin at 0")
    pairing = {text for text in map(str, result["mode_pairing"].values[1:]) if text} if "mode_pairing" in result else ()
    if pairing and many:
        notes.append(f"natural frequencies are paired by {' or '.join(sorted(pairing))}")
    return shown_rows, notes


def _row(row: ComparedRow) -> tuple[str, ...]:
    """Cells of one effect: value of every train, then the changes from the first."""
    note = row.note or ("",) * len(row.value)
    cells = [f"{shown(value, row.unit)}{' ' if one else ''}{one}" for value, one in zip(row.value, note, strict=True)]
    return row.group, row.name, *cells, *map(percent, row.change[1:])


def track_tables(result: xr.Dataset) -> Sequence[Table]:
    """Where loci meet, and the frequencies at a few values."""
    options = json.loads(str(result.attrs["options"]))
    over = f"{options['over']} [{options['unit']}]" if options["unit"] else options["over"]
    veers = result.event_kind.values == "veering"
    events: dict[str, Any] = {
        "what": list(map(str, result.event_kind.values)),
        "at": list(result.event_value.values),
        "frequency [Hz]": list(result.event_frequency.values),
        "modes": list(map(str, result.event_first.values)),
        "and modes": list(map(str, result.event_second.values)),
        "gap [Hz]": list(np.where(veers, result.event_gap.values, np.nan)),
        "coupling factor": list(np.where(veers, result.coupling_factor.values, 0.0)),
        "veering index": list(np.where(veers, result.veering_index.values, 0.0)),
    }
    values = result.parameter.values
    picked = np.unique(np.linspace(0, values.size - 1, 5).round().astype(int))
    columns: dict[str, Any] = {
        "mode": list(map(int, result.mode.values)),
        "kind": list(map(str, result.mode_kind.values)),
        "multiplicity": list(map(int, result.multiplicity.values)),
    }
    frequency = result.frequency.transpose("mode", "parameter").values
    for at in picked:
        columns[f"at {values[at]:.4g} [Hz]"] = list(frequency[:, at])
    met = [Table(title=f"Where modes meet along {over}", columns=events)] if result.sizes.get("event") else []
    return [*met, Table(title=f"Natural frequencies over {over}, modes followed from the first value", columns=columns)]


def track_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The loci with their crossings and veerings."""
    from ...show.charts.modes import loci

    words = "Thick: double roots. Shapes that share nothing cross; coupled ones veer and exchange their motion."
    parts = [Drawing(anchor="track", figure=loci(result), caption=words)]
    return [Section(anchor="track", title="Modes followed", parts=parts)]


def sensitivity_tables(result: xr.Dataset) -> Sequence[Table]:
    """Paths ranked; of a repeated root the least and the most of the set into which it splits."""
    dim = "mode" if "mode" in result.sizes else "mesh"
    chosen = np.flatnonzero(result.ranked_by.values.astype(bool))
    relative = result.sensitivity.transpose("path", dim).values
    derivative = result.derivative.transpose("path", dim).values
    columns: dict[str, Any] = {
        "path": list(map(str, result.path.values)),
        "value": [
            f"{number(value)} {unit}".strip()
            for value, unit in zip(result.parameter_value.values, result.parameter_unit.values, strict=True)
        ],
        "1 % moves it by [%]": [_span(row[chosen]) for row in relative],
        f"derivative [{'Hz' if dim == 'mode' else 'N'} per unit]": [_span(row[chosen]) for row in derivative],
        f"most it moves, {dim}": [_most(row, result[dim].values) for row in relative],
    }
    if set(texts(result, "status")) - {"ok"}:
        columns["status"] = texts(result, "status")
    found = [Table(title=f"What moves {result.attrs['subject']}", columns=columns)]
    left = {p: why for p, why in json.loads(result.attrs.get("left_out", "{}")).items() if why != "moves nothing"}
    if left:
        found.append(Table(title="Without a derivative", columns={"path": list(left), "why": list(left.values())}))
    return found


def sensitivity_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The numbers of the model file that move it most."""
    from ...show.charts.effects import tornado

    words = "What 1 % more of each number of the model does; a bar between two values: a repeated root splits."
    parts = [Drawing(anchor="sensitivity", figure=tornado(result), caption=words)]
    return [Section(anchor="sensitivity", title="Sensitivity", parts=parts)]


def sensitivity_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """The number of the model file that moves it most."""
    targets = result["ranked_by"].values.astype(bool)
    values = np.nan_to_num(result["sensitivity"].transpose("path", ...).values[:, targets])
    moved = np.abs(values).max(axis=1, initial=0.0)
    text = f"No number of the model moves {result.attrs['subject']}."
    if moved.max(initial=0.0) > 0:
        at = largest(moved)
        per = number(float(values[at][np.abs(values[at]).argmax()]))
        text = f"{texts(result, 'path')[at]} moves {result.attrs['subject']} most: {per} % per per cent."
    return [Finding(tone="", text=text, anchor="sensitivity")]


def detune_tables(result: xr.Dataset) -> Sequence[Table]:
    """Changes, the best first: where the resonance stands then, its force, and what is left in the band."""
    if not json.loads(result.attrs["resonance"]):
        return [Table(title="No resonance within the band: nothing is to be moved", columns={})]
    columns: dict[str, Any] = {"change": texts(result, "change")}
    for heading, name in _DETUNE_COLUMNS.items():
        columns[heading] = list(np.round(100 * result[name].values, 2))
    columns["of"], columns["also"] = texts(result, "left_resonance"), texts(result, "change_note")
    columns["status"] = ["" if status == "ok" else status for status in texts(result, "status")]
    return [Table(title=f"What moves {_resonance_text(result)}", columns=columns, digits=3)]


_DETUNE_COLUMNS = {
    "speed then [% of operation]": "moved_speed",
    "by its sensitivity [%]": "predicted_speed",
    "away [%]": "moved_away",
    "its force [% of the mean]": "moved_force_ratio",
    "strongest left in the band [%]": "left_force_ratio",
}


def _resonance_text(result: xr.Dataset) -> str:
    """``order 1 with mode 5 (159 Hz) at 97.3 % of the operating speed``."""
    found = json.loads(result.attrs["resonance"])
    hertz, speed = number_of(found["hertz"], 4), number_of(100 * found["speed"], 4)
    return f"order {found['order']} with mode {found['mode']} ({hertz} Hz) at {speed} % of the operating speed"


def detune_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """How the resonance stands, and the change that moves it away best."""
    found, options = json.loads(result.attrs["resonance"]), json.loads(result.attrs["options"])
    band = f"{100 * options['band']:.3g} %"
    if not found:
        text = f"No mesh order excites a mode within {band} of this speed: nothing is to be moved."
        return [Finding(tone="good", text=text, anchor="detune")]
    verdict = ResonanceVerdict(float(found["force_ratio"])) if "force_ratio" in found else None
    unknown = "its force is not known without torque and damping"
    force = unknown if verdict is None else f"the mode's force is {verdict.text}"
    text = f"{_resonance_text(result)}: {force}."
    change = "No number of the model moves it."
    if verdict is not None and verdict.tone == "good":
        change = "Nothing is to be done."
    elif result.sizes["change"] and texts(result, "status")[0] == "ok":
        names = ("moved_speed", "moved_away", "left_force_ratio")
        speed, away, left = (float(result[name].values[0]) for name in names)
        only = "" if abs(away) >= options["band"] * (1 - 1e-9) else "At most: "
        rest = f"{number_of(100 * left, 2)} %" if math.isfinite(left) else "not known"
        change = f"{only}{texts(result, 'change')[0]} moves it to {number_of(100 * speed, 4)} %"
        change += f" ({100 * away:+.0f} %); strongest left in the band {rest} of the mean force."
    tone = "caution" if verdict is None else verdict.tone
    text, change = (words[:1].upper() + words[1:] for words in (text, change))
    return [Finding(tone=tone, text=text, change=change, anchor="detune")]


def _span(values: np.ndarray) -> str:
    """Least and most of values (k,) as text, one number where they are equal to 1e-6."""
    low, high = float(np.min(values)), float(np.max(values))
    if not np.isfinite(low):
        return ""
    close = abs(high - low) <= 1e-6 * max(abs(low), abs(high))
    return number(low) if close else f"{number(low)} .. {number(high)}"


def _most(row: np.ndarray, names: np.ndarray) -> str:
    """Name of the largest of a row (k,) [%], and how much it is."""
    if not np.isfinite(row).any() or not np.nanmax(np.abs(row)) > 0:
        return ""
    at = largest(np.abs(row))
    return f"{names[at]}: {number(float(row[at]))} %"


_DETUNE = "detune", "What moves a resonance away"
VIEWS = (
    ResultView("compare", 15, compared_tables, compared_sections, key_figures=key_figures),
    ResultView("track", 100, track_tables, track_sections),
    ResultView("detune", 95, detune_tables, in_section(*_DETUNE, detune_tables), findings=detune_findings),
    ResultView("sensitivity", 90, sensitivity_tables, sensitivity_sections, findings=sensitivity_findings),
)
