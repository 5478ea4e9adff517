"""Several trains side by side: key figures with their differences, resonances and sections that match."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

import xarray as xr

from .elements import Drawing, Part, Section, Table
from .figures.operating_range import operating_range
from .figures.series import engineering
from .views import company_of, key_figures_of, sections_of

__all__ = ["VARIANTS", "difference_table", "section_titles", "variant_parts"]

Variants = Mapping[str, Mapping[str, xr.Dataset]]

VARIANTS = "variants"
"""Class of what stands side by side."""
_NUMBER = re.compile(r"^(-?[0-9.]+(?:e[+-]?[0-9]+)?)\s*(.*)$")


def difference_table(variants: Variants) -> Table:
    """Key figures of all trains, a row each, and how far the last is from the first [%].

    Rows match by what they are, not by where: a largest force in another mesh is the same row.
    """
    rows: dict[str, dict[str, tuple[str, str]]] = {}
    for name, datasets in variants.items():
        seen: dict[str, int] = {}
        for value, words in key_figures_of(datasets):
            what, _, where = _split(words)
            seen[what] = seen.get(what, 0) + 1
            key = what if seen[what] == 1 else f"{what} ({seen[what]})"
            rows.setdefault(key, {})[name] = (value, where)
    columns: dict[str, Any] = {"": list(rows)}
    for name in variants:
        columns[name] = [own.get(name, ("", ""))[0] for own in rows.values()]
    first, last = next(iter(variants)), list(variants)[-1]
    columns[f"{last} against {first}"] = [_change(own, first, last) for own in rows.values()]
    return Table(title="Key figures", columns=columns)


def variant_parts(variants: Variants, compared: xr.Dataset | None = None) -> list[Part]:
    """What stands first: the differences, and the range of speeds of every train in one figure.

    compared : result of `compare`, whose drawing and table say what differs in the drawings and what that does.
    """
    parts: list[Part] = [difference_table(variants)]
    companies = {name: company_of(datasets) for name, datasets in variants.items()}
    drawn = {
        name: (one.get("modes"), one.get("sweep")) for name, one in companies.items() if one.get("modes") is not None
    }
    figure = operating_range(drawn) if drawn else None
    if figure is not None:
        parts.append(Drawing(anchor="operating-range", figure=figure))
    if compared is not None:
        parts += [part for one in sections_of({"compare": compared}) for part in one.parts]
    return parts


def section_titles(every: Iterable[Iterable[Section]]) -> list[tuple[str, str]]:
    """Anchor and title of the sections of all trains, each once, in order."""
    return list(dict.fromkeys((one.anchor, one.title) for sections in every for one in sections if one.parts))


def _split(words: str) -> tuple[str, str, str]:
    """What a key figure is, and where: ``largest K_v at the operating speed: sun-planet 3``."""
    place = min((at for at in (words.find(mark) for mark in (":", ";")) if at >= 0), default=len(words))
    return words[:place], words[place : place + 1], words[place + 1 :].strip()


def _change(own: Mapping[str, tuple[str, str]], first: str, last: str) -> str:
    """``+3.1 %`` or ``-0.2`` from first to last; empty where either is no number or in another unit."""
    found = [_NUMBER.match(own.get(name, ("", ""))[0]) for name in (first, last)]
    if found[0] is None or found[1] is None or found[0][2] != found[1][2]:
        return ""
    before, after = float(found[0][1]), float(found[1][1])
    if before == after:
        return "="
    if found[0][2] == "%":  # a difference of shares is one in per cent points
        return f"{after - before:+.3g} points"
    return f"{100 * (after / before - 1):+.3g} %" if before else f"{engineering(after - before)}"
