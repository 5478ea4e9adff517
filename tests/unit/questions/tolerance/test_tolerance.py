"""The verb tolerance: closed forms through it, the same bits by every engine, worst samples, curves, bad input."""

from __future__ import annotations

import copy
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

import epicyclic
from epicyclic.cli.main import app
from epicyclic.document.document import drive_titles
from epicyclic.engine import plan as plan_module
from epicyclic.engine.plan import SamplingPlan
from epicyclic.errors import ModelError
from epicyclic.questions.tolerance.effects import SCALES, variance_shares

# four equal planets round a floating sun, mesh and pin stiffnesses given: TIP is the gap of a pin per its error
MODULE, TEETH, TORQUE, ANGLE = 4e-3, 24, 800.0, math.radians(20)
SUN_MESH, RING_MESH, PIN = 9.206e8, 1.2634e9, 4e8
FORCE = TORQUE / (4 * MODULE * TEETH / 2 * math.cos(ANGLE))
TIP = 2 * math.cos(ANGLE)
PATH_STIFFNESS = 1 / (1 / SUN_MESH + 1 / RING_MESH + TIP**2 / PIN)
POSITION = "deviations.main.planet.position.y"


def floating(**tables: Any) -> dict[str, Any]:
    """The model; tables : put in at the top."""
    model: dict[str, Any] = {
        "format": 2,
        "title": "four planets, sun floating",
        "stages": {
            "main": {
                "planets": 4,
                "module": "4 mm",
                "sun": {"teeth": TEETH, "mass": "1 kg", "inertia": "1 kg", "support": {"radial": "0 N/m"}},
                "planet": {"teeth": 18, "mass": "1 kg", "inertia": "1 kg", "bearing": {"radial": f"{PIN!r} N/m"}},
                "ring": {"teeth": 60, "mass": "1 kg", "inertia": "1 kg"},
                "carrier": {"mass": "1 kg", "inertia": "1 kg"},
                "meshes": {
                    "sun-planet": {"stiffness": f"{SUN_MESH!r} N/m"},
                    "planet-ring": {"stiffness": f"{RING_MESH!r} N/m"},
                },
            }
        },
        "operation": {"held": ["ring"], "torque": {"sun": f"{TORQUE!r} N m"}},
    }
    return copy.deepcopy(model) | tables


def gaussian(spread: float) -> dict[str, Any]:
    """Gaussian pins with sigma k / F0 = spread."""
    sigma = spread * FORCE / (PATH_STIFFNESS * TIP)
    return floating(tolerance={POSITION: f"normal(0 um, {sigma * 1e6!r} um)"})


