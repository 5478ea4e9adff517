"""Datasets -> one self-contained HTML page that opens offline: warnings, key figures, figures, tables, provenance."""

from __future__ import annotations

import json
import logging
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from plotly.offline import get_plotlyjs

from ..results.whole_file import write_text
from . import figures as plots
from .figures import tables
from .figures.curves import drawable
from .figures.frequencies import groups, mesh_tones
from .figures.members import members_of
from .figures.series import engineering, short_names
from .figures.sharing import worst
from .figures.transient import ramps

__all__ = ["report", "write_report"]

_LOG = logging.getLogger(__name__)
_CONTACT = "Dashed: unstable branches. Large marks: motions that take the place of an unstable one. Circles: folds."
_KNOWN = (
    *("check", "modes", "campbell", "stiffness", "static", "steady", "sharing"),
    *("sweep", "contact_sweep", "modulation", "transient", "sensitivity", "track", "contact"),
    *("train_contact", "relief"),
)
Datasets = Mapping[str, xr.Dataset]


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """One part of the page.  anchor : its id.  title : in the list of contents.  body : HTML."""

    anchor: str
    title: str
    body: str


def report(datasets: Datasets, *, title: str = "", figures: Mapping[str, go.Figure] | None = None) -> str:
    """One HTML page with everything that the Datasets say; needs nothing from outside.

    Parameters
    ----------
    datasets : by name: check, modes, campbell, stiffness, static, steady, sharing, sweep, each where there is one;
        any other name is a study, whose Dataset has a variable over one parameter.
    title : of the page, that of the train where not said.  figures : further figures, by title.
    """
    name = title or _attribute(datasets, "title") or "Epicyclic gear train"
    sections = [section for section in _sections(datasets, figures or {}) if section.body]
    links = "".join(f'<a href="#{one.anchor}">{escape(one.title)}</a>' for one in sections)
    parts = "".join(f'<section id="{one.anchor}"><h2>{escape(one.title)}</h2>{one.body}</section>' for one in sections)
    doi = _attribute(datasets, "doi")
    source = f"<p>Source: doi {escape(doi)}</p>" if doi else ""
    head = (
        f'<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{escape(name)}</title><link rel="icon" href="data:,"><style>{_style()}</style>'
        f"<script>{get_plotlyjs()}</script>"
    )
    return (
        f'<!DOCTYPE html><html lang="en"><head>{head}</head><body>'
        f'<nav aria-label="Contents"><strong>epicyclic</strong>{links}</nav>'
        f"<main><header><h1>{escape(name)}</h1>{source}</header>{_warnings(datasets)}{_keys(datasets)}{parts}</main>"
        "</body></html>"
    )


def write_report(
    path: str | Path, datasets: Datasets, *, title: str = "", figures: Mapping[str, go.Figure] | None = None
) -> Path:
    """Write the page; the file appears whole or not at all.

    Raises
    ------
    ModelError : the file cannot be written.
    """
    write_text(path, report(datasets, title=title, figures=figures))
    return Path(path)


def _style() -> str:
    return files(__package__).joinpath("report.css").read_text(encoding="utf-8")


def _attribute(datasets: Datasets, name: str) -> str:
    return next((str(data.attrs[name]) for data in datasets.values() if data.attrs.get(name)), "")


