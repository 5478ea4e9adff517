"""Views of `modes` and `campbell`: frequencies, shapes and energies of the modes, at one speed and over it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...limits import NO_MATTER, RESONANCE_BAND, TEETH_PART, ResonanceVerdict
from ...results.dataset import EQUAL, ranked
from ...show.elements import Company, Details, Drawing, Finding, KeyFigure, Listing, Part, Section, Table, named_columns
from ...show.series import engineering, mode_groups, numbers, stage_count, summed_shares, texts, unbroken
from ...show.views import ResultView

# --- modes -----------------------------------------------------------------------------------------------------------

_ON_IT = 0.01  # a resonance this close is met by operation itself, per operating speed
# Rows of resonances: a screen of a terminal, a screen of a page, folded away in a page, on its first page.
_IN_TERMINAL, _IN_PAGE, _FOLDED, _IN_FRONT = 40, 25, 200, 8


def modes_tables(result: xr.Dataset) -> Sequence[Table]:
    """Every mode: frequency, kind, multiplicity, damping, and what holds most of its energies, branches added up."""
    columns: dict[str, Any] = {
        "mode": list(range(1, result.sizes["mode"] + 1)),
        "frequency [Hz]": list(numbers(result, "frequency")),
        "kind": texts(result, "mode_kind", "mode"),
        "multiplicity": [int(count) for count in np.nan_to_num(numbers(result, "multiplicity", "mode"), nan=1.0)],
        "damping [-]": list(numbers(result, "damping_ratio", "mode")),
        "most strain energy": _most(result, "strain_energy_share", "connection"),
        "most kinetic energy": _most(result, "kinetic_energy_share", "body"),
    }
    found = [Table(title="Modes", columns=columns)]
    if result.sizes.get("resonance", 0):
        every = np.arange(result.sizes["resonance"])
        found.append(_resonances(result, every, f"Resonances, {_range(result)}", _IN_TERMINAL))
    elif "resonance_mode" in result.variables:
        found.append(Table(title=f"No mesh order meets a mode, {_range(result)}", columns={}))
    return found


def modes_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Frequencies, moving shapes, energies, the Campbell diagram where there is one, and all modes as a table."""
    from ...show.charts.mode_shapes import mode_shapes
    from ...show.charts.modes import campbell, energy_shares, frequencies

    check = company.get("check")
    words = "×2, ×3: so many modes at one frequency."
    parts: list[Part] = [Drawing(anchor="frequencies", figure=frequencies(result, check), caption=words)]
    if check is not None and "full_shape" in result.variables:
        words = "Move the slider to a mode and it swings; grey is the place at rest."
        parts.append(Drawing(anchor="shapes", figure=mode_shapes(check, result), caption=words))
    if "strain_energy_share" in result.variables and "kinetic_energy_share" in result.variables:
        words = "Branches and sides added up."
        parts.append(Drawing(anchor="energy", figure=energy_shares(result), caption=words))
    if "campbell" in company:
        parts.append(Drawing(anchor="campbell", figure=campbell(company["campbell"])))
    parts.append(Details(summary="All modes", parts=modes_tables(result)[:1]))
    found = [Section(anchor="modes", title="Vibration modes", parts=parts)]
    if result.sizes.get("resonance", 0):
        found.append(Section(anchor="resonances", title="Resonances near operation", parts=_near_operation(result)))
    return found


def modes_key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """The lowest natural frequency [Hz], with how many there are; the strongest resonance near operation [%]."""
    elastic = [one for one in mode_groups(result) if one.frequency > 1e-3]
    if not elastic:
        return []
    first, last = elastic[0], elastic[-1]
    count = sum(one.multiplicity for one in elastic)
    words = f"lowest natural frequency, {first.kind}; {count} in all, up to {engineering(last.frequency)} Hz"
    found = [(f"{engineering(first.frequency)} Hz", words)]
    driven = _driven(result)
    if driven.size and _force_ratio(result)[driven[0]] > 0:
        at = int(driven[0])
        meets = f"{_order(result, at)} meets mode {_mode(result, at)}, {_hertz(result, at)} Hz"
        found.append((f"{_speed(result, at)} %", f"of the operating speed, strongest resonance near it: {meets}"))
    return found


