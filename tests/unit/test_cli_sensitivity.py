"""The commands `sensitivity` and `track`, and their figures."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import xarray as xr
from typer.testing import CliRunner, Result

import epicyclic
from epicyclic.cli.main import app
from epicyclic.show.charts.effects import tornado
from epicyclic.show.charts.modes import loci

PINS = "stages.main.planet.bearing.radial"


def run(*words: str) -> Result:
    return CliRunner().invoke(app, [*words])


def test_frequencies_ranked() -> None:
    out = run("sensitivity", "lin1999-n4", "--mode", "4").stdout
    assert "What moves modes 4 to 5, one root, 1091.16 Hz, translational" in out
    lines = [line.split() for line in out.splitlines() if line.startswith("stages.")]
    assert [words[0] for words in lines[:2]] == ["stages.main.ring.mass", "stages.main.ring.support.radial"]


def test_forces_at_a_speed(tmp_path: Path) -> None:
    target = tmp_path / "result.nc"
    done = run(
        "sensitivity", "ren2021", "--of", "force", "--paths", PINS, "--mesh-frequency", "60 Hz", "-o", str(target)
    )
    assert done.exit_code == 0
    found = epicyclic.load_result(target)
    assert json.loads(found.attrs["options"])["mesh_frequency"] == pytest.approx(60.0)
    swept = epicyclic.sweep("ren2021", start=60.0, stop=60.0, points=1)
    # solved to 1e-10 here, and there with up to 3e-5 of the motion dropped
    assert found.mesh_force_rms.values == pytest.approx(swept.mesh_force_rms.values[:, 0], rel=1e-5)


def test_json_and_html(tmp_path: Path) -> None:
    words = ["sensitivity", "lin1999-n4", "--paths", PINS, "--paths", "stages.main.meshes.sun-planet.stiffness[2]"]
    found = xr.Dataset.from_dict(json.loads(run(*words, "--json").stdout))
    assert found.sizes["path"] == 2
    target = tmp_path / "tornado.html"
    assert run(*words, "-o", str(target)).exit_code == 0
    assert "figure-sensitivity" in target.read_text(encoding="utf-8")


def test_track_tells_where_modes_meet(tmp_path: Path) -> None:
    words = [
        "track",
        "lin1999-n4",
        "--over",
        PINS,
        "--start",
        "5e7 N/m",
        "--stop",
        "1e9 N/m",
        "--points",
        "15",
        "--modes",
        "14",
    ]
    target = tmp_path / "loci.html"
    done = run(*words, "-o", str(target))
    assert done.exit_code == 0
    assert "crossing" in done.stdout
    assert "veering" in done.stdout
    assert "figure-track" in target.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["sensitivity", "ren2021", "--paths", "stages.main.sun.mas"], "did you mean"),
        (["sensitivity", "ren2021", "--mode", "99"], "no such mode"),
        (["sensitivity", "ren2021", "--of", "force", "--mesh-frequency", "fast"], "--mesh-frequency"),
        (["sensitivity", "lin1999-n4", "--of", "force"], "no damping"),
        (["track", "ren2021", "--over", "stages.main.sun.teeth"], "whole number"),
        (["track", "ren2021", "--over", PINS, "--start", "1 kg"], "not a value"),
        (["track", "ren2021", "--over", PINS, "--start", "5e7"], '--start = 5e7: a number without a unit: "5e7 N/m"?'),
    ],
)
def test_bad_input_ends_with_status_2(words: list[str], message: str) -> None:
    done = run(*words)
    assert done.exit_code == 2
    assert message in done.stderr


def test_tornado_shows_what_the_table_says() -> None:
    data = epicyclic.sensitivity("lin1999-n4", mode=4)
    drawn = tornado(data)
    bars = {
        name: (base, length)
        for trace in drawn.data
        for name, base, length in zip(trace.y, trace.base, trace.x, strict=True)
    }
    chosen = data.ranked_by.values.astype(bool)
    strongest = data.isel(path=0)
    assert str(strongest.path.item()) == "stages.main.ring.mass"
    assert bars["main.ring.mass = 2.35 kg"] == (0.0, pytest.approx(float(strongest.sensitivity.values[chosen][-1])))
    assert drawn.layout.xaxis.title.text.endswith("[%]")
    assert drawn.layout.yaxis.categoryarray[-1].startswith("main.ring.mass")  # the last is drawn at the top


def test_a_split_root_is_a_bar_between_two_values() -> None:
    data = epicyclic.sensitivity("lin1999-n4", mode=4, paths=["stages.main.sun.support.x"])
    (trace,) = tornado(data).data
    low, high = sorted(data.sensitivity.values[0, data.ranked_by.values.astype(bool)])
    assert trace.base[0] == pytest.approx(low, abs=1e-12)
    assert trace.x[0] == pytest.approx(high - low)
    assert "…" in trace.text[0]


def test_loci_mark_what_meets() -> None:
    data = epicyclic.track("lin1999-n4", over=PINS, start="5e7 N/m", stop="1e9 N/m", points=15, modes=14)
    drawn = loci(data)
    names = {trace.name: trace for trace in drawn.data if trace.name in ("crossing", "veering")}
    for kind, trace in names.items():
        assert len(trace.x) == int((data.event_kind == kind).sum())
    assert set(names) == {"crossing", "veering"}
    assert drawn.layout.xaxis.type == "log"
    assert drawn.layout.xaxis.title.text == f"{PINS} [N/m]"