@pytest.fixture
def few_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pieces of 256 rows: the least number of samples fills one, which else is filled up to 8192 rows."""
    monkeypatch.setattr(plan_module, "PIECE", 256)


@pytest.mark.usefixtures("few_rows")
def test_check_case() -> None:
    model = floating(
        deviations={"main": {"planet": {"position": {"y": "[20, 0, 0, 0] um"}}}},
        tolerance={"operation.torque.sun": f"normal({TORQUE!r} N m, 0 N m)"},
    )
    found = epicyclic.tolerance(model, samples=256, effects="none")
    expected = 1 + 0.25 * PATH_STIFFNESS * TIP * 20e-6 / FORCE
    assert expected == pytest.approx(1.19791, abs=5e-6)
    for name in ("system_k_gamma_quantile", "system_k_gamma_quantile_low", "system_k_gamma_quantile_high"):
        assert found[name].values == pytest.approx(expected, abs=1e-4 * (expected - 1))
    assert found.system_k_gamma_mean.values == pytest.approx(expected, abs=1e-9)
    assert found.system_k_gamma_std.values == pytest.approx(0, abs=1e-7)
    assert found.worst_k_gamma.values == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("planets", "more"), [(3, 0), (5, 3)])
def test_one_planet_that_carries_all_is_the_end_of_k_gamma(planets: int, more: int) -> None:
    """A fixed sun at low torque: most trains are at K = N, which no quantile exceeds and no limit below misses."""
    model = floating(tolerance={POSITION: "normal(0, 200 um)"})
    stage = model["stages"]["main"]
    del stage["sun"]["support"]
    stage |= {"planets": planets}
    for name, teeth in (("planet", 18 + more), ("ring", 60 + 2 * more)):
        stage[name]["teeth"] = teeth
    model["operation"]["torque"]["sun"] = "20 N m"
    found = epicyclic.tolerance(model, samples=2048, effects="none", limit=(planets * 0.99, planets))
    assert found.system_k_gamma_quantile.sel(probability=0.99).values == pytest.approx(planets, abs=1e-9)
    assert found.system_k_gamma_quantile_high.max() <= planets + 1e-9
    assert found.load_sharing_quantile_high.max() <= planets + 1e-9
    assert found.k_gamma_quantile.max() <= planets + 1e-9
    below, at = found.system_exceedance.sel(definition="mean-load").values
    assert below > 0.3
    assert at == 0


def test_a_run_of_weeks_is_refused() -> None:
    with pytest.raises(ModelError, match="would take some") as error:
        epicyclic.tolerance(gaussian(1.0), samples=10**12)
    assert error.value.path == "samples"
    assert "at most" in error.value.allowed


def test_a_run_of_hours_is_refused_without_a_store(tmp_path: Path) -> None:
    """Links with play take milliseconds a sample, which a few samples say; with a store the run may be stopped."""
    play: dict[str, object] = {"stages.main.sun.support.clearance": "5 mm"}
    play["tolerance"] = {"deviations.star1.position": "disc(20 um)"}
    options: dict[str, Any] = {"overrides": play, "samples": 2**22, "effects": "none"}
    with pytest.raises(ModelError, match=r"some [\d.]+ (h|days), of 60 min that a run may take") as error:
        epicyclic.tolerance("dong2019", **options)
    assert "store" in error.value.allowed

    def stopped(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        epicyclic.tolerance("dong2019", **options, store=tmp_path / "store", progress=stopped)


RADIAL, TORQUES = POSITION[:-1] + "x", "operation.torque.sun"


@pytest.mark.parametrize(
    ("entries", "idle"),
    [
        ({RADIAL: "uniform(-20 um, 20 um)"}, [RADIAL]),  # equal working angles: a planet shifts and turns
        ({TORQUES: "normal(800 N m, 40 N m)"}, ["operation.torque.main.sun"]),  # in proportion, without any error
        ({POSITION: "uniform(20 um, 20 um)"}, [POSITION]),  # no spread
        # pins off: X = k e / F0 follows the torque
        ({POSITION: "normal(0, 10 um)", TORQUES: "normal(800 N m, 40 N m)"}, []),
        ({POSITION: "normal(0, 10 um)", RADIAL: "normal(0, 10 um)"}, [RADIAL]),
        ({"stages.main.planet.bearing.radial": "normal(4e8 N/m, 1e7 N/m)"}, []),  # paths of unequal stiffness
        ({"deviations.main.meshes.sun-planet.profile": "normal(0, 4 um)"}, ["main.meshes.sun-planet.profile"]),
    ],
)
@pytest.mark.usefixtures("few_rows")
def test_what_moves_k_gamma_by_nothing_is_named(entries: dict[str, str], idle: list[str]) -> None:
    found = epicyclic.tolerance(floating(tolerance=entries), samples=256, effects="none")
    warned = [text for text in json.loads(found.attrs["warnings"]) if "tolerance-without-effect" in text]
    assert len(warned) == len(idle)
    assert all(path in text for path, text in zip(idle, warned, strict=True))


@pytest.mark.usefixtures("few_rows")
def test_run_out_that_averages_out_is_told_apart() -> None:
    model = floating(tolerance={"deviations.main.planet.run_out": "rayleigh(5 um)"})
    model["operation"]["speed"] = {"carrier": "60 rpm"}
    (text,) = json.loads(epicyclic.tolerance(model, samples=256, effects="none").attrs["warnings"])
    assert "deviations.main.planet.run_out moves K_gamma" in text
    assert "the largest load while turning follows" in text


@pytest.mark.parametrize(
    ("planets", "saturated"), [(3, (1.0, 1.0)), (4, (2.0, 2.0)), (5, (1.809, 2.236)), (6, (1.667, 3.0))]
)
@pytest.mark.usefixtures("few_rows")
def test_one_pin_ahead_and_behind(planets: int, saturated: tuple[float, float]) -> None:
    """K - 1 = X (1 - 3/n) of a pin ahead and X (1 + 2 cos(2 pi / n)) / n of one behind, until a mesh opens for good."""
    force = FORCE * 4 / planets
    ahead, behind = 1 - 3 / planets, max((1 + 2 * math.cos(2 * math.pi / planets)) / planets, 0.0)
    # X = k e / F0: closed, and far behind the opening of a mesh
    for size, expected in ((0.3, sorted((1 + 0.3 * behind, 1 + 0.3 * ahead))), (40.0, list(saturated))):
        error = size * force / (PATH_STIFFNESS * TIP) * 1e6
        found = []
        for sign in (1, -1):
            pins = [f"{sign * error!r}", *["0"] * (planets - 1)]
            model = floating(
                deviations={"main": {"planet": {"position": {"y": f"[{', '.join(pins)}] um"}}}},
                tolerance={"operation.torque.sun": f"normal({TORQUE!r} N m, 0 N m)"},
            )
            model["stages"]["main"]["planets"] = planets
            mean = epicyclic.tolerance(model, samples=16, effects="none").system_k_gamma_mean
            found.append(float(mean.sel(definition="mean-load")))
        assert sorted(found) == pytest.approx(expected, abs=1e-9 if size < 1 else 6e-4)


def test_gaussian_pins_within_the_band() -> None:
    found = epicyclic.tolerance(gaussian(0.2), samples=2**15, limit=[1.1, 1.2], effects="none")
    expected = 1 + 0.2 * 0.5 * ndtri((1 + found.probability.values) / 2)  # half a half-normal
    value, low, high = (
        found[f"k_gamma_quantile{end}"].sel(definition="mean-load").values[0] for end in ("", "_low", "_high")
    )
    assert ((low <= expected) & (expected <= high)).sum() >= 4  # of five bands of 95 %
    assert np.abs(value - expected).max() < 2 * (high - low).max()
    assert (high - low < 0.05 * (expected - 1)).all()
    above = 2 * ndtr(-np.array([0.1, 0.2]) / 0.1)
    assert found.exceedance.values[0, 0] == pytest.approx(above, abs=6e-3)
    assert int(found.attrs["open"]) == 0
    # without run-outs nothing turns
    assert found.k_gamma_quantile[1].values == pytest.approx(found.k_gamma_quantile[0].values, rel=1e-9)


def test_separation_of_four_planets() -> None:
    found = epicyclic.tolerance(gaussian(1.25), samples=2**13, effects="none")
    expected = 2 * ndtr(-2 / 1.25)
    low, high = (float(found[f"system_separation_probability_{end}"]) for end in ("low", "high"))
    assert low <= expected <= high
    assert high - low < 0.02
    assert int(found.attrs["open"]) == round(float(found.system_separation_probability) * 2**13)
    # two planets carry all from there on
    assert found.worst_k_gamma.values == pytest.approx(2.0, abs=1e-6)


def loaded_drives() -> list[str]:
    """Ready drives with planets and a torque."""
    trains = {name: epicyclic.load(name) for name in drive_titles()}
    return [name for name, train in trains.items() if train.torques and max(train.planets.values()) > 1]


@pytest.mark.parametrize("name", loaded_drives())
@pytest.mark.usefixtures("few_rows")
def test_drives_without_errors_share_equally(name: str) -> None:
    train = epicyclic.load(name)
    uneven = ("deviations", "tolerance", "loads", "assumed")
    document = {key: value for key, value in train.document.items() if key not in uneven}
    pair = train.meshes[0].pair.removeprefix("stages.")
    document["operation"] = {**document["operation"], "gravity": False}  # type: ignore[dict-item]
    document["tolerance"] = {f"deviations.{pair}.gap": "normal(0 um, 0 um)"}
    found = epicyclic.tolerance(document, samples=256, effects="none")
    for kind in ("", "_low", "_high"):
        assert found[f"system_k_gamma_quantile{kind}"].values == pytest.approx(1, abs=1e-9)
        assert found[f"load_sharing_quantile{kind}"].values == pytest.approx(1, abs=1e-9)


def test_the_same_bits_by_one_process_two_workers_and_resumed(tmp_path: Path) -> None:
    options: dict[str, Any] = {"samples": 2**14, "effects": "none", "raw": True}
    alone = epicyclic.tolerance("ren2021", **options)
    store = tmp_path / "store"

    class Stop(Exception):
        pass

    def stop(done: float) -> None:
        if done >= 0.5:
            raise Stop

    with pytest.raises(Stop):
        epicyclic.tolerance("ren2021", store=store, progress=stop, **options)
    assert epicyclic.tolerance("ren2021", store=store, resume=True, **options).identical(alone)
    assert epicyclic.tolerance("ren2021", workers=2, **options).identical(alone)
    with pytest.raises(ModelError, match=r"other options \(seed\); allowed: seed = 1"):
        epicyclic.tolerance("ren2021", store=store, resume=True, samples=2**14, seed=2, effects="none", raw=True)


def test_raw_samples_are_those_of_the_statistics() -> None:
    found = epicyclic.tolerance("ren2021", samples=2**11, effects="none", raw=True)
    k = found.k_gamma_sample.sel(definition="mean-load")
    assert k.shape == (2**11, 4)
    assert k.mean("sample").values == pytest.approx(found.k_gamma_mean[0].values, rel=1e-12)
    system = k.max("pair")
    order = np.lexsort((np.arange(2**11), -system.values))[:10]
    assert np.array_equal(found.worst_sample.values, order)
    assert np.array_equal(found.worst_k_gamma.values, system.values[order])
    with pytest.raises(ModelError, match="do not fit"):
        epicyclic.tolerance("ren2021", samples=2**23, raw=True)


@pytest.mark.parametrize("name", ["ren2021", "wind-five"])
@pytest.mark.usefixtures("few_rows")
def test_worst_samples_are_model_files_with_their_value(name: str, tmp_path: Path) -> None:
    found = epicyclic.tolerance(name, samples=256, effects="none", worst=tmp_path / "worst")
    files = sorted((tmp_path / "worst").iterdir())
    assert [file.name for file in files] == [f"worst-{place:02d}.toml" for place in range(1, 11)]
    for place in (0, 9):
        sharing = epicyclic.sharing(files[place], method="static", cycles=1, samples=2)
        value = float(sharing.system_load_sharing.sel(definition="mean-load"))
        assert value == pytest.approx(float(found.worst_k_gamma[place]), rel=1e-9)
        loads = sharing.load_sharing.sel(definition="mean-load").values
        assert loads == pytest.approx(found.worst_load_sharing[place].values, rel=1e-9)
        train = epicyclic.load(files[place])
        assert f"K_gamma {value:.6f}"[:14] in train.title
        assert "tolerance" not in train.document
    again = epicyclic.load(name, overrides=json.loads(str(found.worst_overrides.values[0])))
    assert len(again.displacements) == len(epicyclic.load(files[0]).displacements)


def test_trains_without_load_are_told_and_count_nowhere() -> None:
    """A torque drawn below zero: nothing of the nominal sense is left to share."""
    model = gaussian(0.1)
    spread = float(TORQUE / -ndtri(0.02))  # 2 % of the draws
    model["tolerance"]["operation.torque.sun"] = f"normal({TORQUE!r} N m, {spread!r} N m)"
    found = epicyclic.tolerance(model, samples=2**12)
    assert int(found.attrs["failed"]) == pytest.approx(0.02 * 2**12, rel=0.2)
    assert any("no load of the nominal sense" in text for text in json.loads(found.attrs["warnings"]))
    for name in ("system_k_gamma_quantile", "system_k_gamma_mean", "worst_k_gamma", "worst_load_sharing"):
        assert np.isfinite(found[name].values).all()


def test_equal_shares_do_not_exceed_one() -> None:
    model = gaussian(0.2)
    model["stages"]["main"]["planets"] = 3
    found = epicyclic.tolerance(model, samples=2**10, limit=[1.0], effects="none")
    assert found.system_exceedance.values == pytest.approx(0, abs=0)
    four = epicyclic.tolerance(gaussian(0.2), samples=2**10, limit=[1.0], effects="none")
    assert four.system_exceedance.sel(definition="mean-load").values == pytest.approx(1, abs=0)


def test_worst_samples_overwrite_nothing(tmp_path: Path) -> None:
    (tmp_path / "worst-01.toml").write_text("precious", encoding="utf-8")
    with pytest.raises(ModelError, match="not empty") as error:
        epicyclic.tolerance(gaussian(0.2), samples=256, effects="none", worst=tmp_path)
    assert error.value.path == "worst"
    assert (tmp_path / "worst-01.toml").read_text(encoding="utf-8") == "precious"


def test_curves_of_a_linear_response() -> None:
    model = gaussian(0.1)
    model["stages"]["main"]["sun"]["support"]["radial"] = "10 N/m"
    found = epicyclic.tolerance(model, samples=2**13, effects="all")
    assert tuple(found.scale.values) == SCALES
    shown = found.probability.values <= 0.99
    nominal = found.k_gamma_by_scale.sel(scale=1.0)[0].values[shown] - 1
    assert nominal == pytest.approx(0.1 * 0.5 * ndtri((1 + found.probability.values[shown]) / 2), rel=0.1)
    for name, power in (("k_gamma_by_scale", 1), ("k_gamma_by_torque", -1)):
        curve = found[name].squeeze("tolerance") if "tolerance" in found[name].dims else found[name]
        factors = curve[curve.dims[0]].values
        assert curve.values[:, shown] - 1 == pytest.approx(factors[:, None] ** power * nominal, rel=1e-6)
    # K - 1 is proportional to the spread: slope times deviation is K - 1, a tenth less takes a tenth of it
    slope = found.quantile_slope[0, 0, shown, 0].values * float(found.tolerance_deviation[0])
    assert slope == pytest.approx(0.05 * ndtri((1 + found.probability.values[shown]) / 2), rel=0.05)
    assert found.system_tenth_less[0, shown, 0].values == pytest.approx(-0.1 * slope, rel=1e-9)
    assert found.sobol_total.values == pytest.approx(1, abs=0.05)
    support = found.k_gamma_by_support.isel(support=0)[:, shown]
    assert support.support.item() == "stages.main.sun.support.radial"
    assert found.support_stiffness.values[0] == pytest.approx(10 * found.support_scale.values)
    assert support.values - 1 == pytest.approx(np.broadcast_to(nominal, support.shape), rel=1e-3)  # it floats at all
    planets = found.k_gamma_by_planets.sel(probability=0.5)
    assert float(planets.sel(planets=3)) == pytest.approx(1, abs=1e-4)  # a sun that floats shares among three
    assert float(planets.sel(planets=4)) == pytest.approx(1 + nominal[0], rel=1e-9)
    # medians of the table of closed forms, F0 smaller with more planets
    assert float(planets.sel(planets=6)) - 1 == pytest.approx(0.1 * 6 / 4 * 0.877, rel=0.1)
    assert math.isnan(float(planets.sel(planets=7)))  # they would overlap
    assert set(json.loads(found.attrs["left_out"])) == {"k_gamma_by_planets, 7"}


def test_a_held_sun_does_not_share() -> None:
    model = gaussian(0.1)
    model["stages"]["main"]["sun"]["support"]["radial"] = "1e9 N/m"
    found = epicyclic.tolerance(model, samples=2**10, effects="all")
    curve = found.k_gamma_by_support.isel(support=0).sel(probability=0.5).values
    assert (np.diff(curve) > 0).all()
    assert curve[-1] - 1 > 2 * (curve[0] - 1)


@pytest.mark.usefixtures("few_rows")
def test_small_studies_leave_out_curves_with_maps_of_their_own() -> None:
    found = epicyclic.tolerance(gaussian(0.1), samples=256)
    assert "k_gamma_by_scale" in found
    assert "k_gamma_by_support" not in found
    assert set(json.loads(found.attrs["left_out"])) == {"k_gamma_by_support", "k_gamma_by_planets"}


@pytest.mark.usefixtures("few_rows")
def test_the_progress_ends_at_one() -> None:
    """Also where some numbers of planets are refused."""
    told: list[float] = []
    epicyclic.tolerance(gaussian(0.2), samples=2**10, effects="all", progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0


def test_references_are_carried() -> None:
    found = epicyclic.tolerance(gaussian(0.1), samples=256, effects="none", reference=["table = 4=1.25", "ours=1.1"])
    assert found.reference.values.tolist() == ["table = 4", "ours"]
    assert found.reference_k_gamma.values.tolist() == [1.25, 1.1]


def test_rounded_counts_are_said() -> None:
    found = epicyclic.tolerance(gaussian(0.1), samples=1000, effects="none")
    assert (int(found.attrs["samples"]), int(found.attrs["done"])) == (1024, 1024)
    assert any("1000 samples rounded up to 1024" in text for text in json.loads(found.attrs["warnings"]))


@pytest.mark.parametrize(
    ("options", "path"),
    [
        ({"limit": ["a"]}, "limit"),
        ({"limit": [math.inf]}, "limit"),
        ({"limit": [-1.0]}, "limit"),
        ({"reference": ["1.35"]}, "reference"),
        ({"reference": ["a=b"]}, "reference"),
        ({"reference": {"a": -1.0}}, "reference"),
        ({"samples": 0}, "samples"),
        ({"samples": "many"}, "samples"),
        ({"seed": -1}, "seed"),
        ({"worst": "/nowhere/at/all"}, "worst"),
        ({"resume": True}, "resume"),
        ({"workers": 0}, "workers"),
    ],
)
def test_bad_options_name_themselves(options: dict[str, Any], path: str) -> None:
    with pytest.raises(ModelError) as error:
        epicyclic.tolerance(gaussian(0.1), **options)
    assert error.value.path == path


def test_a_model_without_tolerances_is_refused() -> None:
    with pytest.raises(ModelError, match="no tolerance"):
        epicyclic.tolerance(floating())


def test_correlated_entries_share_one_share() -> None:
    model, gap = gaussian(0.1), "deviations.main.meshes.sun-planet.gap"
    sigma = float(epicyclic.tolerance(model, samples=256).tolerance_deviation[0])
    model["tolerance"] |= {gap: f"normal(0 um, {sigma * 1e6!r} um)"}
    free = epicyclic.tolerance(model, samples=2**13)
    # an error of a pin opens both meshes, TIP times as much; K - 1 is the size of one normal number, the sum of two
    part = np.array([TIP, 1.0]) / math.hypot(TIP, 1.0)
    plan = SamplingPlan(samples=2**13, scrambles=1, rows=2**13, seed=1, sampler="sobol")
    expected = variance_shares(lambda u: np.abs(ndtri(u) @ part), np.arange(2), plan, groups=2)
    assert free.sobol_total[0, 0].values == pytest.approx(expected.total.value, abs=0.05)
    assert free.sobol_first[0, 0].values == pytest.approx(expected.first.value, abs=0.05)
    model["tolerance"]["correlation"] = {POSITION: {gap: 0.5}}
    tied = epicyclic.tolerance(model, samples=2**13)
    assert tied.sobol_total[0, 0].values == pytest.approx(1, abs=0.05)
    assert f"sobol_first, {POSITION}, {gap}" in json.loads(tied.attrs["left_out"])


@pytest.mark.usefixtures("few_rows")
def test_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "k.nc"
    words = ["tolerance", "ren2021", "--samples", "256", "--effects", "none", "--limit", "1.05", "--limit", "1.1"]
    with pytest.raises(SystemExit) as end:
        app([*words, "--reference", "ours=1.2", "--worst", str(tmp_path / "worst"), "-o", str(output)])
    assert end.value.code == 0, capsys.readouterr().err
    found = epicyclic.load_result(output)
    assert found.limit.values.tolist() == [1.05, 1.1]
    assert found.reference.values.tolist() == ["ours"]
    assert len(list((tmp_path / "worst").iterdir())) == 10
    with pytest.raises(SystemExit) as end:
        app([*words, "--limit", "high"])
    assert end.value.code == 2
    assert "--limit = high: no limit of K_gamma" in capsys.readouterr().err
