"""Views of `tolerance` and `allocate`: K_gamma as a distribution, and the grades that keep it low."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from ...limits import JUDGED_AT, k_gamma_verdict, passes
from ...show.elements import Company, Drawing, Finding, KeyFigure, Part, Section, Table, named_columns
from ...show.series import (
    engineering,
    judged_quantile,
    micrometres,
    of_definition,
    overlap,
    pair_labels,
    percent,
    scattering_pair,
    share_of_trains,
    share_with_band,
    short_entries,
    system_quantiles,
    tenth_less,
    texts,
)
from ...show.views import ResultView

# --- tolerance -------------------------------------------------------------------------------------------------------

# worst samples in a table
_WORST = 5
_TURNING = "mean-load-turning"
_NAMES = {"mean-load": "K_gamma (mean-load)", "mean-load-turning": "largest while turning"}


def tolerance_tables(result: xr.Dataset) -> Sequence[Table]:
    """Quantiles with bands, exceedance and separation, what buys what, the loads of the worst samples."""
    found = [_quantiles(result), _exceedance(result)]
    if "system_tenth_less" in result:
        found.append(_what_buys(result, texts(result, "tolerance")))
    if "worst_load_sharing" in result:
        found.append(_worst(result))
    return found


def tolerance_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """Histogram and quantiles, shares, curves, the worst sample."""
    from ...show.charts.sharing import (
        k_gamma_by_design,
        k_gamma_by_tolerance,
        k_gamma_histogram,
        tolerance_shares,
        worst_branches,
    )

    words = "K_gamma: mean load of the most loaded branch over its equal share, without mesh frequency content."
    if "reference_k_gamma" in result:
        words += " Dashed: values given by the user."
    parts: list[Part] = [
        Drawing(anchor="k-gamma", figure=k_gamma_histogram(result), caption=words),
        _quantiles(result),
        _exceedance(result),
    ]
    if "system_tenth_less" in result:
        parts.append(Drawing(anchor="tolerance-shares", figure=tolerance_shares(result)))
        parts.append(_what_buys(result, short_entries(texts(result, "tolerance"))))
    if "k_gamma_by_scale" in result:
        parts.append(Drawing(anchor="k-gamma-by-tolerance", figure=k_gamma_by_tolerance(result)))
    if any(name in result for name in ("k_gamma_by_torque", "k_gamma_by_support", "k_gamma_by_planets")):
        parts.append(Drawing(anchor="k-gamma-by-design", figure=k_gamma_by_design(result), caption=_left_out(result)))
    if "worst_load_sharing" in result:
        parts.append(Drawing(anchor="worst-branches", figure=worst_branches(result)))
    return [Section(anchor="tolerances", title="Tolerances", parts=parts)]


def tolerance_key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """K_gamma at 50, 95 and 99 % [1], and how often contact opens."""
    found = [
        (f"{value:.3f}", f"K_gamma not exceeded in {percent(p)} of the trains")
        for p, value in system_quantiles(result).items()
    ]
    apart = float(result["system_separation_probability"]) if "system_separation_probability" in result else 0.0
    if apart > 0:
        found.append((f"{engineering(100 * apart, 2)} %", "trains in which a mesh separates"))
    return found


def tolerance_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """K_gamma of nearly all trains, the entry that scatters it most, and how often a mesh separates."""
    p, value = judged_quantile(result)
    found: list[Finding] = []
    if np.isfinite(p):
        finding = _k_gamma(result, p, value)
        change = _what_to_tighten(result, finding) if "system_tenth_less" in result else ""
        found.append(replace(finding, change=change))
    apart = float(result["system_separation_probability"]) if "system_separation_probability" in result else 0.0
    if apart > 0:
        text = f"In {engineering(100 * apart, 2)} % of the trains a mesh separates under its mean load."
        found.append(Finding(tone="caution", text=text, anchor="tolerances"))
    return found


def _what_to_tighten(result: xr.Dataset, finding: Finding) -> str:
    """The tolerances whose tenth takes most off K_gamma; where K_gamma meets its limit, that nothing is to be done."""
    ranking, names = tenth_less(result), short_entries(texts(result, "tolerance"))
    at = f"K_gamma at {percent(ranking.probability)}"
    most = ranking.tied_first()
    if not ranking.high[most[0]] < 0:
        return f"A tenth less spread of one tolerance takes nothing off {at} that {ranking.samples} samples tell."
    tops = " or ".join(f"{names[i]} ({ranking.banded(i)})" for i in most)
    tied = f"; they are not told apart at {ranking.samples} samples" if len(most) > 1 else ""
    text = f"A tenth less spread of {tops} takes most off {at}{tied}."
    met = not np.isnan(finding.limit) and passes(finding.value, finding.limit)
    return f"Nothing to tighten: {at} is below its limit. {text}" if met else text


def _k_gamma(result: xr.Dataset, p: float, value: float) -> Finding:
    """K_gamma of a share p of the trains against its limit; of one limit that of all pairs together, value [1]."""
    apart = "k_gamma_limit" in result and len(set(result["k_gamma_limit"].values.tolist())) > 1
    kind = "" if apart else "system_"
    mean = of_definition(result)[f"{kind}k_gamma_quantile"].sel(probability=p)
    verdict = k_gamma_verdict(result, "pair", np.broadcast_to(mean, result.sizes["pair"]).tolist(), probability=p)
    if verdict is None:
        text = f"With tolerances K_gamma stays below {value:.3f} in {percent(p)} of the trains{_turning(result, p)}."
        return Finding(tone="", text=text, anchor="tolerances")
    whose = f" of {verdict.name.replace('.meshes.', ' ')}" if apart else ""
    shares = of_definition(result)[f"{kind}exceedance"]
    shares = shares.sel(pair=verdict.name) if apart else shares
    counted = np.flatnonzero(np.isclose(shares["limit"].values, verdict.limit))
    counts = (engineering(100 * float(shares.values[at]), 2) for at in counted)
    above = "".join(f", {count} % of the trains are above it" for count in counts)
    text = (
        f"With tolerances K_gamma{whose} stays below {verdict.value:.3f} in {percent(p)} of the trains"
        f"{_turning(result, p, verdict.name if apart else None)}; {verdict.text}{above}."
    )
    return Finding(tone=verdict.tone, text=text, anchor="tolerances", value=verdict.value, limit=verdict.limit)


def _turning(result: xr.Dataset, probability: float, pair: str | None = None) -> str:
    """Words of the same quantile of the largest load while turning, of a pair or of all; "" where it has none."""
    if _TURNING not in texts(result, "definition"):
        return ""
    turning = of_definition(result, _TURNING).sel(probability=probability)
    of_pair = turning["system_k_gamma_quantile"] if pair is None else turning["k_gamma_quantile"].sel(pair=pair)
    words = f", the largest load of a mesh while turning below {float(of_pair):.3f} of the equal one"
    return words if np.isfinite(of_pair) else ""


def _left_out(result: xr.Dataset) -> str:
    """Curves that could not be computed, with the reasons."""
    found: dict[str, str] = json.loads(str(result.attrs.get("left_out", "{}")))
    return f"Left out: {'; '.join(found.values())}." if found else ""


def _quantiles(result: xr.Dataset) -> Table:
    """Quantiles of the train by each definition with their bands, and of its pairs where they have others."""
    given = [float(p) for p in result["probability"].values]
    rows: dict[str, list[str]] = {}
    for definition in texts(result, "definition"):
        one = of_definition(result, definition)
        name = _NAMES.get(definition, definition)
        rows[name] = _with_bands(one, "system_k_gamma_quantile")
        for pair, label in enumerate(pair_labels(texts(one, "pair"))):
            own = _with_bands(one.isel(pair=pair), "k_gamma_quantile")
            if definition == "mean-load" and own != rows[name]:
                rows[f"  {label}"] = own
    columns = named_columns(("", *map(percent, given)), [(name, *row) for name, row in rows.items()])
    count = f"{int(result.attrs.get('done', 0)):,} samples".replace(",", "\u2009")
    lead = f"{count}; in brackets the 95 % band of each quantile."
    return Table(title="Mesh-load factor not exceeded in ... of the trains", columns=columns, lead=lead)


def tolerance_over_cases(whole: xr.Dataset, cases: Mapping[str, xr.Dataset]) -> list[Table]:
    """K_gamma of every case, of the pair nearest to its limit, how often it is above that, and over all the time."""
    share = dict(zip(texts(whole, "case"), whole["case_share"].values, strict=True))
    rows = [(name, *_nearest(result)) for name, result in cases.items()]
    time = sum(share[name] for name, *_ in rows)
    weighted = sum(share[name] * above for name, *_, above in rows) / time if time else np.nan
    probabilities = [float(p) for p in next(iter(cases.values()))["probability"].values]
    headings = ("case", "pair", *(f"K_gamma in {percent(p)}" for p in probabilities), "limit", "above it [%]")
    columns = named_columns(headings, [(name, *own, 100 * above) for name, *own, above in rows])
    said = f"K_gamma is above its limit in {engineering(100 * weighted, 3)} % of the time, over all trains"
    said += f"; allocate takes one drawing for the duty with {100 * (1 - JUDGED_AT):.3g} %."
    return [Table(title="K_gamma over the load cases", columns=columns, lead=said if np.isfinite(weighted) else "")]


def _nearest(result: xr.Dataset) -> tuple[Any, ...]:
    """The pair nearest to its limit, its quantiles, the limit, and the share of the trains above it."""
    one = of_definition(result)
    quantiles = one["k_gamma_quantile"].transpose("pair", "probability").values
    verdict = k_gamma_verdict(result, "pair", quantiles[:, -1].tolist())
    if verdict is None:
        return "", *([np.nan] * quantiles.shape[1]), np.nan, np.nan
    pair = texts(result, "pair").index(verdict.name)
    at = np.flatnonzero(np.isclose(one["limit"].values, verdict.limit))
    above = float(one["exceedance"].transpose("pair", "limit").values[pair, at[0]]) if at.size else np.nan
    return pair_labels(texts(one, "pair"))[pair], *quantiles[pair].tolist(), verdict.limit, above


def _with_bands(one: xr.Dataset, name: str) -> list[str]:
    """Quantiles [1] with their bands; nothing of one that is not known."""
    rows = list(zip(*_ends(one, name), strict=True))
    bands = [("" if np.isnan(a) else f" [{a:.4f}, {b:.4f}]") for _, a, b in rows]
    return [f"{v:.4f}{band}" if np.isfinite(v) else "" for (v, *_), band in zip(rows, bands, strict=True)]


def _exceedance(result: xr.Dataset) -> Table:
    """Share of the trains above each limit by each definition, with a mesh that separates, whose contact opens [%]."""
    one = of_definition(result)
    rows: dict[str, Sequence[float]] = {}
    if "system_exceedance" in one:
        for i, limit in enumerate(one["limit"].values):
            for definition in texts(result, "definition"):
                own = of_definition(result, definition).isel(limit=i)
                name = _NAMES[_TURNING] if definition == _TURNING else "K_gamma"
                rows[f"{name} above {limit:g}"] = _ends(own, "system_exceedance")
    if "system_separation_probability" in one:
        rows["a mesh separates"] = _ends(one, "system_separation_probability")
    done = max(int(result.attrs.get("done", 1)), 1)
    rows["contact opens or a link plays"] = (int(result.attrs.get("open", 0)) / done, np.nan, np.nan)
    if int(result.attrs.get("failed", 0)):
        rows["no state, or no load to share"] = (int(result.attrs["failed"]) / done, np.nan, np.nan)
    headings = ("event", "share of the trains [%]", "low [%]", "high [%]")
    percents = [(name, *(100 * value for value in row)) for name, row in rows.items()]
    return Table(title="How often", columns=named_columns(headings, percents))


def _what_buys(result: xr.Dataset, names: Sequence[str]) -> Table:
    """What a tenth less spread of every entry takes off, by their places, shares of the variance, slopes."""
    one, ranking = of_definition(result), tenth_less(result)
    pair, order = scattering_pair(one), ranking.order
    at, p = f"K_gamma at {percent(ranking.probability)}", ranking.probability
    slope = one["quantile_slope"].isel(pair=pair).sel(probability=p).values
    micron = np.where(micrometres(one), 1e-6 * slope, np.nan)
    alone, total = (
        [share_with_band(*row) for row in zip(*_ends(one.isel(pair=pair), name), strict=True)]
        for name in ("sobol_first", "sobol_total")
    )
    columns: dict[str, Any] = {
        "place": [ranking.place(i) for i in order],
        "tolerance": [names[i] for i in order],
        f"a tenth less spread, {at}": [ranking.banded(i) for i in order],
        "alone [%]": [alone[i] for i in order],
        "with interactions [%]": [total[i] for i in order],
        f"{at} per µm of standard deviation [1/µm]": [float(f"{micron[i]:.3g}") + 0.0 for i in order],
    }
    several = ""
    if len(names) > 1:
        several = (
            "; tolerances of one place, as 1-2, are not told apart by them. Shares of the variance of K_gamma, "
            f"{pair_labels(texts(one, 'pair'))[pair]}, {overlap(one.isel(pair=pair))}"
        )
    lead = f"By what a tenth less spread changes {at}. In brackets: 95 % bands, of {ranking.samples} samples{several}."
    return Table(title="What buys what", columns=columns, lead=lead, digits=3)


def _ends(one: xr.Dataset, name: str) -> list[Any]:
    """An estimate and the ends of its band, of every entry; nan of a band that is not known."""
    ends = [one.get(f"{name}_{end}", one[name] * np.nan) for end in ("low", "high")]
    return [values.values.tolist() for values in (one[name], *ends)]


def _worst(result: xr.Dataset) -> Table:
    """Loads of the branches in the worst samples, one a column."""
    loads = result["worst_load_sharing"].transpose("mesh", "worst").values[:, :_WORST]
    carries = np.isfinite(loads).any(axis=1)
    loads = loads[carries]
    columns: dict[str, Any] = {"mesh": [*np.array(texts(result, "mesh"))[carries], "K_gamma"]}
    for place, (column, value) in enumerate(zip(loads.T, result["worst_k_gamma"].values, strict=False), start=1):
        columns[f"worst {place}"] = [f"{one:.3f}" for one in (*column, value)]
    return Table(title="Load over its equal share in the worst samples", columns=columns)


# --- allocate --------------------------------------------------------------------------------------------------------

_PROOF = {
    "samples": "no grades that meet the target cost less (proven on the samples of the search)",
    "monotone": "no grades that meet the target cost less, if finer grades never raise K_gamma",
    "open": "cheaper grades may be left: the search ended early",
}


def allocate_tables(result: xr.Dataset) -> Sequence[Table]:
    """Grade and price of every entry, its neighbours, the totals."""
    return _allocated(result, texts(result, "tolerance"))


def _allocated(result: xr.Dataset, names: Sequence[str]) -> list[Table]:
    """The tables with the entries by these names."""
    return [_grades(result, names), _neighbours(result, names), _totals(result), *_load_cases(result)]


def _load_cases(result: xr.Dataset) -> list[Table]:
    """K_gamma in every load case with the grades found, and how often it is above the target; nothing of one alone."""
    if "case" not in result.dims:
        return []
    columns: dict[str, Any] = {
        "case": texts(result, "case"),
        "time [%]": list(100 * result["case_share"].values),
        f"K_gamma in {percent(float(result.attrs['probability']))}": list(result["case_k_gamma"].values),
        "above the target [%]": list(100 * result["case_above"].values),
    }
    above = engineering(100 * float((result["case_share"] * result["case_above"]).sum()), 3)
    lead = f"With the grades found, fresh run: above the target in {above} % of the time of all trains."
    return [Table(title="The load cases", columns=columns, lead=lead)]


def allocate_sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """K_gamma over the price, and the tables."""
    from ...show.charts.sharing import grade_prices

    words = "Points: one entry changed by one grade. Steps: the cheapest grades for other targets."
    figure = Drawing(anchor="grade-prices", figure=grade_prices(result), caption=words)
    parts: list[Part] = [figure, *_allocated(result, short_entries(texts(result, "tolerance")))]
    return [Section(anchor="allocation", title="Allocation of tolerances", parts=parts)]


def allocate_key_figures(result: xr.Dataset) -> Sequence[KeyFigure]:
    """Total price, and the K_gamma that it reaches [1]."""
    return [
        (engineering(float(result["total_price"])), "price of the cheapest grades"),
        (f"{float(result['reached_k_gamma']):.4f}", f"K_gamma in {share_of_trains(result)} with them"),
    ]


def allocate_findings(result: xr.Dataset, company: Company) -> Sequence[Finding]:
    """What the grades found cost, and the K_gamma that they keep, against the target."""
    target, reached = float(result["target"]), float(result["reached_k_gamma"])
    source = result.attrs.get("target_source", "")  # a result of an earlier version has none
    kept = "keep" if passes(reached, target) else "MISS"
    text = (
        f"Grades for {engineering(float(result['total_price']))} {kept} the target of {target:g}"
        f"{f' ({source})' if source else ''}: K_gamma stays below {reached:.4f} in {share_of_trains(result)}."
    )
    tone = "good" if kept == "keep" else "bad"
    return [Finding(tone=tone, text=text, anchor="allocation", value=reached, limit=target)]


def _grades(result: xr.Dataset, names: Sequence[str]) -> Table:
    at = f"K_gamma at {percent(float(result.attrs['probability']))}"
    columns: dict[str, Any] = {
        "tolerance": names,
        "as drawn": texts(result, "drawn_grade"),
        "its price": list(result["drawn_grade_price"].values),
        "found": texts(result, "grade"),
        "price": list(result["price"].values),
    }
    reached, target = float(result["found_k_gamma"]), float(result["target"])
    lead = f"{at}: target {target:g}, {reached:.4f} with these grades, on {result.attrs['samples']} samples."
    return Table(title="The cheapest grades", columns=columns, lead=lead)


def _neighbours(result: xr.Dataset, names: Sequence[str]) -> Table:
    """What the next finer and the next coarser grade of every entry cost or save, and K_gamma with it."""
    columns: dict[str, Any] = {
        "tolerance": names,
        "next finer": texts(result, "finer_grade"),
        "costs": list(result["extra_cost"].values),
        "gives": [_factor(value) for value in result["finer_k_gamma"].values],
        "next coarser": texts(result, "coarser_grade"),
        "saves": list(result["saving"].values),
        "loses": [_factor(value) for value in result["coarser_k_gamma"].values],
    }
    at = percent(float(result.attrs["probability"]))
    lead = f"Gives, loses: K_gamma at {at} with this change alone."
    return Table(title="One grade finer or coarser", columns=columns, lead=lead)


def _factor(value: float) -> str:
    return f"{value:.4f}" if np.isfinite(value) else ""


def _totals(result: xr.Dataset) -> Table:
    at = f"K_gamma at {percent(float(result.attrs['probability']))}"
    low, high = (float(result[f"reached_k_gamma_{end}"]) for end in ("low", "high"))
    fresh = int(result.attrs["fresh_samples"])
    rows = {
        "total price": f"{float(result['total_price']):g}",
        "bound": f"{float(result['price_bound']):g}: {_PROOF[str(result.attrs['proof'])]}",
        f"{at}, fresh run of {fresh} samples": f"{float(result['reached_k_gamma']):.4f} [{low:.4f}, {high:.4f}]",
        f"{at}, as drawn": f"{float(result['drawn_k_gamma']):.4f}",
        "price as drawn": f"{float(result['drawn_price']):g}" if np.isfinite(result["drawn_price"]) else "not stated",
    }
    return Table(title="Totals", columns={"": list(rows), "value": list(rows.values())})


VIEWS = (
    ResultView(
        "tolerance",
        72,
        tolerance_tables,
        tolerance_sections,
        key_figures=tolerance_key_figures,
        findings=tolerance_findings,
        over_cases=tolerance_over_cases,
    ),
    ResultView(
        "allocate",
        155,
        allocate_tables,
        allocate_sections,
        key_figures=allocate_key_figures,
        findings=allocate_findings,
    ),
)
