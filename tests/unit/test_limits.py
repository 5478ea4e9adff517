"""Limits of K_gamma: which one counts, what a standard says, and that verbs and page hold K_gamma against it."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.cockpit.computing.compute import compute
from epicyclic.cockpit.state.frames import Request
from epicyclic.document.document import drive_text, ready_drives
from epicyclic.errors import ModelError
from epicyclic.limits import (
    NO_MATTER,
    SHIP,
    WIND,
    carries_load,
    k_gamma_limit,
    limit_in_short,
    nearest_limit,
    passes,
    peak_matters,
)
from epicyclic.questions.sharing.views import findings
from epicyclic.questions.tolerance.views import tolerance_findings
from epicyclic.train.resolution import load

FILE = {"limits": {"k_gamma": 1.2, "stages": {"low": {"k_gamma": 1.3}, "high": {"k_gamma": SHIP}}}}


def test_a_peak_matters_from_a_twentieth_above_its_surroundings() -> None:
    height = np.array([104.9, 105.1, 210.0, 1.0])
    assert peak_matters(height, height - [100.0, 100.0, 100.0, 0.0]).tolist() == [False, True, True, True]
    assert NO_MATTER == 0.05


def test_an_option_goes_before_stage_file_and_table() -> None:
    found = [k_gamma_limit(FILE, stage, 5, stated=1.05) for stage in ("low", "high", "other")]
    assert [(limit.value, limit.source) for limit in found] == [(1.05, "the option limit")] * 3
    low, high, other = (k_gamma_limit(FILE, stage, 5) for stage in ("low", "high", "other"))
    assert (low.value, low.source) == (1.3, "limits.stages.low.k_gamma")
    assert high.value == 1.30
    assert high.source.startswith("5 planets, IACS UR M56")
    assert (other.value, other.source) == (1.2, "limits.k_gamma")
    assert k_gamma_limit({}, "low", 5).source == "5 planets, IEC 61400-4:2012"


@pytest.mark.parametrize(
    ("table", "factors"),
    [
        (WIND, [1.00, 1.00, 1.10, 1.25, 1.35, 1.44, 1.47, 1.47, 1.47]),
        (SHIP, [1.00, 1.00, 1.00, 1.20, 1.30, 1.40, 1.40, 1.40, 1.40]),
    ],
)
def test_tables_of_standards(table: str, factors: list[float]) -> None:
    found = [k_gamma_limit({}, "main", planets, stated=table) for planets in range(1, 10)]
    assert [limit.value for limit in found] == factors
    # the ship rule ends with "6 and more", the table of the wind standard with 7
    beyond = ["ends" in limit.source for limit in found]
    assert beyond == [table == WIND and planets > 7 for planets in range(1, 10)]


def test_equal_shares_meet_a_limit_of_one() -> None:
    assert passes(1.0 + 1e-9, 1.0)
    assert not passes(1.001, 1.0)
    # of a limit of 1.35 a tenth of the room is taken, of that of 1.1 nothing
    assert nearest_limit([1.0, 1.035, 1.0], [1.1, 1.35, 1.0]) == 1
    assert nearest_limit([1.2, 1.01, np.nan], [1.25, 1.0, 1.0]) == 1
    assert nearest_limit([1.3, 1.11], [1.25, 1.1]) == 0
    assert nearest_limit([np.nan], [1.0]) is None


@pytest.mark.parametrize(
    ("change", "path"),
    [
        ({"limits.k_gamma": 0.9}, "limits.k_gamma"),
        ({"limits.k_gamma": "IEC"}, "limits.k_gamma"),
        ({"limits.stages.mainx.k_gamma": 1.2}, "limits.stages.mainx"),
        ({"limits.k_gama": 1.2}, "limits.k_gama"),
    ],
)
def test_a_limit_that_is_none_is_refused(change: dict[str, object], path: str) -> None:
    with pytest.raises(ModelError) as caught:
        load("ren2021", change)
    assert caught.value.path == path
    assert caught.value.allowed or "did you mean" in caught.value.problem


@pytest.mark.parametrize("verb", [epicyclic.sharing, epicyclic.tolerance])
def test_an_option_that_is_no_limit_is_refused(verb: Any) -> None:
    limit: Any = 0.5 if verb is epicyclic.sharing else (0.5,)
    with pytest.raises(ModelError) as caught:
        verb("wind-stage", limit=limit)
    assert (caught.value.path, caught.value.given) == ("limit", 0.5)


def page_of(train: str) -> Mapping[str, Any]:
    (frame,) = compute(Request(rev=1, kind="live", source=tomllib.loads(drive_text(train))))
    return frame.head


@pytest.mark.parametrize("drive", ready_drives())
def test_verbs_and_page_hold_a_ready_drive_against_one_limit(drive: str) -> None:
    checked = epicyclic.check(drive)
    limits = dict(zip(checked.stage.values.tolist(), checked.k_gamma_limit.values.tolist(), strict=True))
    head = page_of(drive)
    if "sharing" not in head:
        with pytest.raises(ModelError, match="no mesh carries any"):
            epicyclic.sharing(drive, method="static", cycles=1, samples=16)
        return
    shared = epicyclic.sharing(drive, method="static", cycles=1, samples=16)
    stages = [name.split("/")[0] for name in shared.mesh.values.tolist()]
    assert shared.k_gamma_limit.values.tolist() == [limits[stage] for stage in stages]
    mean = shared.load_sharing.sel(definition="mean-load").values
    over = mean - shared.k_gamma_limit.values
    verdict = head["sharing"]["verdict"]
    assert verdict["passes"] == bool(np.nanmax(over) <= 5e-7)
    judged = np.isclose(mean, verdict["value"], atol=2e-6) & (shared.k_gamma_limit.values == verdict["limit"])
    assert judged.any()
    (said,) = [one for one in findings(shared, {}) if "K_gamma" in one.text]
    assert (
        f"limit {verdict['limit']:g} ({verdict['source']}): {'passes' if verdict['passes'] else 'FAILS'}" in said.text
    )
    if "tolerance" in epicyclic.load(drive).document:
        drawn = epicyclic.tolerance(drive, samples=256, effects="none")
        assert drawn.k_gamma_limit.values.tolist() == [
            limits[pair.split(".")[0]] for pair in drawn.pair.values.tolist()
        ]
        assert drawn.limit.values.tolist() == sorted(set(drawn.k_gamma_limit.values.tolist()))
        assert f"limit {verdict['limit']:g}" in tolerance_findings(drawn, {})[0].text
        # where tolerances are known they decide
        (drawing,) = [one for one in findings(shared, {"tolerance": drawn}) if "K_gamma" in one.text]
        assert "limit" not in drawing.text


@pytest.mark.parametrize(("limit", "tone"), [(1.001, "bad"), (1.3, "good")])
def test_one_limit_of_the_file_is_that_of_all(limit: float, tone: str) -> None:
    changes: dict[str, object] = {"limits.k_gamma": limit}
    shared = epicyclic.sharing("wind-stage", method="static", cycles=1, samples=16, overrides=changes)
    (said,) = [one for one in findings(shared, {}) if "K_gamma" in one.text]
    drawn = epicyclic.tolerance("wind-stage", samples=1024, effects="none", overrides=changes)
    assert drawn.limit.values.tolist() == [limit]
    assert [said.tone, tolerance_findings(drawn, {})[0].tone] == [tone, tone]
    assert "limits.k_gamma" in said.text
    request = Request(rev=1, kind="live", source=tomllib.loads(drive_text("wind-stage")), overrides=changes)
    (frame,) = compute(request)
    (answer,) = [one for one in frame.head["answers"] if one["key"] == "planet"]
    assert (answer["level"], f"Limit {limit:g}" in answer["text"]) == (tone, True)
    source = {"words": "of the model", "source": "limits.k_gamma", "path": "limits.k_gamma"}
    assert answer["limit"] == {"value": limit, **source}


def test_allocate_aims_at_the_limit_of_the_page() -> None:
    changes: dict[str, object] = {"limits.k_gamma": 1.12}
    found = epicyclic.allocate("wind-five", samples=1024, fresh_samples=1024, overrides=changes)
    assert (float(found.target), found.attrs["target_source"]) == (1.12, "limits.k_gamma")


def test_a_limit_says_in_short_where_it_is_from_and_where_it_is_set() -> None:
    assert limit_in_short("4 planets, IEC 61400-4:2012") == ("4 planets, table", "limits.k_gamma")
    assert limit_in_short("limits.stages.main.k_gamma") == ("of the model", "limits.stages.main.k_gamma")


def test_a_limit_of_the_stage_goes_before_that_of_the_file() -> None:
    changes: dict[str, object] = {"limits.k_gamma": 1.3, "limits.stages.main.k_gamma": 1.07}
    drawn = epicyclic.tolerance("wind-stage", samples=256, effects="none", overrides=changes)
    shared = epicyclic.sharing("wind-stage", method="static", cycles=1, samples=16, overrides=changes)
    for result in (drawn, shared):
        assert set(result.k_gamma_limit.values.tolist()) == {1.07}
        assert set(result.k_gamma_limit_source.values.tolist()) == {"limits.stages.main.k_gamma"}


def test_of_too_few_trains_a_pass_is_open() -> None:
    """512 trains tell no 99 %: what exceeds its limit in 95 % fails, what passes there may fail with more of them."""
    drawn = epicyclic.tolerance("wind-five", samples=512, effects="none", limit=[1.1])
    assert 0.99 not in drawn.probability.values
    for limit, tone, words in ((1.1, "caution", "open at 99 %, for more samples"), (1.001, "bad", "FAILS")):
        (finding,) = tolerance_findings(drawn.assign(k_gamma_limit=("pair", [limit] * drawn.sizes["pair"])), {})
        assert (finding.tone, words in finding.text) == (tone, True)
        assert "in 95\u00a0%" in finding.text or "in 95 %" in finding.text


def test_the_turning_load_is_that_of_the_pair_that_is_judged() -> None:
    drawn = epicyclic.tolerance("wind-five", samples=2048, effects="none")
    drawn["k_gamma_quantile"] = 0.98 * drawn.k_gamma_quantile  # the pairs are worst in one and the same train
    turning = drawn.sel(definition="mean-load-turning", probability=0.99)
    least = int(turning.k_gamma_quantile.values.argmin())
    limits = ("pair", [1.01 if pair == least else 2.0 for pair in range(drawn.sizes["pair"])])
    (finding,) = tolerance_findings(drawn.assign(k_gamma_limit=limits), {})
    own = float(turning.k_gamma_quantile[least])
    assert f"{own:.3f}" != f"{float(turning.system_k_gamma_quantile):.3f}"
    assert f"while turning below {own:.3f}" in finding.text


def test_the_nearest_limit_is_found_however_wide() -> None:
    assert nearest_limit([1.0, 1.2, 1.2], [1e6] * 3) == 1
    assert nearest_limit([1.0, 1.2, 1.2], [1.25] * 3) == 1
    assert nearest_limit([1.1, 1.2, float("nan")], [1.0, 1.25, 1.1]) == 0


def test_of_one_limit_the_train_is_judged_of_several_the_pair() -> None:
    """Where pairs are worst in other trains each the train is worse than any pair: a limit between them fails it."""
    drawn = epicyclic.tolerance("wind-five", samples=2048, effects="none")
    drawn["k_gamma_quantile"] = 0.98 * drawn.k_gamma_quantile
    mean = drawn.sel(definition="mean-load", probability=0.99)
    system, pairs = float(mean.system_k_gamma_quantile), mean.k_gamma_quantile.values
    between = (pairs.max() + system) / 2
    assert pairs.max() < system
    one, *_ = tolerance_findings(drawn.assign(k_gamma_limit=("pair", [between] * len(pairs))), {})
    assert (one.tone, one.value, one.limit) == ("bad", system, between)
    assert f"K_gamma stays below {system:.3f}" in one.text.replace("\u00a0", " ")
    wide = [between, *[2.0] * (len(pairs) - 1)]
    several, *_ = tolerance_findings(drawn.assign(k_gamma_limit=("pair", wide)), {})
    assert (several.tone, several.value, several.limit) == ("good", pairs[0], between)
    assert f"K_gamma of {str(drawn.pair.values[0]).replace('.meshes.', ' ')} stays below" in several.text


def test_a_verdict_says_what_it_rests_on() -> None:
    changes: dict[str, object] = {"deviations.planet.position.y": "[20, 0, 0] um"}
    said = []
    for assumed in ({}, {'assumed."deviations.planet.position.y"': "no drawing"}):
        shared = epicyclic.sharing("ren2021", cycles=2, overrides={**changes, **assumed})
        (one,) = [one.text for one in findings(shared, {}) if "K_gamma" in one.text]
        source = tomllib.loads(drive_text("ren2021"))
        (frame,) = compute(Request(rev=1, kind="live", source=source, overrides={**changes, **assumed}))
        (answer,) = [one["assumed"] for one in frame.head["answers"] if one["key"] == "planet"]
        said.append(["with assumed deviations" in one, "deviations.main.planet.position.y" in answer])
    assert said == [[False, False], [True, True]]


def test_a_mesh_idles_beside_the_most_loaded_one_of_its_own_stage() -> None:
    load = np.array([100.0, 4.9, 5.0, 3.0, 0.2, 0.1])
    stage = ["fast", "fast", "fast", "slow", "slow", "slow"]
    assert carries_load(load, stage).tolist() == [True, False, True, True, True, False]
    assert carries_load(load[::-1], stage[::-1]).tolist() == [False, True, True, True, False, True]