def _force_ratio(result: xr.Dataset) -> NDArray[np.float64]:
    """Force that the mode of every resonance makes per mean mesh force [1]; -1 where it is not known."""
    return np.nan_to_num(numbers(result, "resonance_force_ratio", "resonance"), nan=-1.0)


def _excited(result: xr.Dataset) -> NDArray[np.str_]:
    """Whether the order of every resonance excites the mode, "yes" or "no"; "" where it is not known."""
    return np.array(texts(result, "resonance_excited", "resonance"), dtype=str)


def _driven(result: xr.Dataset) -> NDArray[np.int64]:
    """Resonances near operation whose order excites the mode, or where that is not known, the strongest first."""
    if not result.sizes.get("resonance", 0):
        return np.zeros(0, np.int64)
    near = np.flatnonzero(result["resonance_near"].values & (_excited(result) != "no"))
    return near[ranked(_force_ratio(result)[near], equal=EQUAL)]


def modes_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """The strongest resonance within the band about operation, and what holds it."""
    if "resonance_near" not in result.variables:
        return []
    band = _within(result)
    near = np.flatnonzero(result["resonance_near"].values)
    if not near.size:
        return [Finding(tone="good", text=f"No mesh order meets a mode {band}.", anchor="modes")]
    met, near, ratio = near.size, _driven(result), _force_ratio(result)
    if not near.size:
        text = f"No mesh order excites a mode {band}: {met} meet one that the phases of the meshes leave at rest."
        return [Finding(tone="good", text=text, anchor="resonances")]
    at = int(near[0])
    speed, mode = _speed(result, at), _mode(result, at)
    kind = f"{result['resonance_kind'].values[at]}, {_hertz(result, at)} Hz"
    where = f"{_order(result, at)} meets mode {mode} ({kind}) at {speed} % of the operating speed"
    count = f"{near.size} resonance{'s' if near.size > 1 else ''} {band}"
    if met > near.size:
        count += f" ({met - near.size} more where the order does not excite the mode)"
    if ratio[at] < 0:  # without damping or load no force is known
        closest = int(near[np.abs(result["resonance_speed"].values[near] - 1).argmin()])
        where = f"{_order(result, closest)} at {_speed(result, closest)} %"
        text = f"{count}; the nearest is {where}. How strong they are is not known."
        return [Finding(tone="caution", text=text, anchor="resonances")]
    force, verdict = float(result["resonance_own_force"].values[at]), ResonanceVerdict(float(ratio[at]))
    size = f"the mode's force of up to {engineering(force / 1e3)} kN is {verdict.text}"
    change = ""
    if verdict.tone != "good":
        (held,) = _shares(result, "connection", np.array([at]))
        on_it = abs(float(result["resonance_speed"].values[at]) - 1) < _ON_IT
        away = ": operation stands on it" if on_it else f", or keep away from {speed} % of the operating speed"
        change = f"Move that frequency, most strain energy {held} (epicyclic detune --mode {mode}){away}."
    text = f"{count}; the strongest is where {where}: {size}{_nearer(result, near[ratio[near] >= NO_MATTER], at)}."
    judged = {"value": verdict.force_ratio, "limit": TEETH_PART}
    return [Finding(tone=verdict.tone, text=text, change=change, anchor="resonances", **judged)]


def modes_over_cases(whole: xr.Dataset, cases: Mapping[str, xr.Dataset]) -> list[Table]:
    """Of every case the resonance nearest to its speed of those whose mode makes a force that matters."""
    rows = []
    for name, result in cases.items():
        near, ratio = _driven(result), _force_ratio(result)
        known = ratio[near] >= 0  # of none where there is no load; beside others nobody found a motion there
        strong = near[ratio[near] >= NO_MATTER] if known.any() else near
        if not strong.size:
            continue
        speed = result["resonance_speed"].values
        at = int(strong[np.abs(speed[strong] - 1).argmin()])
        hertz, force = float(result["resonance_frequency"].values[at]), 100 * float(ratio[at])
        force = force if ratio[at] >= 0 else np.nan
        rows.append((name, _order(result, at), _mode(result, at), hertz, 100 * float(speed[at]), force))
    headings = ("case", "mesh order", "mode", "frequency [Hz]", "at [% of its speed]", "force [% of mean]")
    title = f"Nearest resonance of every case whose mode makes {100 * NO_MATTER:g} % of the mean force or more"
    return [Table(title=title, columns=named_columns(headings, rows))] if rows else []


