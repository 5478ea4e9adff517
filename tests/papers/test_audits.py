"""The audits that come with the package: nothing is contradicted, and the pages say the same."""

from __future__ import annotations

import importlib.util
import time
from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.audits.audit_file import audited_drives, read_audit
from epicyclic.show.views.audit import tally

PAGES = Path(__file__).parents[2] / "docs" / "drives"
SLOW: tuple[str, ...] = ()  # drives whose audit takes more than ten seconds
MOST_SECONDS = 60.0  # of one audit; all together are to take less than five minutes on one core


@cache
def audited(drive: str) -> xr.Dataset:
    return epicyclic.audit(drive)


@pytest.mark.parametrize(
    "drive", [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in audited_drives()]
)
def test_nothing_is_contradicted(drive: str) -> None:
    started = time.process_time()
    result = audited(drive)
    assert result.sizes["row"] > 0
    wrong = result.isel(row=np.flatnonzero(result.outcome.values != "holds"))
    columns = (wrong.quantity.values, wrong.published_text.values, wrong.ours.values, wrong.outcome.values)
    assert list(zip(*(column.tolist() for column in columns), strict=True)) == []
    assert ", 0 contradicted" in tally(result)[drive]
    assert time.process_time() - started < MOST_SECONDS


@pytest.mark.parametrize("drive", audited_drives())
def test_every_run_is_used(drive: str) -> None:
    _, audit = read_audit(drive)
    used = {name for row in audit.rows if row.ours for name in row.ours.runs()}
    for name in sorted(used):
        while (name := audit.runs[name].based_on or "") and name not in used:
            used.add(name)
    assert set(audit.runs) - used == set()


def test_verdicts_of_lin1999() -> None:
    """18 distinct frequencies, and 3 of the N = 4 column that differ from the print, up to 727.27 against 727.0."""
    counts = {planets: Counter(audited(f"lin1999-n{planets}").verdict.values.tolist()) for planets in (3, 4, 5)}
    assert counts[3] == {"reproduced": 14}
    assert counts[4] == {"reproduced": 15, "not reproducible": 3}
    assert counts[5] == {"reproduced": 18}


def test_verdicts_of_ren2021() -> None:
    """None of its three load-sharing coefficients follows from the source; what it says of curves mostly does."""
    result = audited("ren2021")
    numbers = np.flatnonzero(np.isin(result.published.values, [1.10, 1.043, 1.15]))
    assert len(numbers) == 10
    part = result.isel(row=numbers)
    assert Counter(part.verdict.values.tolist()) == {"not reproducible": 9, "under a reading": 1}
    assert part.fitted.values[part.verdict.values == "under a reading"].tolist() == [True]


def test_verdicts_of_encased_differential() -> None:
    """One load-sharing coefficient follows without a fitted phase; both tables do not."""
    result = audited("encased-differential")
    reading = result.isel(row=np.flatnonzero(result.published.values == 1.0233))
    assert Counter(reading.verdict.values.tolist()) == {"under a reading": 1, "not reproducible": 2}
    assert not reading.fitted.values.any()
    tables = np.flatnonzero([" um" in name and name.startswith("B_") for name in result.quantity.values.tolist()])
    numbers = [at for at in tables.tolist() if 1 < result.published.values[at] < 2]
    assert len(numbers) == 16
    assert set(result.verdict.values[numbers].tolist()) == {"not reproducible"}
    # two fitted numbers, and four that these phases then fail to give
    assert result.fitted.values.sum() == 6


def test_the_table_of_the_page_on_lin1999() -> None:
    text = (PAGES / "lin1999.md").read_text(encoding="utf-8")
    for planets in (3, 4, 5):
        result = audited(f"lin1999-n{planets}")
        for published, ours, unit in zip(
            result.published.values, result.ours.values, result.published_unit.values, strict=True
        ):
            assert unit != "Hz" or f"| {published:.1f} | {ours + 0.0:.1f} |" in text


@pytest.mark.parametrize("page", sorted(PAGES.glob("*.md")), ids=lambda page: page.stem)
def test_pages_have_their_figures(page: Path) -> None:
    shown = set(page.read_text(encoding="utf-8").split("figures/")[1:])
    names = {name.split(".svg")[0] for name in shown}
    drawn = {path.stem for path in (PAGES / "figures").glob(f"{page.stem}-*.svg")}
    assert names == drawn
    assert page.stem == "README" or {f"{page.stem}-{name}" for name in make().figures_of(page.stem)} == drawn
    assert all((PAGES / "figures" / f"{name}.svg").stat().st_size < 200_000 for name in names)


@cache
def make() -> Any:
    spec = importlib.util.spec_from_file_location("drives_make", PAGES / "make.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ["frequencies", "differences", "shapes"])
def test_a_figure_can_be_drawn_again(name: str) -> None:
    drawn = make().figures_of("lin1999")[name]()
    assert len(drawn.data) > 3
    titles = [drawn.layout[axis].title.text for axis in drawn.layout if axis.startswith(("xaxis", "yaxis"))]
    assert name == "shapes" or any("[Hz]" in title for title in titles if title)


@pytest.mark.browser
def test_the_drawing_is_repeatable() -> None:
    pytest.importorskip("playwright.sync_api")
    module = make()
    drawn = module.figures_of("lin1999")["differences"]()
    try:
        with module.renderer() as to_svg:
            texts = [to_svg(drawn, "lin1999-differences") for _ in range(2)]
    except SystemExit as missing:
        pytest.skip(str(missing))
    assert texts[0] == texts[1]
    assert texts[0].startswith("<svg")
    assert "ours less published [Hz]" in texts[0]


def test_every_audited_drive_has_a_page() -> None:
    index = (PAGES / "README.md").read_text(encoding="utf-8")
    missing = [drive for drive in audited_drives() if f"`{drive}`" not in index]
    assert missing == []
