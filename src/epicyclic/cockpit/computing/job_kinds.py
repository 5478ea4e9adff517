"""Jobs of the page: what takes longer than a lever waits, each with its defaults and its result as said and drawn.

The server reads their table and runs none: `answers` is imported where it is used, half a second of its start.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from inspect import signature
from pathlib import Path
from typing import Any, NamedTuple
from warnings import catch_warnings

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...document.tables import PlainTable
from ...errors import ModelError
from ...options import ALL_CASES, Option
from ...results.dataset import ranked
from ...show.elements import ERROR_KINDS, Finding, Table, error_tables
from ...show.series import (
    ARCMIN,
    judged_quantile,
    of_definition,
    overlap,
    relief_effect,
    scattering_pair,
    system_quantiles,
    tenth_less,
    texts,
    zones_of,
)
from ...show.views import cases_tables, findings_of, tables_of
from ...system.tooth_pairs import first_mesh
from ...train.resolution import load
from ...train.train import Train
from ...warning_codes import code_of
from ..state.frames import LEVELS, Answer, PageFrame, force_unit, mesh_labels, number, per_cent, speed_axis
from .answers import changes_of

Array = NDArray[np.float64]

# Curves that are drawn strong: more are not told apart.
_STRONG = 4
# Points of a curve that are sent: a tenth of it, drawn by itself, has one for each pixel of the pane.
_POINTS = 16_384


class Drawn(NamedTuple):
    """What a job draws.  head : ``lines`` or ``bars`` of its head.

    arrays : ``job/x`` (n,) and ``job/y`` (curve, n), or ``job/bar`` (row,).  title : the name of the job where empty.
    tables : that stand above it.
    """

    head: Mapping[str, Any]
    arrays: Mapping[str, NDArray[np.float32]]
    title: str = ""
    tables: Sequence[Table] = ()


def lines(
    x_label: str, y_label: str, x: Array, curves: Mapping[str, Array], *, pale: str = "", zero: bool = False
) -> Drawn:
    """Curves (n,) over x (n,) by label; those with the largest values strong, of long ones the envelope.

    pale : label of a curve that is there to be compared with.  zero : whether a line is drawn there.
    """
    labels = list(curves)
    y = np.array([np.asarray(curves[label], dtype=float) for label in labels]).reshape(len(labels), -1)
    x, y = envelope(np.asarray(x, dtype=float), y)
    most = np.max(np.where(np.isfinite(y), y, -np.inf), axis=1, initial=-np.inf)
    first = set(ranked(np.where(np.isfinite(most), most, np.nan))[:_STRONG].tolist())
    rows = [{"label": label, "strong": row in first, "pale": label == pale} for row, label in enumerate(labels)]
    head = {"x_label": x_label, "y_label": y_label, "curves": rows, "zero": zero}
    return Drawn({"lines": head}, {"job/x": np.asarray(x, np.float32), "job/y": np.asarray(y, np.float32)})


def envelope(x: Array, y: Array, most: int = _POINTS) -> tuple[Array, Array]:
    """x (n,) and curves y (curve, n) of at most so many points: of as many neighbours as become two points the least
    and the largest value, in the order in which they come; no peak is lost.  All points where they are fewer."""
    if len(x) <= most:
        return x, y
    size = -(-len(x) // (most // 2))
    columns = -(-len(x) // size)
    padded = np.full((len(y), columns * size), np.nan)
    padded[:, : len(x)] = y
    cells = padded.reshape(len(y), columns, size)
    low = np.where(np.isfinite(cells), cells, np.inf).argmin(axis=2)
    high = np.where(np.isfinite(cells), cells, -np.inf).argmax(axis=2)
    ends = np.take_along_axis(cells, np.sort(np.stack([low, high], axis=2), axis=2), axis=2)
    places = (np.arange(columns)[:, None] * size + np.array([0, size // 2])).ravel()
    places[-1] = len(x) - 1
    return x[places], ends.reshape(len(y), -1)


def bars(x_label: str, rows: Sequence[str], values: Array) -> Drawn:
    """Bars (row,) with their labels."""
    return Drawn({"bars": {"x_label": x_label, "rows": list(rows)}}, {"job/bar": np.asarray(values, np.float32)})


def job_frame(
    name: str,
    title: str,
    text: str,
    drawn: Drawn,
    *,
    apply: Mapping[str, object] | None = None,
    apply_label: str = "",
    answers: Sequence[Answer] = (),
    kept: Sequence[tuple[Mapping[str, object], Answer]] = (),
    tables: Sequence[Table] = (),
) -> PageFrame:
    """The frame of a job that is done, of no state yet; with ``answers`` where it answers a question.

    kept : overrides with which the result still holds, since it knows of them, and the answer that then stands.
    tables : that stand above what is drawn.
    """
    job = {"name": name, "title": title, "text": text, **drawn.head}
    if tables:
        from ...show.report import html_table

        job["tables"] = "".join(html_table(table) for table in tables)
    job |= {"apply": dict(apply) if apply else None, "apply_label": apply_label if apply else ""}
    head: dict[str, Any] = {"job": job}
    if answers:
        head["answers"] = [asdict(answer) for answer in answers]
    head["kept"] = [
        {
            "overrides": dict(overrides),
            "answers": [asdict(answer)],
            "job": {"text": f"{answer.figure} {answer.text}", "apply": answer.apply, "apply_label": answer.apply_label},
        }
        for overrides, answer in kept
    ]
    return PageFrame(rev=0, kind="job", head=head, arrays=drawn.arrays)


def found_frame(kind: JobKind, result: xr.Dataset, drawn: Drawn) -> PageFrame:
    """What any result shows: its findings, or its warnings where it has none, what is drawn, and the first finding as
    the answer of its question."""
    findings, warnings = findings_of({kind.name: result}), json.loads(str(result.attrs.get("warnings", "[]")))
    said = [one.text for one in findings] or [f"{str(text).partition(' [')[0].capitalize()}." for text in warnings]
    answers = []
    if kind.question and findings:
        first = findings[0]
        value = "" if np.isnan(first.value) else number(first.value, 4)
        limit = None if np.isnan(first.limit) else {"value": first.limit, "words": "", "source": "", "path": ""}
        answer = partial(Answer, kind.question, figure=value, limit=limit, evidence=kind.name, job=kind.name)
        answers.append(answer(f"{first.text} {first.change}".strip(), level=LEVELS[first.tone]))
    title = drawn.title or kind.label
    return job_frame(kind.name, title, " ".join(said), drawn, answers=answers, tables=drawn.tables)


def first_variable(result: xr.Dataset, train: Train, _: Mapping[str, Any]) -> Drawn:
    """The first variable of numbers over its last dim: lines over numbers, over names bars of its largest."""
    known = (one for one in result.data_vars.values() if one.dtype.kind == "f" and 1 <= one.ndim <= 2)
    values = next(known, None)
    if values is None:
        return bars("", [], np.empty(0))
    along, labels, rows = values[values.dims[-1]], mesh_labels(train), np.atleast_2d(values.values)
    if along.dtype.kind in "fiu":
        names = [str(name) for name in values[values.dims[0]].values] if values.ndim == 2 else [_title(values)]
        curves = dict(zip([labels.get(name, name) for name in names], rows, strict=True))
        return lines(_title(along), _title(values), along.values, curves)
    return bars(_title(values), [labels.get(str(name), str(name)) for name in along.values], rows.max(axis=0))


def _title(values: xr.DataArray) -> str:
    """Name of an axis with its unit."""
    name = str(values.attrs.get("long_name") or values.name).replace("_", " ")
    return f"{name} [{values.attrs.get('units') or '1'}]"


def cases_frame(result: xr.Dataset, others: Sequence[xr.Dataset]) -> PageFrame:
    """K_gamma of every load case; a row a case with its time, load sharing, nearest resonance and operation.

    others : results of `modes` and `check` over the same cases, as far as they are there.
    """
    weights, *sharing = cases_tables(result)
    tables = [table for other in others for table in cases_tables(other)[1:]]
    couplings = [table for table in tables if table.title.startswith("Couplings")]
    names = list(weights.columns["case"])
    joined: dict[str, Any] = {}
    for table in (weights, *sharing, *(one for one in tables if one not in couplings)):
        place = {name: at for at, name in enumerate(table.columns["case"])}
        for heading, cells in (item for item in table.columns.items() if item[0] not in joined):
            joined[heading] = [cells[place[name]] if name in place else "" for name in names]
    factors = np.array([value or np.nan for value in joined.get("K_gamma", [""] * len(names))], float)
    failed = [text for text in json.loads(str(result.attrs["warnings"])) if code_of(text) == "case-failed"]
    found = [*(text.rpartition(" [")[0] + "." for text in failed), *(one.text for one in findings_of({"": result}))]
    said = " ".join(found) or f"{len(names)} load cases."
    one = Table(title="", columns={name: joined[name] for name in joined if name not in _TOO_MUCH}, digits=4)
    return job_frame("cases", "Load cases", said, bars("K_gamma [1]", names, factors), tables=(one, *couplings))


# Columns of cases that findings say, or that fill a screen.
_TOO_MUCH = ("sharing", "mesh")
_DRAW = "Draw this relief"


def relief_frame(result: xr.Dataset, train: Train) -> PageFrame:
    """Transmission error over the mesh cycle before and after; the answer on relief, and the overrides that draw it.

    With those, and with those that let the curve over speed follow, the numbers before and after stand.
    """
    from .answers import FOLLOW, follow_overrides, uncounted

    mean = result["relieved_error"].transpose("state", "relieved_mesh", "load_factor", "mesh_phase")
    operating = int(np.abs(result["load_factor"].values - 1).argmin())
    error = 1e6 * mean.values[:, 0, operating]
    curves = {"after": error[1] - error[1].mean(), "before": error[0] - error[0].mean()}
    drawn = lines("mesh cycle [1]", "error about its mean [µm]", result["mesh_phase"].values, curves)
    (finding,) = findings_of({"relief": result})
    overrides = json.loads(str(result.attrs["overrides"])) if finding.tone != "good" else {}
    figure = str(result["solution_text"].values[int(result.attrs["picked"]), 0]).replace("um", "µm")
    answer = partial(Answer, "relief", then=figure, evidence="relief", job="relief")
    text, level = f"{finding.text} {finding.change}".strip(), LEVELS[finding.tone]
    found = answer(text, level=level, apply=overrides, apply_label=_DRAW)
    kept: list[tuple[Mapping[str, object], Answer]] = []
    if overrides:
        relieved = load(dict(train.document), overrides)
        effect, follow = relief_effect(result), follow_overrides(relieved)
        what = effect.what.removeprefix("peak to peak of the loaded ")
        text = f"is drawn: {what} {effect.before} before, {effect.after} after{effect.at}."
        after = answer(f"{text}{uncounted(relieved)}", level="good", apply=follow, apply_label=FOLLOW)
        kept.append((overrides, after))
        if follow:
            kept.append(({**overrides, **follow}, answer(text, level="good")))
    return job_frame(
        "relief", "Tip relief", finding.text, drawn, apply=overrides, apply_label=_DRAW, answers=[found], kept=kept
    )


# Rows of bars that are read, and seen without scrolling.
_MOST = 10
# A fall of K_gamma below this is none: half a unit of the last digit shown.
_NO_FALL = 5e-4


def contact_loss(result: xr.Dataset, train: Train, _: Mapping[str, Any]) -> Drawn:
    """Largest and least force of any mesh over speed, run-up and coast-down, over the largest of linear contact."""
    from ...questions.response import SweepOptions
    from ...questions.response.steady import sweep
    from ...system.assembly import assemble

    relative = np.asarray(result["speed"].values, dtype=float)
    peak = result["mesh_force_peak"].transpose("direction", "mesh", "speed").values
    least = result["mesh_force_minimum"].transpose("direction", "mesh", "speed").values
    shaft_orders = bool(json.loads(str(result.attrs["options"]))["shaft_orders"])
    options = SweepOptions(relative_speed=relative, shaft_orders=shaft_orders, forces_alone=True)
    linear = sweep(assemble(train), options)
    unit, scale = force_unit(float(np.nanmax(np.abs(peak), initial=0.0)))
    with np.errstate(all="ignore"), catch_warnings(action="ignore", category=RuntimeWarning):
        curves = {
            "linear, largest": scale * np.nanmax(linear["mesh_force_peak"].values, axis=0),
            "run-up, largest": scale * np.nanmax(peak[0], axis=0),
            "coast-down, largest": scale * np.nanmax(peak[-1], axis=0),
            "least of both": scale * np.nanmin(least, axis=(0, 1)),
        }
    label, operating = speed_axis(train) or ("speed per operation [%]", 100.0)
    drawn = lines(label, f"mesh force [{unit}]", operating * relative, curves, pale="linear, largest", zero=True)
    return drawn._replace(title=f"Teeth that part, {'with shaft orders' if shaft_orders else 'mesh orders'}")


def _of_meshes(result: xr.Dataset, train: Train, values: Array) -> dict[str, Array]:
    """Curves (m, n) of the meshes of a result by the labels that meshes have on the page."""
    labels = mesh_labels(train)
    return {labels[str(name)]: row for name, row in zip(result["mesh"].values, values, strict=True)}


def forces_over_time(result: xr.Dataset, train: Train, _: Mapping[str, Any]) -> Drawn:
    """Forces of all meshes over time."""
    force = result["mesh_force"].transpose("mesh", "time").values
    unit, scale = force_unit(float(np.nanmax(np.abs(force), initial=0.0)))
    time = np.asarray(result["time"].values, dtype=float)
    ms, word = (1e3, "ms") if time[-1] < 1 else (1.0, "s")
    curves = _of_meshes(result, train, scale * force)
    drawn = lines(f"time [{word}]", f"mesh force [{unit}]", ms * time, curves, zero=bool((force < 0).any()))
    return drawn._replace(title="Motion over time")


_VIEWS = ("transmission error", "load along the face")
_ERRORS = ("by rotation", "by approach", "shaft to shaft")  # kinds of transmission error, as ERROR_KINDS has them


def tooth_contact(result: xr.Dataset, train: Train, options: Mapping[str, Any]) -> Drawn:
    """Loaded transmission error over the mesh cycle at every load, or the largest load along the face."""
    loads = np.asarray(result["mesh_load"].values, dtype=float)
    if options.get("show") == _VIEWS[1]:
        length = result["load_per_length"].transpose("mesh", "width", "mesh_phase").values.max(axis=2) / 1e3
        curves = _of_meshes(result, train, length)
        drawn = lines("place along the face [1]", "largest load [N/mm]", result["width"].values, curves)
    else:
        error = 1e6 * result["loaded_transmission_error"].transpose("torque_factor", "mesh_phase").values
        share = loads / float(result.attrs["force"])
        curves = {f"{100 * share[row]:.0f} % load": error[row] - error[row].mean() for row in range(len(loads))}
        drawn = lines("mesh cycle [1]", "error about its mean [µm]", result["mesh_phase"].values, curves)
    return drawn._replace(title="Loaded tooth contact")


def mesh_stiffness(result: xr.Dataset, train: Train, _: Mapping[str, Any]) -> Drawn:
    """Mesh stiffness over one mesh cycle, each mesh at its phase."""
    history = 1e-9 * result["mesh_stiffness"].transpose("mesh", "mesh_phase").values
    curves = _of_meshes(result, train, history)
    drawn = lines("mesh cycle [1]", "mesh stiffness [N/nm]", result["mesh_phase"].values, curves)
    return drawn._replace(title="Mesh stiffness and phases")


def steady_frame(result: xr.Dataset, train: Train, options: Mapping[str, Any]) -> PageFrame:
    """Transmission errors of one kind over a mesh cycle, or over the time of a motion that was followed; all in tables.

    Raises
    ------
    ModelError : errors of shafts where only one turns.
    """
    shown = options.get("show", _ERRORS[0])
    kind = list(ERROR_KINDS)[_ERRORS.index(shown)]
    dim, unit, scale, _ = ERROR_KINDS[kind]
    if (name := f"transmission_error_{kind}") not in result.variables:
        allowed = " or ".join(view for view, key in zip(_ERRORS, ERROR_KINDS, strict=True) if key != kind)
        raise ModelError("no two shafts turn by a ratio", path="show", given=shown, allowed=allowed)
    along = next(str(one) for one in result[name].dims if one != dim)
    values = scale * result[name].transpose(dim, along).values
    curves = _of_meshes(result, train, values) if dim == "mesh" else dict(zip(texts(result, dim), values, strict=True))
    words = "mesh cycle [1]" if along == "mesh_phase" else f"{along.replace('_', ' ')} [s]"
    drawn = lines(words, f"lag of what is driven [{unit}]", result[along].values, curves)
    chosen = json.loads(result.attrs["options"])
    said = f"Lag of what is driven at {per_cent(chosen['relative_speed'])} of the operating speed"
    said += ", teeth part and touch again." if chosen.get("contact_loss") else ", teeth in contact."
    return job_frame("steady", f"Transmission error, {shown}", said, drawn, tables=error_tables(result))


def angle_over_torque(result: xr.Dataset, *_: Any) -> Drawn:
    """Angle over torque of both branches, mean over the places of the mesh cycle, and the tables."""
    rising, falling = (ARCMIN * result[f"angle_{way}"].mean("mesh_phase").values for way in ("rising", "falling"))
    one = np.allclose(rising, falling, rtol=1e-9)
    curves = {"both branches": rising} if one else {"rising": rising, "falling": falling}
    drawn = lines("torque [N m]", "angle [arcmin]", result["shaft_torque"].values, curves, zero=True)
    return drawn._replace(title=f"Angle of {result.attrs['shaft']}", tables=tables_of(result))


_BEARINGS = ("life", "load zones")


def bearing_lives(result: xr.Dataset, _: Train, options: Mapping[str, Any]) -> Drawn:
    """Life of every bearing over all cases, or the loads of its elements, and the tables."""
    hours = result["bearing_duty_life_reference"].values / 3600
    drawn = bars("life L10r [h]", texts(result, "bearing"), np.where(np.isfinite(hours), hours, 0.0))
    if options.get("show") == _BEARINGS[1]:
        angle = np.linspace(-180.0, 180.0, 361)
        zones = {name: np.interp(angle, *zone, period=360.0) for name, zone in zones_of(result).items()}
        drawn = lines("angle from the most loaded element [deg]", "load of an element [kN]", angle, zones)
    return drawn._replace(title="Life of bearings", tables=tables_of(result))


def ranked_numbers(result: xr.Dataset, *_: Any) -> Drawn:
    """Per cent per per cent of the ranked mode or mesh, the largest first."""
    dim = "mode" if "mode" in result["sensitivity"].dims else "mesh"
    targets = result["ranked_by"].values.astype(bool)
    values = result["sensitivity"].transpose("path", dim).values[:, targets]
    size = np.nan_to_num(np.abs(values)).argmax(axis=1)
    value = np.nan_to_num(values[np.arange(len(values)), size])
    order = ranked(np.abs(value))[:_MOST]
    paths = [str(path) for path in result["path"].values]
    return bars("per cent per per cent", [_short_path(paths[i]) for i in order], value[order])


def _short_path(path: str) -> str:
    """``sun support radial`` of ``stages.main.sun.support.radial``."""
    words = path.split(".")
    return " ".join(words[2:] if words[0] == "stages" and len(words) > 2 else words).replace("_", " ")


def tolerance_frame(result: xr.Dataset, train: Train) -> PageFrame:
    """What a tenth less of each tolerance takes off K_gamma, by their places, and K_gamma of the trains beside its
    limit; the answers on errors and on the planet that carries most, whose mark then is that of nearly all trains."""
    from .answers import assumed_of, limit_of

    names, ranking = [str(name) for name in result["tolerance"].values], tenth_less(result)
    first, at = ranking.order[0], per_cent(ranking.probability)
    moving = [i for i in ranking.order if ranking.low[i] < 0 or ranking.high[i] > 0]
    order, nothing = moving[:_MOST] or [first], len(names) - len(moving)
    finding = next(one for one in findings_of({"tolerance": result}) if one.anchor == "tolerances")
    rows = [f"{ranking.place(i)}  {_entry_words(names[i], train)}" for i in order]
    drawn = bars(f"off K_gamma at {at} by a tenth less [1]", rows, -ranking.value[order])
    whiskers = {"job/low": -ranking.high[order], "job/high": -ranking.low[order]}
    marks = [[value, per_cent(p)] for p, value in system_quantiles(result).items()]
    scale = {"marks": marks, "limit": None if result.attrs["ranked_pair"] else finding.limit}  # both of the train
    note = "Tolerances" + (f", {nothing} more take nothing off" if nothing else "")
    head = {"bars": {**drawn.head["bars"], "scale": scale, "note": note}, "met": finding.tone == "good"}
    arrays = {name: np.asarray(ends, np.float32) for name, ends in whiskers.items()}
    then, apply = _halved(result, first, finding, train)
    shares = overlap(of_definition(result).isel(pair=scattering_pair(of_definition(result))))
    half = float(ranking.high[first] - ranking.value[first])
    figure = "nothing to do" if finding.tone == "good" else f"{ranking.value[first]:.4f} ± {half:.4f}"
    answer = partial(Answer, evidence="tolerance", job="tolerance", assumed=assumed_of(train, "tolerance"))
    text, level = f"{finding.change}{then} Shares of the variance {shares}.", LEVELS[finding.tone]
    halve = partial(answer, apply=apply, apply_label="Halve this tolerance")
    error = halve("error", text, figure=figure, level="good" if level == "good" else "warn")
    limits = dict(zip(*(result[f"k_gamma_limit{name}"].values.tolist() for name in ("", "_source")), strict=True))
    limit = limit_of(finding.limit, str(limits[finding.limit]))
    planet = answer("planet", finding.text, then=f"{finding.value:.3f} at {at}", level=level, limit=limit)
    text = f"{finding.text} {finding.change} What is drawn stands in place of the numbers of the model."
    return job_frame(
        "tolerance",
        "Tolerances",
        text,
        Drawn(head, {**drawn.arrays, **arrays}),
        apply=apply,
        apply_label="Halve the first",
        answers=[error, planet],
    )


def _halved(result: xr.Dataset, entry: int, finding: Finding, train: Train) -> tuple[str, Mapping[str, object]]:
    """What K_gamma is with half of a tolerance, in words, and the overrides; nothing where K_gamma passes, or where it
    would not fall."""
    from .answers import halved_tolerance

    curve = result["k_gamma_by_scale"].isel(tolerance=entry).sel(probability=judged_quantile(result)[0])
    whole, half = (float(curve.sel(scale=scale)) for scale in (1.0, 0.5))
    values = halved_tolerance(train, str(result["tolerance"].values[entry]))
    if finding.tone == "good" or not values or not half < whole - _NO_FALL:
        return "", {}
    return f" Half of the first: K_gamma falls by {whole - half:.3f}.", values


def _entry_words(entry: str, train: Train) -> str:
    """``planet position`` of ``deviations.main.planet.position``."""
    path, _, part = entry.partition(" ")
    words = path.split(".")[1:]
    if len(train.planets) == 1:
        words = [word for word in words if word not in train.planets]
    text = " ".join(word for word in words if word != "meshes").replace("_", " ")
    return f"{text} ({part})" if part else text


Source = PlainTable | Path
Progress = Callable[..., None]

# Length of a tip relief that is searched, in modules: from the tip to the highest point of single contact at most.
_LENGTHS = (0.1, 0.7)
# Amounts that are searched, per first estimate.
_AMOUNTS = 2.0
# Candidates and generations of the quick search: two variables and one objective need no more.
_POPULATION, _GENERATIONS = 12, 8
# Loads whose largest transmission error is made least, relative: of one alone the search would fit it and no other.
_LOADS = (0.75, 1.0)


# Share of the time after which the results beside that of a job are there.
_BESIDE = 0.95


@dataclass(frozen=True, slots=True, kw_only=True)
class JobKind:
    """A kind of job.

    name, label, purpose : of the page.  about : what it does by default, in a sentence.
    quick : a view that is computed within a second or two; others are jobs of some time.
    effort : time per that of the live set of the train, with one mesh frequency and with several.
    grows : options that the time is proportional to, with their defaults; of a yes how many times as long it takes.
    counted : shares of the time from and to which the progress of the verb goes; before and after it says nothing.
    runs : verb that it runs, that of its name where empty.  options : its keywords that may be chosen, a job refuses
    others; where none are named all that write or read no file.
    defaults : its keywords unless chosen otherwise.  search : those that follow from the train.
    overrides : of the model beside those of the page.  beside : further verbs whose results stand with its own.
    question : of `QUESTIONS`, that the first finding of its result answers.  draw : (result, train, chosen options) ->
    what is drawn beside its findings.  frame : the same and the results beside it -> all that the page shows in place
    of that.  views : what that may draw, as ``show``.
    """

    name: str
    label: str
    purpose: str
    about: str
    quick: bool = False
    effort: tuple[float, float] = (10, 10)
    grows: Mapping[str, float] = field(default_factory=dict)
    counted: tuple[float, float] = (0.05, 0.95)
    runs: str = ""
    options: tuple[str, ...] = ()
    defaults: Mapping[str, Any] = field(default_factory=dict)
    views: tuple[str, ...] = ()
    search: Callable[[Train], Mapping[str, Any]] | None = None
    overrides: Mapping[str, object] = field(default_factory=dict)
    beside: tuple[str, ...] = ()
    question: str = ""
    draw: Callable[..., Drawn] = first_variable
    frame: Callable[..., PageFrame] | None = None

    @property
    def verb(self) -> str:
        """Name of the verb that it runs."""
        return self.runs or self.name

    def keywords(self) -> dict[str, tuple[Any, Any, Option]]:
        """Keyword -> default, type and option of the verb, of those that may be chosen."""
        from ...verbs.record import keywords, verbs

        known = keywords(verbs()[self.verb].run)
        of_files = {name for name, (_, kind, _) in known.items() if name == "resume" or "Path" in str(kind)}
        return {name: known[name] for name in self.options or known if name in self.options or name not in of_files}

    def seconds(self, live: float, frequencies: int) -> float:
        """About how long it takes with its defaults [s], where the live set of the train takes so long [s].

        frequencies : of meshes, in number.
        """
        return live * self.effort[frequencies > 1]

    def work(self, options: Mapping[str, Any]) -> float:
        """Work with these options per that with its defaults [1]."""
        work = 1.0
        for name, usual in self.grows.items():
            value = options.get(name)
            if isinstance(value, bool):
                work *= usual if value else 1.0
            elif isinstance(value, int | float):
                work *= max(float(value), 1.0) / usual
        return work

    def chosen(self, train: Train, options: Mapping[str, Any]) -> dict[str, Any]:
        """Keywords that its verb is run with: defaults, those that follow from the train, and options.

        Raises
        ------
        ModelError : an option that it does not have, or what the train lacks.
        """
        for key, value in options.items():
            allowed_names = (*self.keywords(), *(["show"] if self.views else []))
            if key not in allowed_names:
                allowed = ", ".join(allowed_names) or "none"
                raise ModelError("no such option", path=f"{self.name}.{key}", given=value, allowed=allowed)
        chosen = {**self.defaults, **(self.search(train) if self.search else {}), **options}
        return {key: value for key, value in chosen.items() if key != "show"}

    def run(
        self, source: Source, overrides: Mapping[str, object], options: Mapping[str, Any], progress: Progress
    ) -> tuple[PageFrame, xr.Dataset]:
        """Frame and Dataset; progress is called with the share done, below 1 while it runs, and may raise to end it.

        Raises
        ------
        ModelError : an option that it does not have.  ModelError, ConvergenceError : as its verb.
        """
        from ...verbs.record import verbs

        begin, end = self.counted

        def computed(done: float, of: float = 1.0) -> None:
            progress(begin + (end - begin) * min(1.0, done / max(of, 1e-300)) if done > 0 else 0.0)

        progress(0.0)
        train = load(source, dict(overrides))
        keywords = self.chosen(train, options)
        run = verbs()[self.verb].run
        if "progress" in signature(run).parameters:
            keywords["progress"] = computed
        whole = {**overrides, **self.overrides}
        result = run(source, overrides=whole, **keywords)
        progress(end)
        others = []
        for place, verb in enumerate(self.beside, 1):
            others.append(verbs()[verb].run(source, overrides=whole))
            progress(end + place / len(self.beside) * (_BESIDE - end))
        return self.shown(result, train, options, *others), result

    def shown(self, result: xr.Dataset, train: Train, options: Mapping[str, Any], *others: xr.Dataset) -> PageFrame:
        """What the page shows of a result and those beside it."""
        if self.frame is not None:
            return self.frame(result, train, options, *others)
        return found_frame(self, result, self.draw(result, train, options))


def job_keywords(name: str, source: Source, overrides: Mapping[str, object], options: Mapping[str, Any]) -> Any:
    """Keywords of the verb of a job, as of `JobKind.chosen`, of a model."""
    return JOBS[name].chosen(load(source, dict(overrides)), options)


def _relief_search(train: Train) -> Mapping[str, Any]:
    """Keywords of the verb `relief` for the pair that bends most: bounds about its first estimate."""
    from .answers import relief_estimate

    largest = relief_estimate(train)
    if largest is None:
        raise ModelError("no tooth is loaded", path="operation.torque", allowed="face widths, and a torque of a member")
    high, (short, long) = _AMOUNTS * largest.amount * 1e6, (share * largest.module * 1e3 for share in _LENGTHS)
    pair = largest.pair.rpartition(".")[2]
    return {
        "mesh": pair if len(train.planets) == 1 else next(m.name for m in train.meshes if m.pair == largest.pair),
        "vary": {"tip_relief.amount": f"0..{high:.3g} um", "tip_relief.length": f"{short:.3g}..{long:.3g} mm"},
    }


def detune_frame(result: xr.Dataset, train: Train) -> PageFrame:
    """Distance of the resonance from operation with every change; the answer with the first of them."""
    drawn = bars("away from operation then [%]", result["change"].values.tolist(), 100 * result["moved_away"].values)
    (finding,) = findings_of({"detune": result})
    found, axis, text = json.loads(result.attrs["resonance"]), speed_axis(train), f"{finding.text} {finding.change}"
    answers = []
    if found:
        answer = Answer(
            "resonance",
            text,
            figure=per_cent(abs(float(found["speed"]) - 1)),
            level=LEVELS[finding.tone],
            evidence="sweep",
            job="detune",
            mode=int(found["mode"]),
            speed=None if axis is None else float(found["speed"]) * axis[1],
            changes=() if finding.tone == "good" else changes_of(result, axis),
        )
        answers.append(answer)
    return job_frame("detune", "What moves a resonance away", text.strip(), drawn, answers=answers)


_KINDS = (
    JobKind(
        name="contact",
        label="Contact",
        purpose="Load over the flanks and loaded transmission error",
        about="Loaded teeth of the first mesh at 50, 100 and 125 % of the operating load.",
        quick=True,
        effort=(7, 7),
        options=("mesh", "loads", "samples", "slices", "tolerance"),
        views=_VIEWS,
        defaults={"loads": (0.5, 1.0, 1.25)},
        search=lambda train: {"mesh": first_mesh(train)},
        draw=tooth_contact,
    ),
    JobKind(
        name="stiffness",
        label="Stiffness",
        purpose="Mesh stiffness over a mesh cycle, and the phases of the meshes",
        about="Mesh stiffness of every mesh over one mesh cycle, each with its phase.",
        quick=True,
        effort=(0.4, 0.4),
        options=("samples",),
        draw=mesh_stiffness,
    ),
    JobKind(
        name="steady",
        label="Transmission error",
        purpose="Transmission error of meshes and shafts in steady vibration",
        about="Transmission error of every mesh over a mesh cycle at the operating speed, with its largest lines.",
        quick=True,
        effort=(1, 4),
        options=("relative_speed", "contact_loss"),
        views=_ERRORS,
        frame=steady_frame,
    ),
    JobKind(
        name="output",
        label="Output",
        purpose="Stiffness, lost motion and kinematic error at a shaft, the others locked",
        about="The gearbox at its output: angle over torque, stiffness, lost motion, kinematic error, inertia.",
        quick=True,
        effort=(5, 5),
        options=("shaft", "rated", "share", "samples"),
        draw=angle_over_torque,
    ),
    JobKind(
        name="life",
        label="Bearings",
        purpose="Life and load zones of the bearings that are stated by their parts",
        about="Life of every rolling bearing under the forces over the turns of all bodies.",
        quick=True,
        effort=(15, 15),
        grows={"instants": 256},
        options=("forces", "instants", "changes"),
        views=_BEARINGS,
        draw=bearing_lives,
    ),
    JobKind(
        name="cases",
        label="Load cases",
        purpose="Every load case of the model beside the others",
        about="Load sharing, resonances and operation of every load case, side by side.",
        quick=True,
        effort=(20, 20),
        counted=(0.05, 0.3),
        options=("samples",),
        runs="sharing",
        defaults={"method": "static"},
        overrides={"case": ALL_CASES},
        beside=("modes", "check"),
        frame=lambda result, train, options, *others: cases_frame(result, others),
    ),
    JobKind(
        name="relief",
        label="Relief",
        purpose="Tip relief for the least transmission error",
        about="Tip relief with the least transmission error at 75 and 100 % load, 12 candidates, 8 generations.",
        effort=(12, 12),
        grows={"population": _POPULATION, "generations": _GENERATIONS},
        options=("mesh", "vary", "objectives", "loads", "population", "generations"),
        defaults={"loads": _LOADS, "population": _POPULATION, "generations": _GENERATIONS},
        search=_relief_search,
        frame=lambda result, train, options: relief_frame(result, train),
    ),
    JobKind(
        name="tolerance",
        label="Tolerance",
        purpose="Load sharing within the tolerances, and what each of them counts",
        about="K_gamma of 16384 trains drawn from the tolerances, and what a tenth less of each takes off it.",
        effort=(30, 30),
        grows={"samples": 16_384},
        options=("samples", "seed"),
        defaults={"samples": 16_384, "effects": "shares"},
        frame=lambda result, train, options: tolerance_frame(result, train),
    ),
    JobKind(
        name="contact_loss",
        label="Contact loss",
        purpose="Sweep in which teeth may part",
        about="Run-up and coast-down over 60 speeds and the resonances, teeth part and touch again, no shaft orders.",
        effort=(20, 55),
        grows={"points": 60, "shaft_orders": 20},
        counted=(0.6, 0.95),
        options=("points", "start", "stop", "shaft_orders", "shaft_tones", "unstable"),
        runs="sweep",
        defaults={"contact_loss": True, "points": 60, "shaft_orders": False},
        draw=contact_loss,
    ),
    JobKind(
        name="transient",
        label="Transient",
        purpose="Run in time, as the model's scenario or at its speed",
        about="50 mesh cycles from the equilibrium at the operating speed, teeth that part.",
        effort=(3, 3),
        grows={"cycles": 50, "samples": 32},
        options=("cycles", "start", "stop", "torque_step", "torque_ramp", "samples"),
        defaults={"cycles": 50.0},
        draw=forces_over_time,
    ),
    JobKind(
        name="detune",
        label="Detune",
        purpose="Changes of the drawing that move a resonance away from operation",
        about="Changes that move the strongest resonance near operation out of its band, each computed again.",
        effort=(6, 6),
        options=("mode", "order", "band", "changes"),
        frame=lambda result, train, options: detune_frame(result, train),
    ),
    JobKind(
        name="sensitivity",
        label="Sensitivity",
        purpose="What the natural frequencies depend on",
        about="Per cent of the lowest natural frequency per per cent of each number of the model.",
        effort=(25, 25),
        options=("of", "mode", "mesh", "harmonic"),
        draw=ranked_numbers,
    ),
)
JOBS: Mapping[str, JobKind] = {kind.name: kind for kind in _KINDS}
"""Name -> job, in the order of the page."""