def _nearer(result: xr.Dataset, strong: NDArray[np.int64], strongest: int) -> str:
    """The resonance nearest to operation of some strong ones, where the strongest is another."""
    away = np.abs(result["resonance_speed"].values - 1)
    if not strong.size or away[nearest := int(strong[away[strong].argmin()])] >= away[strongest]:
        return ""
    share = engineering(100 * float(_force_ratio(result)[nearest]), 2)
    at = f"{_order(result, nearest)} and mode {_mode(result, nearest)} at {_speed(result, nearest)} %"
    return f"; nearest {at}, {share} %"


def modes_front(result: xr.Dataset, company: Company) -> Sequence[Part]:
    """The resonances within the band, the strongest of them, and where in the range of speeds all lie."""
    from ...show.charts.over_speed import operating_range

    parts: list[Part] = []
    if result.sizes.get("resonance", 0):
        near = np.flatnonzero(result["resonance_near"].values)
        if near.size:
            table = _resonances(result, near, f"Resonances {_within(result)}", _IN_FRONT)
            left = ("near", "most kinetic energy", "K_v of")
            parts.append(replace(table, columns={name: own for name, own in table.columns.items() if name not in left}))
    figure = operating_range({"": (result, company.get("sweep"))})
    if figure is not None:
        words = "A mark is a speed at which a mesh order meets a mode; the strongest are named where there is room."
        parts.append(Drawing(anchor="operating-range", figure=figure, caption=words))
    return parts


def _near_operation(result: xr.Dataset) -> list[Part]:
    """Table of the resonances near operation, all of the range folded away."""
    near = np.flatnonzero(result["resonance_near"].values)
    every = np.arange(result.sizes["resonance"])
    within = _within(result)
    lead = (
        "A resonance is a speed at which a mesh order meets a natural frequency. How much it matters is in the mesh "
        "force that the mode makes at that order (linear contact)."
    )
    parts: list[Part] = []
    if near.size:
        table = _resonances(result, near, within.capitalize(), _IN_PAGE)
        parts.append(replace(table, lead=f"{lead} {table.lead}".strip()))
    else:
        parts.append(Listing(text=f"No mesh order meets a mode {within}."))
    if every.size > near.size:
        whole = _resonances(result, every, _range(result).capitalize(), _FOLDED)
        parts.append(Details(summary=f"All resonances {_range(result)}", parts=[whole]))
    return parts


def _resonances(result: xr.Dataset, places: NDArray[np.int64], title: str, most: int) -> Table:
    """Rows of the resonances at some places, speeds rising; of more than `most` those of the largest forces."""
    shown = np.sort(places[ranked(_force_ratio(result)[places], equal=EQUAL)[:most]])
    excited = _excited(result)
    if len(shown) < len(places):
        title += f": of {len(places)} the {len(shown)} with the largest forces, by speed"
    speed, near = 100 * result["resonance_speed"].values, result["resonance_near"].values
    count = result["resonance_multiplicity"].values
    columns: dict[str, Any] = {
        "speed [% of operation]": [float(speed[i]) for i in shown],
        "near": ["yes" if near[i] else "" for i in shown] if not near[places].all() else [""] * len(shown),
        "mesh order": [_order(result, i) for i in shown],
        "mode": [int(result["resonance_mode"].values[i]) for i in shown],
        "frequency [Hz]": [float(result["resonance_frequency"].values[i]) for i in shown],
        "kind": [f"{result['resonance_kind'].values[i]}{f' x{count[i]}' if count[i] > 1 else ''}" for i in shown],
        "most strain energy": _shares(result, "connection", shown),
        "most kinetic energy": _shares(result, "body", shown),
        "excited": [str(excited[i]) for i in shown],
        "force of the mode [N]": list(numbers(result, "resonance_own_force", "resonance")[shown]),
        "K_v at this speed": [float(result["resonance_dynamic_factor"].values[i]) for i in shown],
        "K_v of": [unbroken(str(name), stages=_stages(result)) for name in result["resonance_mesh"].values[shown]],
    }
    note = str(result.attrs.get("resonance_note", ""))
    # above the table: a number below it would look like one of the branches in its last column
    return Table(title=title, columns=columns, lead=f"{note}." if note else "")