def _sections(datasets: Datasets, figures: Mapping[str, go.Figure]) -> Iterable[Section]:
    check, modes = datasets.get("check"), datasets.get("modes")
    if check is not None:
        yield Section(anchor="train", title="Train", body=_train(check))
        yield Section(anchor="operation", title="Speeds and torques", body=_operation(check))
        yield Section(anchor="meshes", title="Meshes", body=_meshes(check, datasets.get("stiffness")))
    elif "stiffness" in datasets:
        body = _figure("stiffness", plots.mesh_stiffness(datasets["stiffness"]))
        yield Section(anchor="meshes", title="Meshes", body=body)
    if modes is not None or "campbell" in datasets:
        body = _modes(check, modes, datasets.get("campbell"))
        yield Section(anchor="modes", title="Vibration modes", body=body)
    for verb, name in (("static", "Static forces"), ("steady", "Steady response")):
        if verb in datasets and "mesh_force" in datasets[verb].variables:
            body = _figure(f"{verb}-forces", plots.mesh_forces(datasets[verb]))
            if "mesh_force_most" in datasets[verb].variables:
                body += _figure(f"{verb}-range", plots.force_envelopes(datasets[verb]))
            yield Section(anchor=verb, title=name, body=body)
    if "sharing" in datasets:
        yield Section(anchor="sharing", title="Load sharing", body=_sharing(datasets["sharing"]))
    if "sweep" in datasets:
        yield Section(anchor="sweep", title="Speed sweep", body=_sweep(datasets["sweep"], modes))
    if "sensitivity" in datasets:
        yield Section(anchor="sensitivity", title="Sensitivity", body=_sensitivity(datasets["sensitivity"]))
    if "track" in datasets:
        caption = "Thick: double roots. Shapes that share nothing cross; coupled ones veer and exchange their motion."
        yield Section(
            anchor="track", title="Modes followed", body=_figure("track", plots.loci(datasets["track"]), caption)
        )
    if "contact_sweep" in datasets:
        drawn = _figure("contact-sweep", plots.contact_sweep(datasets["contact_sweep"]), _CONTACT)
        yield Section(anchor="contact-sweep", title="Speed sweep with contact loss", body=drawn)
    if "modulation" in datasets:
        body = _figure("modulation", plots.modulation(datasets["modulation"]))
        yield Section(anchor="modulation", title="Vibration at the ring", body=body)
    if "transient" in datasets:
        yield Section(anchor="transient", title="Motion over time", body=_transient(datasets["transient"]))
    if "contact" in datasets:
        teeth = datasets["contact"]
        body = _figure("flanks", plots.contact_map(teeth)) + _figure("contact", plots.contact_curves(teeth))
        yield Section(anchor="contact", title="Teeth in contact", body=body)
    if "relief" in datasets:
        found = datasets["relief"]
        body = _figure("relief", plots.relief_search(found)) + _figure("relief-effect", plots.relief_effect(found))
        yield Section(anchor="relief", title="Relief", body=body)
    if "train_contact" in datasets:
        train = datasets["train_contact"]
        body = _figure("faces", plots.face_loads(train)) + _figure("factors", plots.load_factors(train))
        yield Section(anchor="train_contact", title="Teeth in contact in the train", body=body)
    yield Section(anchor="studies", title="Studies", body=_studies(datasets, figures))
    yield Section(anchor="model", title="Model and provenance", body=_provenance(datasets))


def _figure(anchor: str, drawn: go.Figure, caption: str = "") -> str:
    """A figure as HTML that draws itself with the page's own plotly.js."""
    html = drawn.to_html(
        full_html=False,
        include_plotlyjs=False,
        div_id=f"figure-{anchor}",
        auto_play=False,
        default_width="100%",
        default_height=f"{drawn.layout.height or 420}px",
        config={"responsive": True, "displaylogo": False},
    )
    words = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return f"<figure>{html}{words}</figure>"


def _train(check: xr.Dataset) -> str:
    if "gear" not in check.dims or not check.sizes["gear"]:
        return ""
    front = _figure("front", plots.train_front(check), "Seen from the right end; teeth as they stand at time zero.")
    section = _figure("section", plots.train_section(check), "Half section, branch 1 turned into the plane.")
    drawings = front + section if check.sizes.get("stage", 1) > 1 else f'<div class="pair">{front}{section}</div>'
    return drawings + tables.stage_table(check) + tables.gear_table(check)


def _operation(check: xr.Dataset) -> str:
    known = np.isfinite(check["speed"].values).any() or np.isfinite(check["torque"].values).any()
    bars = _figure("members", plots.members(check), "Counter-clockwise positive; power into the train positive.")
    lines = _figure("orders", plots.orders(check)) if check.sizes.get("order_name", 0) else ""
    return (bars if known else "") + tables.member_table(check) + lines


