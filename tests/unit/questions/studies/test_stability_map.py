"""Maps of stability over a value in the model file or a factor, and the command that asks for them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.cli.main import app
from epicyclic.errors import ModelError
from epicyclic.questions.stability.stability import Combination
from epicyclic.show.charts.speed_maps import stability_map as drawn_map
from epicyclic.show.charts.speed_maps import stability_over_speed

# xu2020 beside its widest range of instability, f34 + f36 = f
SPEEDS: dict[str, Any] = {"start": 3300.0, "stop": 3900.0, "points": 4}


def over(path: str, values: Sequence[Any], **options: Any) -> xr.Dataset:
    speeds = {} if "mesh_frequency" in options else SPEEDS
    return epicyclic.stability("xu2020", over=path, values=values, **{**speeds, **options})


@pytest.fixture(scope="module")
def damped() -> xr.Dataset:
    return over("damping.modal", ["1 %", "3 %", "9 %"])


def test_a_map_is_its_rows(damped: xr.Dataset) -> None:
    assert damped.growth_rate.dims == ("value", "speed")
    assert damped.value.values.tolist() == [1.0, 3.0, 9.0]
    assert damped.value.attrs["units"] == "%"
    assert damped.attrs["over"] == "damping.modal"
    for i, value in enumerate(("1 %", "3 %", "9 %")):
        row = epicyclic.stability("xu2020", overrides={"damping.modal": value}, **SPEEDS)
        np.testing.assert_array_equal(damped.growth_rate[i], row.growth_rate)
        assert damped.instability[i].values.tolist() == row.instability.values.tolist()
        widths = np.sort((row.resonance_high - row.resonance_low).values)
        mine = np.sort((damped.resonance_high - damped.resonance_low)[i].values)
        np.testing.assert_allclose(mine[np.isfinite(mine)], widths, rtol=1e-12)


def test_damping_closes_and_variation_opens(damped: xr.Dataset) -> None:
    unstable = (damped.instability == "quasi-periodic").sum("speed").values
    assert unstable[0] > 0
    assert unstable[-1] == 0
    swings = over("variation", [0.0, 1.0, 2.0])
    width = (swings.resonance_high - swings.resonance_low).max("resonance").values
    assert np.isnan(width[0])
    assert width[2] > 2 * width[1] > 0  # damping takes more of the narrow one


def test_the_factor_of_damping_is_that_of_the_file(damped: xr.Dataset) -> None:
    factors = over("damping", [1 / 3, 1, 3])  # the file says 3 %
    np.testing.assert_allclose(factors.growth_rate, damped.growth_rate, rtol=1e-6, atol=1e-6)


def test_any_path_of_the_file() -> None:
    # four planets one after another, or all at once: phases decide which modes a mesh couples
    phases = over("stages.main.meshes.sun-planet.phase", [[0.0, 0.25, 0.5, 0.75], 0.0], mesh_frequency=[3600.0])
    assert np.ptp(phases.growth_rate.values) > 100.0  # [1/s]
    assert phases.value.values.tolist() == ["[0.0, 0.25, 0.5, 0.75]", "0.0"]
    wide = over("stages.main.helix_angle", ["24 deg", "28 deg"], mesh_frequency=[3600.0])
    assert np.isfinite(wide.growth_rate).all()


def test_a_value_that_fails_fails_alone() -> None:
    found = over("stages.main.sun.support.radial", ["1e8 N/m", "-1 N/m"], points=2)
    assert np.isfinite(found.growth_rate.values[0]).all()
    assert np.isnan(found.growth_rate.values[1]).all()
    assert "stages.main.sun.support" in str(found.status.values[1, 0])
    assert "1 of 2 values failed, the first with: stages.main.sun.support" in found.attrs["warnings"]
    assert found.stable.values.tolist()[1] == [False, False]


def test_ranges_of_one_combination_are_one_and_the_widest_stands_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """A narrow sum of modes 1 and 2 at the first value alone; modes 3 and 4 in two ranges there, in one at the last."""

    def ranges(modes: tuple[int, int], *ends: tuple[float, float, float]) -> list[Combination]:
        first, second = modes
        words: dict[str, Any] = {"first": first, "second": second, "order": 1, "stage": "main", "threshold": 0.5}
        return [Combination(**words, low=a, centre=(a + b) / 2, high=b, growth=rate) for a, b, rate in ends]

    rows = iter(
        [
            [*ranges((1, 2), (10.0, 11.0, 5.0)), *ranges((3, 4), (20.0, 22.0, 7.0), (23.0, 26.0, 6.0))],
            [],
            ranges((3, 4), (21.0, 25.0, 9.0)),
        ]
    )
    monkeypatch.setattr("epicyclic.questions.studies.parameter_studies.predicted_combinations", lambda *_: next(rows))
    found = over("damping", [0.5, 1.0, 2.0], mesh_frequency=[3600.0], start=None, stop=None, points=None)
    nan = np.nan
    assert found.resonance.values.tolist() == ["f3 + f4 = f", "f1 + f2 = f"]
    assert found.resonance_first.values.tolist() == [3, 1]
    np.testing.assert_array_equal(found.resonance_low, [[20.0, 10.0], [nan, nan], [21.0, nan]])
    np.testing.assert_array_equal(found.resonance_high, [[26.0, 11.0], [nan, nan], [25.0, nan]])
    np.testing.assert_array_equal(found.resonance_growth, [[7.0, 5.0], [nan, nan], [9.0, nan]])


@pytest.mark.parametrize(
    ("path", "values", "named"),
    [
        ("stages.main.sun.nosuch", [1.0, 2.0], "nosuch"),
        ("variation", ["much"], "not a factor"),
        ("damping", [-1.0], "out of range"),
        ("damping.modal", [], "nothing to go over"),
    ],
)
def test_what_no_row_can_take_is_refused(path: str, values: list[Any], named: str) -> None:
    with pytest.raises(ModelError, match=named):
        over(path, values)


def test_a_path_and_its_values_go_together() -> None:
    with pytest.raises(ModelError, match="go together"):
        epicyclic.stability("xu2020", over="damping.modal")
    with pytest.raises(ModelError, match="overrides"):
        epicyclic.stability(epicyclic.load("xu2020"), over="damping.modal", values=[0.01], **SPEEDS)


def test_progress_counts_cells() -> None:
    seen: list[tuple[int, int]] = []
    over("variation", [0.5, 1.0], points=3, progress=lambda done, of: seen.append((done, of)))
    assert seen == [(i, 6) for i in range(1, 7)]


def run(*words: str) -> int:
    with pytest.raises(SystemExit) as stop:
        app(list(words), prog_name="epicyclic")
    return int(stop.value.code or 0)


def test_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("stability", "xu2020", "--start", "3.5 kHz", "--stop", "3.8 kHz", "--points", "4") == 0
    out = capsys.readouterr().out
    for shown in ("Unstable", "quasi-periodic", "f34 + f36 = f", "averaging", "ok"):
        assert shown in out
    assert run("stability", "ren2021", "--start", "100 Hz", "--stop", "200 Hz", "--points", "3") == 0
    assert "Stable at 3 speeds" in capsys.readouterr().out
    words = ("--over", "variation", "--values", "0..2", "--value-points", "2", "--points", "2", "--json")
    assert run("stability", "xu2020", "--start", "3.5 kHz", "--stop", "3.8 kHz", *words) == 0
    again = xr.Dataset.from_dict(json.loads(capsys.readouterr().out))
    assert again.growth_rate.shape == (2, 2)
    assert run("stability", "xu2020", "--over", "variation", "--values", "0, 2", "--points", "2") == 0
    assert "Stability over variation" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("ren2021", "--start", "600 Hz", "--stop", "20 Hz"), "600"),
        (("ren2021", "--over", "damping.modal"), "--values"),
        (("ren2021", "--over", "stages.main.sun.mass", "--values", "700..800", "--points", "2"), '"700 kg"?'),
        (("ren2021", "--over", "damping.modal", "--values", "few"), "few"),
        (("ren2021", "--over", "stages.main.nosuch", "--values", "1..2", "--points", "2"), "nosuch"),
        (("lin1999-n4",), "speed"),
    ],
)
def test_wrong_input(capsys: pytest.CaptureFixture[str], words: tuple[str, ...], named: str) -> None:
    assert run("stability", *words) == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    assert streams.err.splitlines()[-1].startswith("error: ")
    assert named in streams.err


def test_figures(damped: xr.Dataset) -> None:
    one = stability_over_speed(epicyclic.stability("xu2020", **SPEEDS))
    assert "Unstable at" in one.layout.title.text
    assert one.layout.xaxis2.title.text == "mesh frequency [Hz]"
    assert any(trace.name == "quasi-periodic: two modes together" for trace in one.data)
    flat = drawn_map(damped)
    assert flat.layout.yaxis.title.text == "damping.modal [%]"
    lines = [trace for trace in flat.data if trace.type == "scatter"]
    assert len(lines) >= 1
    # up one side of the range and down the other: it is cut by the lower edge of the map, and closes below its top
    assert lines[0].y[0] == lines[0].y[-2] == 1.0
    assert max(y for y in lines[0].y if y is not None) < 9.0
    texts = over("damping.modal", ["1 %", 0.03], points=2)
    assert drawn_map(texts).layout.yaxis.ticktext == ("1 %", "0.03")
    stable = epicyclic.stability("ren2021", start=100.0, stop=200.0, points=3)
    assert stability_over_speed(stable).layout.title.text == "Stable at 3 speeds"
