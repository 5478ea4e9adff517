"""Jobs of the page: what takes longer than a lever waits, each with its defaults and its result as said and drawn.

The server reads their table and runs none: `answers` is imported where it is used, half a second of its start.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from inspect import Parameter, signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...document.tables import PlainTable
from ...errors import ModelError
from ...options import Option
from ...results.dataset import ranked
from ...show.series import judged_quantile, scattering_pair
from ...show.views import findings_of
from ...system.tooth_pairs import first_mesh
from ...train.resolution import load
from ...train.train import Train
from ..state.frames import LEVELS, Answer, PageFrame, force_unit, mesh_labels, number, per_cent

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

# Curves that are drawn strong: more are not told apart.
_STRONG = 4
# Points of a curve that are sent: some for each pixel of the pane.
_POINTS = 1200


class Drawn(NamedTuple):
    """What a job draws.  head : ``lines`` or ``bars`` of its head.

    arrays : ``job/x`` (n,) and ``job/y`` (curve, n), or ``job/bar`` (row,).
    """

    head: Mapping[str, Any]
    arrays: Mapping[str, NDArray[np.float32]]


def lines(x_label: str, y_label: str, x: Array, curves: Mapping[str, Array]) -> Drawn:
    """Curves (n,) over x (n,) by label; those with the largest values strong, thinned to what a pane shows."""
    labels = list(curves)
    y = np.array([np.asarray(curves[label], dtype=float) for label in labels]).reshape(len(labels), -1)
    every = max(1, -(-len(x) // _POINTS))
    most = np.max(np.where(np.isfinite(y), y, -np.inf), axis=1, initial=-np.inf)
    first = set(ranked(most)[:_STRONG].tolist())
    rows = [{"label": label, "strong": row in first} for row, label in enumerate(labels)]
    return Drawn(
        {"lines": {"x_label": x_label, "y_label": y_label, "curves": rows}},
        {"job/x": np.asarray(x[::every], np.float32), "job/y": np.asarray(y[:, ::every], np.float32)},
    )


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
) -> PageFrame:
    """The frame of a job that is done, of no state yet; with ``answers`` where it answers a question."""
    job = {"name": name, "title": title, "text": text, **drawn.head}
    job |= {"apply": dict(apply) if apply else None, "apply_label": apply_label if apply else ""}
    head: dict[str, Any] = {"job": job}
    if answers:
        head["answers"] = [asdict(answer) for answer in answers]
    return PageFrame(rev=0, kind="job", head=head, arrays=drawn.arrays)


def _said(result: xr.Dataset) -> str:
    """The findings of a result, as terminal and report say them."""
    return " ".join(finding.text for finding in findings_of({"": result}))


def found_frame(kind: JobKind, result: xr.Dataset, train: Train) -> PageFrame:
    """What any result shows: its findings, its first variable, and the first finding as the answer of its question."""
    findings = findings_of({kind.name: result})
    answers = []
    if kind.question and findings:
        first = findings[0]
        value, limit = ("" if np.isnan(one) else number(one, 4) for one in (first.value, first.limit))
        text = f"{first.text} {first.change}".strip()
        level = LEVELS[first.tone]
        answers.append(
            Answer(kind.question, text, figure=value, limit=limit, level=level, evidence=kind.name, job=kind.name)
        )
    return job_frame(kind.name, kind.label, _said(result), _first_variable(result, train), answers=answers)


def _first_variable(result: xr.Dataset, train: Train) -> Drawn:
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


_DRAW = "Draw this relief"


def relief_frame(result: xr.Dataset) -> PageFrame:
    """Transmission error over the mesh cycle before and after; the answer on relief, and the overrides that draw it."""
    mean = result["relieved_error"].transpose("state", "relieved_mesh", "load_factor", "mesh_phase")
    load = int(np.abs(result["load_factor"].values - 1).argmin())
    error = 1e6 * mean.values[:, 0, load]
    curves = {"after": error[1] - error[1].mean(), "before": error[0] - error[0].mean()}
    drawn = lines("mesh cycle [1]", "error about its mean [µm]", result["mesh_phase"].values, curves)
    (finding,) = findings_of({"relief": result})
    overrides = json.loads(str(result.attrs["overrides"])) if finding.tone != "good" else {}
    answer = Answer(
        "relief",
        f"{finding.text} {finding.change}".strip(),
        then=str(result["solution_text"].values[int(result.attrs["picked"]), 0]).replace("um", "µm"),
        level=LEVELS[finding.tone],
        apply=overrides,
        apply_label=_DRAW,
        evidence="relief",
        job="relief",
    )
    return job_frame("relief", "Tip relief", finding.text, drawn, apply=overrides, apply_label=_DRAW, answers=[answer])


# Rows of bars that are read, and seen without scrolling.
_MOST = 10
# Share of the variance of K_gamma from which one tolerance is the one to talk about; part of the largest share from
# which the next one is named beside it: the draws do not tell them apart.
_HALF, _AS_LARGE = 0.5, 0.9


def contact_loss_frame(result: xr.Dataset) -> PageFrame:
    """Largest and least force of any mesh over speed, run-up and coast-down."""
    relative = np.asarray(result["speed"].values, dtype=float)
    peak = result["mesh_force_peak"].transpose("direction", "mesh", "speed").values
    least = result["mesh_force_minimum"].transpose("direction", "mesh", "speed").values
    unit, scale = force_unit(float(np.nanmax(np.abs(peak), initial=0.0)))
    with np.errstate(all="ignore"):
        up, down, low = np.nanmax(peak[0], axis=0), np.nanmax(peak[-1], axis=0), np.nanmin(least[0], axis=0)
    curves = {
        "largest, run-up": up * scale,
        "largest, coast-down": down * scale,
        "least, run-up": low * scale,
    }
    drawn = lines("speed [% of operation]", f"mesh force [{unit}]", 100 * relative, curves)
    return job_frame("contact_loss", "Teeth that part", _said(result), drawn)


def _of_meshes(result: xr.Dataset, train: Train, values: Array) -> dict[str, Array]:
    """Curves (m, n) of the meshes of a result by the labels that meshes have on the page."""
    labels = mesh_labels(train)
    return {labels[str(name)]: row for name, row in zip(result["mesh"].values, values, strict=True)}


def transient_frame(result: xr.Dataset, train: Train) -> PageFrame:
    """Forces of all meshes over time."""
    force = result["mesh_force"].transpose("mesh", "time").values
    unit, scale = force_unit(float(np.nanmax(np.abs(force), initial=0.0)))
    time = np.asarray(result["time"].values, dtype=float)
    ms, word = (1e3, "ms") if time[-1] < 1 else (1.0, "s")
    curves = _of_meshes(result, train, scale * force)
    drawn = lines(f"time [{word}]", f"mesh force [{unit}]", ms * time, curves)
    return job_frame("transient", "Motion over time", _said(result), drawn)


_VIEWS = ("transmission error", "load along the face")


def contact_frame(result: xr.Dataset, train: Train, options: Mapping[str, Any]) -> PageFrame:
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
    return job_frame("contact", "Loaded tooth contact", _said(result), drawn)


def stiffness_frame(result: xr.Dataset, train: Train) -> PageFrame:
    """Mesh stiffness over one mesh cycle, each mesh at its phase."""
    history = 1e-9 * result["mesh_stiffness"].transpose("mesh", "mesh_phase").values
    curves = _of_meshes(result, train, history)
    drawn = lines("mesh cycle [1]", "mesh stiffness [N/nm]", result["mesh_phase"].values, curves)
    return job_frame("stiffness", "Mesh stiffness and phases", _said(result), drawn)


def sensitivity_frame(result: xr.Dataset) -> PageFrame:
    """Per cent per per cent of the ranked mode or mesh, the largest first."""
    dim = "mode" if "mode" in result["sensitivity"].dims else "mesh"
    targets = result["ranked_by"].values.astype(bool)
    values = result["sensitivity"].transpose("path", dim).values[:, targets]
    size = np.nan_to_num(np.abs(values)).argmax(axis=1)
    value = np.nan_to_num(values[np.arange(len(values)), size])
    order = ranked(np.abs(value))[:_MOST]
    paths = [str(path) for path in result["path"].values]
    drawn = bars("per cent per per cent", [_short_path(paths[i]) for i in order], value[order])
    return job_frame("sensitivity", "Sensitivity", _said(result), drawn)


def _short_path(path: str) -> str:
    """``sun support radial`` of ``stages.main.sun.support.radial``."""
    words = path.split(".")
    return " ".join(words[2:] if words[0] == "stages" and len(words) > 2 else words).replace("_", " ")


def tolerance_frame(result: xr.Dataset, train: Train) -> PageFrame:
    """Shares of the tolerances in the variance of K_gamma of the pair that scatters most; the answer on errors."""
    from .answers import halved_tolerance

    names = [str(name) for name in result["tolerance"].values]
    total = tolerance_shares(result)
    order = np.argsort(-total, kind="stable")[:_MOST]
    words = [_entry_words(names[i], train) for i in order]
    drawn = bars("total effect in the variance of K_gamma [%]", words, 100 * total[order])
    finding = next(one for one in findings_of({"tolerance": result}) if one.anchor == "tolerances")
    text = f"{finding.text} What is drawn stands in place of the numbers of the model."
    change = halved_tolerance(train, names[order[0]])
    share, alone = float(total[order[0]]), float(tolerance_shares(result, "sobol_first")[order[0]])
    said = (
        f"{100 * share:.0f} % of the variance of K_gamma among trains of this drawing involves the tolerance of "
        f"{words[0]} with its interactions ({100 * alone:.0f} % alone)"
    )
    if len(order) > 1 and total[order[1]] >= _AS_LARGE * share > 0:
        said += f"; {100 * float(total[order[1]]):.0f} % that of {words[1]}"
    answer = Answer(
        "error",
        f"{said}.",
        figure=f"{100 * share:.0f} %",
        level="warn" if share >= _HALF else "good",
        apply=change,
        apply_label="Halve this tolerance",
        evidence="tolerance",
        job="tolerance",
    )
    p, _ = judged_quantile(result)
    then, limit = f"{finding.value:.3f} at {per_cent(p)}", f"{finding.limit:g}"
    planet = Answer(
        "planet",
        finding.text,
        then=then,
        limit=limit,
        level=LEVELS[finding.tone],
        evidence="tolerance",
        job="tolerance",
    )
    return job_frame(
        "tolerance", "Tolerances", text, drawn, apply=change, apply_label="Halve the first", answers=[answer, planet]
    )


def tolerance_shares(result: xr.Dataset, name: str = "sobol_total") -> Array:
    """Shares of the variance of K_gamma (mean-load) (tolerance,) [1], of the pair that scatters most.

    The numbers that the verb `tolerance` prints.  name : ``sobol_total``, with interactions; ``sobol_first``, alone.
    """
    mean_load = result.sel(definition="mean-load")
    pair = scattering_pair(mean_load)
    share: Array = np.nan_to_num(mean_load[name].isel(pair=pair).transpose("tolerance").values)
    return np.clip(share, 0.0, None)


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


@dataclass(frozen=True, slots=True, kw_only=True)
class JobKind:
    """A kind of job.

    name, label, purpose : of the page.  about : what it does by default, in a sentence.  seconds : on ren2021, about; a
        train of several stages or planets may take minutes.
    verb : that it runs.  options : its keywords that may be chosen, all where none are named; a job refuses others.
    defaults : its keywords unless chosen otherwise.  search : those that follow from the train.
    question : of `QUESTIONS`, that the first finding of its result answers.  frame : (result, train, chosen options) ->
    what the page shows; `found_frame` where there is none.  views : what that may draw, as ``show``.
    """

    name: str
    label: str
    purpose: str
    about: str
    seconds: float
    verb: str
    options: tuple[str, ...] = ()
    defaults: Mapping[str, Any] = field(default_factory=dict)
    views: tuple[str, ...] = ()
    search: Callable[[Train], Mapping[str, Any]] | None = None
    question: str = ""
    frame: Callable[[xr.Dataset, Train, Mapping[str, Any]], PageFrame] | None = None

    def keywords(self) -> dict[str, tuple[Parameter, Any, Option]]:
        """Keyword -> parameter, type and option of the verb, of those that may be chosen."""
        from ...verbs.record import keywords, verbs

        known = keywords(verbs()[self.verb].run)
        return {name: known[name] for name in self.options or known}

    def run(
        self, source: Source, overrides: Mapping[str, object], options: Mapping[str, Any], progress: Progress
    ) -> tuple[PageFrame, xr.Dataset]:
        """Frame and Dataset; progress is called with the share done 0..1 or with (done, of), and may raise to end it.

        Raises
        ------
        ModelError : an option that it does not have.  ModelError, ConvergenceError : as its verb.
        """
        for key, value in options.items():
            allowed_names = (*self.keywords(), *(["show"] if self.views else []))
            if key not in allowed_names:
                allowed = ", ".join(allowed_names) or "none"
                raise ModelError("no such option", path=f"{self.name}.{key}", given=value, allowed=allowed)
        from ...verbs.record import verbs

        train = load(source, dict(overrides))
        chosen = {**self.defaults, **(self.search(train) if self.search else {}), **options}
        keywords = {key: value for key, value in chosen.items() if key != "show"}
        run = verbs()[self.verb].run
        if "progress" in signature(run).parameters:
            keywords["progress"] = progress
        else:
            progress(0.05)
        result = run(source, overrides=dict(overrides), **keywords)
        return self.frame(result, train, chosen) if self.frame else found_frame(self, result, train), result


def _relief_search(train: Train) -> Mapping[str, Any]:
    """Keywords of the verb `relief` for the pair that bends most: bounds about its first estimate."""
    from .answers import estimates_of

    estimates = estimates_of(train)
    if not estimates:
        raise ModelError("no tooth is loaded", path="operation.torque", allowed="face widths, and a torque of a member")
    largest = max(estimates, key=lambda estimate: estimate.amount)
    high, (short, long) = _AMOUNTS * largest.amount * 1e6, (share * largest.module * 1e3 for share in _LENGTHS)
    pair = largest.pair.rpartition(".")[2]
    return {
        "mesh": pair if len(train.planets) == 1 else next(m.name for m in train.meshes if m.pair == largest.pair),
        "vary": {"tip_relief.amount": f"0..{high:.3g} um", "tip_relief.length": f"{short:.3g}..{long:.3g} mm"},
    }


_KINDS = (
    JobKind(
        name="contact",
        label="Contact, LTE",
        purpose="Load over the flanks and loaded transmission error",
        about="Loaded teeth of the first mesh at 50, 100 and 125 % of the operating load.",
        seconds=0.5,
        options=("mesh", "loads", "samples", "slices", "tolerance"),
        views=_VIEWS,
        verb="contact",
        defaults={"loads": (0.5, 1.0, 1.25)},
        search=lambda train: {"mesh": first_mesh(train)},
        frame=contact_frame,
    ),
    JobKind(
        name="relief",
        label="Relief",
        purpose="Tip relief for the least transmission error",
        about="Tip relief with the least transmission error at 75 and 100 % load, 12 candidates, 8 generations.",
        seconds=3,
        options=("mesh", "vary", "objectives", "loads", "population", "generations"),
        verb="relief",
        defaults={"loads": _LOADS, "population": _POPULATION, "generations": _GENERATIONS},
        search=_relief_search,
        frame=lambda result, train, options: relief_frame(result),
    ),
    JobKind(
        name="stiffness",
        label="Stiffness",
        purpose="Mesh stiffness over a mesh cycle, and the phases of the meshes",
        about="Mesh stiffness of every mesh over one mesh cycle, each with its phase.",
        seconds=0.1,
        options=("samples",),
        verb="stiffness",
        frame=lambda result, train, options: stiffness_frame(result, train),
    ),
    JobKind(
        name="tolerance",
        label="Tolerance",
        purpose="Load sharing within the tolerances, and the share of each",
        about="K_gamma of 16384 trains drawn from the tolerances, and the share of each tolerance in its variance.",
        seconds=1,
        options=("samples", "limit", "seed"),
        verb="tolerance",
        defaults={"samples": 16_384, "effects": "shares"},
        frame=lambda result, train, options: tolerance_frame(result, train),
    ),
    JobKind(
        name="contact_loss",
        label="Contact loss",
        purpose="Sweep in which teeth may part",
        about="Run-up and coast-down over 60 speeds and the resonances, teeth part and touch again, no shaft orders.",
        seconds=2,
        options=("points", "start", "stop", "shaft_orders", "shaft_tones", "unstable"),
        verb="sweep",
        defaults={"contact_loss": True, "points": 60, "shaft_orders": False},
        frame=lambda result, train, options: contact_loss_frame(result),
    ),
    JobKind(
        name="transient",
        label="Transient",
        purpose="Run in time, as the model's scenario or at its speed",
        about="50 mesh cycles from the equilibrium at the operating speed, teeth that part.",
        seconds=1,
        options=("cycles", "start", "stop", "torque_step", "torque_ramp", "samples"),
        verb="transient",
        defaults={"cycles": 50.0},
        frame=lambda result, train, options: transient_frame(result, train),
    ),
    JobKind(
        name="sensitivity",
        label="Sensitivity",
        purpose="What the natural frequencies depend on",
        about="Per cent of the lowest natural frequency per per cent of each number of the model.",
        seconds=2,
        options=("of", "mode", "mesh", "harmonic"),
        verb="sensitivity",
        frame=lambda result, train, options: sensitivity_frame(result),
    ),
)
JOBS: Mapping[str, JobKind] = {kind.name: kind for kind in _KINDS}
"""Name -> job, in the order of the page."""