def _meshes(check: xr.Dataset, stiffness: xr.Dataset | None) -> str:
    dials = ""
    if "phase_lead" in check.variables and np.isfinite(check["phase_lead"].values).any():
        caption = "One turn of a dial is one mesh cycle; a branch that points clockwise of another meshes earlier."
        dials = _figure("phases", plots.phases(check), caption)
    curves = "" if stiffness is None else _figure("stiffness", plots.mesh_stiffness(stiffness))
    return dials + curves + tables.mesh_table(check, stiffness)


def _modes(check: xr.Dataset | None, modes: xr.Dataset | None, campbell: xr.Dataset | None) -> str:
    parts = []
    if modes is not None:
        parts.append(_figure("frequencies", plots.frequencies(modes, check), "×2, ×3: so many modes at one frequency."))
        if check is not None and "full_shape" in modes.variables:
            caption = "Move the slider to a mode and it swings; grey is the place at rest."
            parts.append(_figure("shapes", plots.mode_shapes(check, modes), caption))
        if "strain_energy_share" in modes.variables and "kinetic_energy_share" in modes.variables:
            parts.append(_figure("energy", plots.energy_shares(modes), "Branches and sides added up."))
    if campbell is not None:
        parts.append(_figure("campbell", plots.campbell(campbell)))
    if modes is not None:
        parts.append(f"<details><summary>All modes</summary>{tables.mode_table(modes)}</details>")
    return "".join(parts)


def _sharing(sharing: xr.Dataset) -> str:
    parts = []
    if "load_sharing" in sharing.variables:
        parts.append(_figure("sharing", plots.load_sharing(sharing), "1: every branch carries the same."))
        parts.append(tables.sharing_table(sharing))
    if "load_sharing_history" in sharing.variables:
        parts.append(_figure("history", plots.load_history(sharing)))
    if "mesh_force" in sharing.variables:
        parts.append(_figure("forces", plots.mesh_forces(sharing)))
    return "".join(parts)


def _sweep(sweep: xr.Dataset, modes: xr.Dataset | None) -> str:
    parts = [
        _figure("sweep", plots.speed_sweep(sweep, modes), "Dotted: natural frequencies in the colour of their kind.")
    ]
    if "mesh_force_order" in sweep.variables:
        caption = (
            "The largest amplitude of all meshes; a resonance is where a line crosses a natural frequency and glows."
        )
        parts.append(_figure("waterfall", plots.waterfall(sweep, modes), caption))
    if "bearing_force_peak" in sweep.variables:
        parts.append(
            _figure(
                "bearings",
                plots.bearing_forces(sweep, modes),
                "Length of the lateral force of a link; links that carry the same share a curve.",
            )
        )
    return "".join(parts)


def _transient(result: xr.Dataset) -> str:
    forces = _figure("transient", plots.transient_forces(result), "Left and right drawn once where they coincide.")
    if not ramps(result):
        return forces
    caption = "Dotted: multiples of the mesh frequency; where one is dark it passes a natural frequency."
    return forces + _figure("spectrogram", plots.spectrogram(result), caption)


def _sensitivity(data: xr.Dataset) -> str:
    caption = "What 1 % more of each number of the model does; a bar between two values: a repeated root splits."
    return _figure("sensitivity", plots.tornado(data), caption)


def _studies(datasets: Datasets, figures: Mapping[str, go.Figure]) -> str:
    drawn = [(name, plots.study(data)) for name, data in datasets.items() if _is_study(name, data)]
    every = [*drawn, *figures.items()]
    return "".join(_figure(f"study-{place}", figure) for place, (_, figure) in enumerate(every, start=1))


def _is_study(name: str, data: xr.Dataset) -> bool:
    return name not in _KNOWN and drawable(data)


def _listed(data: xr.Dataset, name: str) -> list[str]:
    try:
        found = json.loads(str(data.attrs.get(name, "[]")))
    except json.JSONDecodeError:
        _LOG.warning("attribute %s is not JSON", name)
        return []
    return [str(one) for one in found]


def _warnings(datasets: Datasets) -> str:
    found = dict.fromkeys(text for data in datasets.values() for text in _listed(data, "warnings"))
    if not found:
        return '<div class="warnings calm" role="note">No warnings.</div>'
    items = "".join(f"<li>{escape(text)}</li>" for text in found)
    return f'<div class="warnings" role="alert"><b>Warnings</b><ul>{items}</ul></div>'


