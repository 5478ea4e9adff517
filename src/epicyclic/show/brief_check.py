"""`check` on one screen: ratio, speeds, torques, meshes, how the teeth are phased, what verbs still need."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import xarray as xr

from .elements import Table, named_columns
from .part_tables import NOMINAL, bearing_tables, ring_tables
from .series import Member, engineering, grouped, members_of, numbers, split_name, texts

# leads are exact fractions of a cycle as floats: this much is rounding
_ROUNDING = 1e-6
_COUPLED = "couplings."
_KINDS, _ORDERS = ("rotational", "translational", "planet"), 12
_WHOLE = "Bodies, gears, frequencies, links, deviations, choices and the origin of every value: check --all."


def brief_tables(result: xr.Dataset) -> list[Table]:
    """Members and couplings with speeds and torques, pairs of gears, loads of bearings, verbs; the rest by words."""
    assumed, values = (json.loads(str(result.attrs.get(name, "[]"))) for name in ("assumed", "values"))
    count = f"{len(assumed)} of {len(values)} values are assumed. " if assumed else ""
    cases = ", ".join(json.loads(str(result.attrs.get("model", "{}"))).get("cases", ()))
    others = f" Load cases: {cases}; --case NAME or --case all." if cases else ""
    tail = Table(title="", columns={}, lead=count + _WHOLE + others)
    loads = [*ring_tables(result)[:1], *bearing_tables(result, NOMINAL)[:1]]
    return [_members(result), *_couplings(result), _pairs(result), *loads, _verbs(result), tail]


def _members(result: xr.Dataset) -> Table:
    member = dict(zip(texts(result, "body"), texts(result, "member", "body"), strict=True))
    gears = zip(texts(result, "gear"), numbers(result, "teeth", "gear"), strict=True)
    teeth = {member.get(name, name): float(count) for name, count in gears}
    found = members_of(result)
    columns: dict[str, Any] = {
        "member": [one.name for one in found],
        "bodies": [one.count for one in found],
        "teeth": [teeth.get(one.name, np.nan) for one in found],
        "speed [rpm]": [one.speed for one in found],
        "torque [N m]": [one.torque for one in found],
        "power [kW]": [one.power * 1e-3 for one in found],
        "mass [kg]": [one.mass for one in found],
    }
    lead = locked_words(result) or ratio(found)
    return Table(title="Members (torque of all bodies, mass of one)", lead=lead, columns=columns)


def locked_words(result: xr.Dataset) -> str:
    """What a locked train is: which members are held, with the torque that each takes; "" of one that turns."""
    held = json.loads(str(result.attrs.get("locked", "[]")))
    torque = {one.name: f"{engineering(one.torque)} N m" for one in members_of(result) if one.torque}
    takes = ", ".join(f"{name} ({torque.get(name, '0 N m')})" for name in held)
    loaded = ", ".join(f"{name} ({text})" for name, text in torque.items() if name not in held) or "no member"
    return f"Locked: no member turns; loaded {loaded}, held {takes}." if held else ""


def _couplings(result: xr.Dataset) -> list[Table]:
    """Torque, speed and slip of every coupling, its shafts among them; none where speeds or torques are not known."""
    if "path_torque" not in result.variables:
        return []
    speed = {one.name: one.speed for one in members_of(result)}
    ends = zip(*(texts(result, name, "path") for name in ("path", "path_from", "path_to")), strict=True)
    torques = numbers(result, "path_torque", "path")
    rows = [
        (path.removeprefix(_COUPLED), first, second, float(torque), speed.get(second, np.nan), np.nan)
        for (path, first, second), torque in zip(ends, torques, strict=True)
        if path.startswith(_COUPLED)
    ]
    apart = _open_couplings(result, members_of(result))
    rows += [(name, first, second, np.nan, speed.get(second, np.nan), slip) for name, first, second, slip in apart]
    headings = ("coupling", "from", "to", "torque [N m]", "speed [rpm]", "slip [rpm]")
    title = f"Couplings (torque on the second member{'; slip of an open one' if apart else ''})"
    return [Table(title=title, columns=named_columns(headings, rows))] if rows else []


def check_over_cases(whole: xr.Dataset, cases: Mapping[str, xr.Dataset]) -> list[Table]:
    """A line a case: ratio, speed and torque of every member that is no planet, and power; then its couplings."""
    members = {name: [one for one in members_of(result) if one.kind != "planet"] for name, result in cases.items()}
    first = next(iter(members.values()), [])
    ends = {name: power_ends(own) for name, own in members.items()}
    columns: dict[str, Any] = {
        "case": list(cases),
        "ratio": [ratio_of(end, driven[0]) if end and driven else "" for end, driven in ends.values()],
        "power [kW]": [end.power * 1e-3 if end else np.nan for end, _ in ends.values()],
        "efficiency [%]": [100 * float(result.get("train_efficiency", np.nan)) for result in cases.values()],
    }
    for heading, of in (("{} [rpm]", "speed"), ("{} [N m]", "torque")):
        for at, member in enumerate(first):
            values = [getattr(own[at], of) for own in members.values()]
            if of == "speed" or any(values):
                columns[heading.format(member.name)] = values
    rows = {
        name: (_through(result), {one: slip for one, _, _, slip in _open_couplings(result, members[name])})
        for name, result in cases.items()
    }
    paths = list(dict.fromkeys(path for through, slips in rows.values() for path in (*through, *slips)))
    joined: dict[str, Any] = {"case": list(cases)} if paths else {}
    for path in paths:
        joined[f"{path} [N m]"] = [through.get(path, np.nan) for through, _ in rows.values()]
        joined[f"{path} slip [rpm]"] = [slips.get(path, np.nan) for _, slips in rows.values()]
    title = "Couplings and shafts (torque on the second member; slip of an open one, its speed less that of the first)"
    return [Table(title="Operation", columns=columns), *([Table(title=title, columns=joined)] if paths else [])]


def _through(result: xr.Dataset) -> dict[str, float]:
    """Torque [N m] through every coupling and inner shaft that power takes."""
    if "path_torque" not in result.variables:
        return {}
    torques = zip(texts(result, "path"), numbers(result, "path_torque", "path"), strict=True)
    return {path.removeprefix(_COUPLED): float(torque) for path, torque in torques if not path.startswith("stages.")}


def _open_couplings(result: xr.Dataset, members: Sequence[Member]) -> list[tuple[str, str, str, float]]:
    """Every coupling without stiffness about z, its members, and the speed of the second less that of the first."""
    speed = {one.name: one.speed for one in members}
    member = dict(zip(texts(result, "body"), texts(result, "member", "body"), strict=True))
    about_z = result["link_stiffness"].sel(direction="rz").values
    ends = zip(*(texts(result, f"link_{end}", "link") for end in ("first", "second")), strict=True)
    found = []
    for name, kind, stiffness, own in zip(
        texts(result, "link"), texts(result, "link_kind", "link"), about_z, ends, strict=True
    ):
        if kind == "coupling" and stiffness == 0 and own[0] in member and own[1] in member:
            first, second = (member[end] for end in own)
            slip = speed.get(second, np.nan) - speed.get(first, np.nan)
            found.append((name.removeprefix(_COUPLED), first, second, slip))
    return found


def ratio(members: Sequence[Member]) -> str:
    """Ratio of speed from the driving to every driven member in a sentence; of any two where no power is known."""
    turning = [one for one in members if np.isfinite(one.speed) and one.speed != 0 and one.kind != "planet"]
    driving, driven = power_ends(members)
    if driving is None or not driven:
        driving, driven = next(iter(turning), None), turning[1:]
    if driving is None or not driven:
        return "No speeds: operation.speed gives them." if not turning else ""
    words = [
        f"{driving.name} to {one.name} {ratio_of(driving, one)}"
        f" ({engineering(driving.speed, 6)} rpm to {engineering(one.speed, 6)} rpm)"
        for one in driven[:3]
    ]
    return f"Ratio {'; '.join(words)}."


def power_ends(members: Sequence[Member]) -> tuple[Member | None, list[Member]]:
    """Member through which most power enters, and those through which power leaves, first the one with most."""
    turning = [one for one in members if one.speed != 0 and one.kind != "planet"]
    driving = [one for one in turning if one.power > 0]
    driven = [one for one in turning if one.power < 0]
    if not driving or not driven:
        return None, []
    first = _strongest(driven)
    return _strongest(driving), [first, *(one for one in driven if one is not first)]


def _strongest(members: Sequence[Member]) -> Member:
    """The member with most power; of several with as much, the first."""
    most = max(abs(one.power) for one in members)
    return next(one for one in members if abs(one.power) >= (1 - _ROUNDING) * most)


def ratio_of(driving: Member, driven: Member) -> str:
    """Speed of the driving member over that of the driven one: 3.5, or where it speeds up 1 : 3.5, with the senses."""
    value = driving.speed / driven.speed
    size = engineering(abs(value), 6) if abs(value) >= 1 else f"1 : {engineering(1 / abs(value), 6)}"
    return size if value > 0 else f"{size}, in opposite senses"


def _pairs(result: xr.Dataset) -> Table:
    """One row for each pair of gears: what its meshes have in common, and how they are phased."""
    names = texts(result, "mesh")
    own = grouped((split_name(name)[:2] for name in names), range(len(names)))
    rows = list(own.values())

    def column(name: str, factor: float = 1.0) -> list[Any]:
        return [_span(factor * numbers(result, name, "mesh")[row]) for row in rows]

    columns: dict[str, Any] = {
        "pair": [f"{stage}/{pair}" if stage else pair for stage, pair in own],
        "meshes": [len(row) for row in rows],
        "frequency [Hz]": _frequencies(result, list(own)),
        "contact ratio [-]": column("contact_ratio"),
        "overlap ratio [-]": column("overlap_ratio"),
        "mean stiffness [N/µm]": column("mean_mesh_stiffness", 1e-6),
        "branches mesh": [_phased(result, row) for row in rows],
    }
    driven = [
        f"{stage}: mesh orders {whole} drive rotational modes; {sideways} translational; {planet} planet modes."
        for table in driven_kinds(result)
        for stage, whole, sideways, planet in zip(*table.columns.values(), strict=True)
    ]
    return Table(title="Meshes", lead="\n".join([_stages(result), *driven]), columns=columns)


def driven_kinds(result: xr.Dataset) -> list[Table]:
    """Which mesh order drives which kind of mode, by stage; none where no stage has several planets.

    The exciting forces of branches b at the angles 2 pi b / N have at order l the phases 2 pi l lead_b.  Of their
    discrete Fourier transform over b the part k = 0 drives rotational modes, k = 1 and N - 1 translational ones, the
    others planet modes [parker2004].
    """
    rows = []
    for stage in dict.fromkeys(texts(result, "mesh_stage", "mesh")):
        kinds = _kinds_of_orders(result, stage)
        if kinds is not None:
            rows.append((stage, *(", ".join(map(str, kinds[kind])) or "none" for kind in _KINDS)))
    if not rows:
        return []
    headings = ("stage", *(f"{kind} modes" for kind in _KINDS))
    words = "Equal planets, evenly spaced and loaded alike. Other loads and deviations drive the rest a little."
    return [Table(title="Mesh orders that drive", columns=named_columns(headings, rows), lead=words)]


def _kinds_of_orders(result: xr.Dataset, stage: str) -> dict[str, list[int]] | None:
    """Mesh orders 1 .. 12 that drive each kind of mode; None of a stage without evenly spaced branches."""
    pairs: dict[tuple[str, str], dict[int, float]] = {}
    leads = numbers(result, "phase_lead", "mesh")
    for place, name in enumerate(texts(result, "mesh")):
        own, pair, branch, side = split_name(name)
        if own == stage and branch:
            pairs.setdefault((pair, side), {})[branch] = float(leads[place])
    if not _evenly_spaced(result, stage) or not pairs or not np.isfinite(next(iter(pairs.values())).get(1, np.nan)):
        return None
    found: dict[str, list[int]] = {kind: [] for kind in _KINDS}
    for order in range(1, _ORDERS + 1):
        driven = set[str]()
        for by_branch in pairs.values():
            phase = 2j * np.pi * order * np.array([by_branch[branch] for branch in sorted(by_branch)])
            size = np.abs(np.fft.fft(np.exp(phase))) / len(phase)
            for k in np.flatnonzero(size > _ROUNDING).tolist():  # branches follow each other by k turns of their number
                driven.add(_KINDS[0] if k == 0 else _KINDS[1] if k in (1, len(phase) - 1) else _KINDS[2])
        for kind in driven:
            found[kind].append(order)
    return found


def _evenly_spaced(result: xr.Dataset, stage: str) -> bool:
    """Whether the planets of a stage, several, stand evenly round its axis, by their polar angles."""
    angle: dict[str, dict[int, float]] = {}
    for name, at in zip(texts(result, "body"), numbers(result, "axes_angle", "body"), strict=True):
        own, member, branch, side = split_name(name)
        if own == stage and branch and side != "right":
            angle.setdefault(member, {})[branch] = float(at)
    spaced = [np.array([by[branch] for branch in sorted(by)]) for by in angle.values()]
    even = [np.exp(1j * (one[0] + 2 * np.pi * np.arange(len(one)) / len(one))) for one in spaced]
    return bool(spaced) and all(
        len(one) > 1 and np.abs(np.exp(1j * one) - turns).max() < _ROUNDING
        for one, turns in zip(spaced, even, strict=True)
    )


def _frequencies(result: xr.Dataset, pairs: Sequence[tuple[str, str]]) -> list[float]:
    stages = dict(zip(texts(result, "stage"), numbers(result, "mesh_frequency", "stage"), strict=True))
    lines: Mapping[str, float] = {}
    if "order_name" in result.dims:
        lines = dict(zip(texts(result, "order_name"), numbers(result, "order_frequency", "order_name"), strict=True))
    return [float(lines.get(f"{stage}/{pair} mesh", stages.get(stage, np.nan))) for stage, pair in pairs]


def _span(values: np.ndarray[Any, np.dtype[np.float64]]) -> Any:
    """The common value, or the least and the most in words."""
    known = values[np.isfinite(values)]
    if not known.size:
        return np.nan
    least, most = float(known.min()), float(known.max())
    alike = most - least <= _ROUNDING * max(abs(least), abs(most))
    return least if alike else f"{least:.6g} to {most:.6g}"


def _phased(result: xr.Dataset, places: Sequence[int]) -> str:
    names, leads = texts(result, "mesh"), numbers(result, "phase_lead", "mesh")
    sides: dict[str, dict[int, float]] = {}
    for place in places:
        *_, branch, side = split_name(names[place])
        sides.setdefault(side, {})[branch] = float(leads[place])
    words = [phasing(list(branches.values())) for branches in sides.values()]
    if len(sides) < 2 or not all(words):
        return words[0]
    apart = _cycle(sides["right"][min(sides["right"])] - sides["left"][min(sides["left"])])
    return words[0] if apart == 0 else f"{words[0]}; right half {_fraction(apart)} cycle ahead"


def phasing(leads: Sequence[float]) -> str:
    """How the meshes of a pair follow each other, by their leads [mesh cycles] in the order of the branches; "" of one.

    ``together``; ``in turn``, each the same part of a cycle earlier or later than the one before; ``in opposite
    pairs``, half of them half a cycle later; else the leads.
    """
    if len(leads) < 2 or not np.isfinite(leads).all():
        return ""
    places = [_cycle(lead - leads[0]) for lead in leads]
    if not any(places):
        return "together"
    count = len(places)
    even = sorted(places) == [Fraction(step, count) for step in range(count)]
    if even and count > 2:
        step = places[1] if places[1] <= Fraction(1, 2) else places[1] - 1
        return f"in turn, {_fraction(abs(step))} cycle {'earlier' if step > 0 else 'later'}"
    if 2 * places.count(Fraction(0)) == 2 * places.count(Fraction(1, 2)) == count:
        return "in opposite pairs"
    return f"{', '.join(map(_fraction, places))} cycle ahead"


def _cycle(lead: float) -> Fraction:
    """A lead as a fraction of a cycle, 0 <= f < 1: of small numbers where it is one, else to a thousandth."""
    part = Fraction(lead % 1.0).limit_denominator(24)
    if abs(float(part) - lead % 1.0) > _ROUNDING:
        part = Fraction(round(1000 * (lead % 1.0)), 1000)
    return part % 1


def _fraction(part: Fraction) -> str:
    return str(part) if part.denominator <= 24 else f"{float(part):.3g}"


def _stages(result: xr.Dataset) -> str:
    """Spacing of the branches and whether they can be assembled, stage by stage in words."""
    said = json.loads(str(result.attrs.get("warnings", "[]")))
    lines = []
    columns = (numbers(result, name, "stage") for name in ("planets", "k_gamma_limit"))
    sources = texts(result, "k_gamma_limit_source", "stage")
    for stage, count, limit, source in zip(texts(result, "stage"), *columns, sources, strict=True):
        if count < 2:
            continue
        apart = any(text.startswith(f"stages.{stage}: ") and "cannot be assembled" in text for text in said)
        spaced = "equally spaced" if _equally(result, stage) else "unequally spaced"
        lines.append(
            f"{stage}: {count:.0f} branches, {spaced}: {'CANNOT be assembled' if apart else 'can be assembled'}; "
            f"K_gamma limit {limit:g} ({source.split(' planets, ')[-1]})"
        )
    return f"{'; '.join(lines)}." if lines else ""


def _equally(result: xr.Dataset, stage: str) -> bool:
    """Whether the axes of the branches of a stage divide the circle equally."""
    own = zip(texts(result, "body_stage", "body"), numbers(result, "branch", "body"), strict=True)
    rows = {int(branch): row for row, (where, branch) in enumerate(own) if where == stage and branch}
    axes = numbers(result, "axes_angle", "body")
    angles = np.sort(np.mod(axes[list(rows.values())], 2 * np.pi))
    gaps = np.diff([*angles, angles[0] + 2 * np.pi]) if angles.size else np.zeros(0)
    return bool(np.allclose(gaps, 2 * np.pi / max(len(gaps), 1), rtol=0, atol=_ROUNDING))


def _verbs(result: xr.Dataset) -> Table:
    """Which verbs are ready; what the others need first, each need once; `check --all` says all and what is allowed."""
    if "verb_needs" not in result.variables:
        return Table(title="", columns={})
    names = [name.replace("_", "-") for name in texts(result, "verb_name")]
    needs: dict[str, list[str]] = {}
    for name, text in zip(names, texts(result, "verb_needs", "verb_name"), strict=True):
        if text:
            needs.setdefault(text.split("\n")[0], []).append(name)
    lacking = {name for some in needs.values() for name in some}
    ready = [name for name in names if name not in lacking]
    if not needs:
        return Table(title="", lead="All verbs are ready.", columns={})
    lead = f"Ready: {', '.join(ready)}. Others need:" if ready else "Each verb still needs:"
    notes = tuple(f"{text.split('; allowed: ')[0]} ({', '.join(some)})" for text, some in needs.items())
    return Table(title="", lead=lead, columns={}, notes=notes)