def _mode(result: xr.Dataset, place: int) -> int:
    return int(result["resonance_mode"].values[place])


def _hertz(result: xr.Dataset, place: int) -> str:
    return engineering(float(result["resonance_frequency"].values[place]))


def _speed(result: xr.Dataset, place: int) -> str:
    """Per cent of the operating speed."""
    return engineering(100 * float(result["resonance_speed"].values[place]))


def _order(result: xr.Dataset, place: int) -> str:
    """``8x mesh``, of a train of several stages ``8x low mesh``."""
    stage = str(result["resonance_stage"].values[place])
    several = _stages(result) > 1
    return f"{int(result['resonance_order'].values[place])}x {f'{stage} ' if several else ''}mesh"


def _shares(result: xr.Dataset, what: str, places: NDArray[np.int64]) -> list[str]:
    """``sun support 57 %``: what holds most of an energy, and its share."""
    names = result[f"resonance_{what}"].values[places]
    shares = result[f"resonance_{what}_share"].values[places]
    several = _stages(result) > 1
    return [
        f"{(str(name) if several else str(name).split('/', 1)[-1]).replace('/', ' ')} {100 * share:.0f} %"
        if name
        else ""
        for name, share in zip(names, shares, strict=True)
    ]


def _stages(result: xr.Dataset) -> int:
    """Number of stages of the train, of its bodies with one."""
    return stage_count(texts(result, "connection"))


def _within(result: xr.Dataset) -> str:
    """How near the operating speed counts as near it, in words."""
    band = float(json.loads(str(result.attrs.get("options", "{}"))).get("band") or RESONANCE_BAND)
    return f"within {engineering(100 * band)} % of the operating speed"


def _range(result: xr.Dataset) -> str:
    options, modes = json.loads(str(result.attrs.get("options", "{}"))), ""
    if options.get("band"):
        return _within(result)
    if options.get("hertz"):
        modes = ", modes from {} to {} Hz".format(*map(engineering, options["hertz"]))
    return f"from 5 to 130 % of the operating speed{modes}"


def _most(result: xr.Dataset, name: str, dim: str) -> list[str]:
    """What holds the largest share of an energy in each mode, and how much."""
    if name not in result.variables:
        return [""] * result.sizes["mode"]
    names, shares = summed_shares(texts(result, dim), result[name].transpose(dim, "mode").values)
    found = []
    for column in shares.T:
        known = bool(np.isfinite(column).all() and column.any())
        most = int(np.argmax(column)) if known else 0
        found.append(f"{names[most]} {100 * column[most]:.0f} %" if known else "")
    return found


# --- campbell --------------------------------------------------------------------------------------------------------

_COLUMNS = 5


def campbell_tables(result: xr.Dataset) -> Sequence[Table]:
    """Natural frequencies [Hz] at five of the speeds."""
    speeds = result.relative_speed.values
    frequency = result.whirl_frequency.transpose("mode", "relative_speed").values
    columns: dict[str, Any] = {"mode": list(map(int, result.mode.values))}
    for at in np.unique(np.linspace(0, len(speeds) - 1, _COLUMNS).round().astype(int)):
        columns[f"{speeds[at]:.3g} x speed [Hz]"] = list(frequency[:, at])
    return [Table(title="Natural frequencies over speed", columns=columns)]


def campbell_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The diagram; beside `modes` it stands among them."""
    from ...show.charts.modes import campbell

    if "modes" in company:
        return []
    parts = [Drawing(anchor="campbell", figure=campbell(result))]
    return [Section(anchor="modes", title="Vibration modes", parts=parts)]


VIEWS = (
    ResultView(
        "modes",
        30,
        modes_tables,
        modes_sections,
        key_figures=modes_key_figures,
        findings=modes_findings,
        front=modes_front,
        over_cases=modes_over_cases,
    ),
    ResultView("campbell", 40, campbell_tables, campbell_sections),
)