def _keys(datasets: Datasets) -> str:
    """The figures one looks for first."""
    cards = "".join(
        f'<div class="key"><b>{escape(value)}</b><span>{escape(words)}</span></div>'
        for value, words in _key_figures(datasets)
    )
    return f'<div class="keys">{cards}</div>' if cards else ""


def _key_figures(datasets: Datasets) -> list[tuple[str, str]]:
    found: list[tuple[str, str]] = []
    check, modes, sharing, sweep = (datasets.get(name) for name in ("check", "modes", "sharing", "sweep"))
    if check is not None:
        powers = [one.power for one in members_of(check) if np.isfinite(one.power) and one.power > 0]
        found += [(f"{engineering(sum(powers) / 1e3)} kW", "power through the train")] if powers else []
        found += [(f"{engineering(tone)} Hz", f"mesh frequency, {stage}") for stage, tone in mesh_tones(check).items()]
    if modes is not None:
        elastic = [one for one in groups(modes) if one.frequency > 1e-3]
        found += [(f"{engineering(one.frequency)} Hz", f"lowest natural frequency, {one.kind}") for one in elastic[:1]]
    if sharing is not None and "load_sharing" in sharing.variables:
        rows = worst(sharing)
        shown = dict.fromkeys([*rows[:1], *sorted(rows, key=lambda row: -row[1])[:1]])
        found += [(f"{value:.3f}", f"load sharing, {name}: {_tied(mesh)}") for name, value, mesh in shown]
    if sweep is not None and np.isfinite(sweep["mesh_force_rms"].values).any():
        found.append(_resonance(sweep))
    return found


def _tied(mesh: str) -> str:
    """Short name of a mesh that does not break over a line."""
    return short_names([mesh])[0].replace(" ", "\u00a0").replace("-", "\u2011")


def _resonance(sweep: xr.Dataset) -> tuple[str, str]:
    rms = sweep["mesh_force_rms"].transpose("mesh", "speed").values
    mesh, at = np.unravel_index(int(np.nanargmax(rms)), rms.shape)
    hertz = float(np.ravel(sweep["mesh_frequency"].values)[at]) if "mesh_frequency" in sweep.variables else np.nan
    name = _tied(str(sweep["mesh"].values[mesh]))
    return f"{engineering(float(rms[mesh, at]) / 1e3)} kN", f"largest RMS mesh force: {name}, {engineering(hertz)} Hz"


def _provenance(datasets: Datasets) -> str:
    assumed, values, model = (_attribute(datasets, name) for name in ("assumed", "values", "model"))
    parts = []
    if assumed and assumed != "{}":
        parts.append(f"<h3>Assumed values</h3>{tables.record_table(assumed, ['value', 'why'])}")
    parts.append(tables.table(["analysis", "options", "package", "version"], _runs(datasets), caption="", words=4))
    if values and values != "[]":
        parts.append(f"<details><summary>Every resolved value</summary>{tables.value_table(values)}</details>")
    if model:
        parts.append(f"<details><summary>Resolved model</summary><pre>{escape(_indented(model))}</pre></details>")
    return "".join(parts)


def _runs(datasets: Datasets) -> list[list[str]]:
    return [
        [
            name,
            _options(data),
            str(data.attrs.get("package", "")),
            str(data.attrs.get("version", "")),
        ]
        for name, data in datasets.items()
    ]


def _options(data: xr.Dataset) -> str:
    try:
        found = json.loads(str(data.attrs.get("options", "{}")))
    except json.JSONDecodeError:
        return str(data.attrs["options"])
    return "; ".join(f"{key}: {_plainly(value)}" for key, value in found.items())


def _plainly(value: object) -> str:
    text = json.dumps(value) if isinstance(value, list | dict) else str(value)
    return text if len(text) <= 120 else f"{text[:117]}..."


def _indented(text: str) -> str:
    try:
        return json.dumps(json.loads(text), indent=2, ensure_ascii=False)
    except json.JSONDecodeError:
        return text
