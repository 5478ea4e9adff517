"""The figure of a sweep with contact loss, from a made-up fold."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from epicyclic.questions.response.views import _folds, _forces, _motions
from epicyclic.show.charts.over_speed import contact_sweep
from epicyclic.show.report import report


def swept() -> xr.Dataset:
    """Two meshes; a branch that turns back at 120 Hz and on at 110 Hz, unstable between."""
    speed = np.array([100.0, 115.0, 130.0])
    path = np.array([100.0, 110, 120, 115, 110, 120, 130])
    level = np.array([1.0, 1.2, 1.5, 2.0, 2.5, 2.2, 2.0])
    forces = np.array([[[1.0, 1.3, 2.0]], [[1.0, 2.4, 2.0]]]) * np.array([1e3, 2e3])[None, :, None]
    apart = np.broadcast_to(np.array([0.0, 0.2, 0.1]), (2, 2, 3))
    kind = np.array(["stable", "stable", "fold", "fold", "fold", "stable", "stable"], dtype=object)
    motion = np.array([["periodic", "periodic", "integrated"]] * 2, dtype=object)
    return xr.Dataset(
        {
            "mesh_force_rms": (("direction", "mesh", "speed"), forces),
            "contact_open": (("direction", "mesh", "speed"), apart),
            "motion": (("direction", "speed"), motion),
            "path_frequency": ("path", path),
            "path_force_rms": (("mesh", "path"), np.outer([1e3, 2e3], level)),
            "path_instability": ("path", kind),
            "path_part": ("path", np.array([0, 0, 0, 1, 2, 2, 2])),
            "fold_frequency": ("fold", np.array([120.0, 110.0])),
        },
        {
            "direction": ["up", "down"],
            "mesh": ["main/sun-planet/1", "main/planet-ring/1"],
            "speed": speed / 100,
            "mesh_frequency": ("speed", speed),
        },
        {"verb": "contact_sweep", "title": "a fold", "warnings": "[]"},
    )


def test_run_up_coast_down_and_branches() -> None:
    drawn = contact_sweep(swept())
    assert "planet-ring" in drawn.layout.title.text  # the louder one
    assert drawn.layout.yaxis.title.text == "force [kN]"
    assert drawn.layout.xaxis2.title.text == "mesh frequency [Hz]"
    named = {trace.name: trace for trace in drawn.data}
    assert set(named) == {"branch", "unstable branch", "run-up", "coast-down", "fold"}
    assert named["unstable branch"].line.dash == "dash"
    assert list(named["unstable branch"].y)[:3] == pytest.approx([3.0, 4.0, 5.0])
    assert list(named["fold"].x) == [120.0, 110.0]
    up, down = (next(t for t in drawn.data if t.name == name) for name in ("run-up", "coast-down"))
    assert up.y[1] == pytest.approx(2.6)
    assert down.y[1] == pytest.approx(4.8)
    assert down.marker.size[2] > 0 == down.marker.size[0]
    other = contact_sweep(swept(), mesh="main/sun-planet/1")
    assert "sun-planet" in other.layout.title.text


def test_it_is_a_section_of_the_report() -> None:
    assert "Speed sweep with contact loss" in report({"contact_sweep": swept()})


def test_forces_that_are_not_known_are_no_zeros() -> None:
    """Of the second mesh nothing is known at any speed."""
    known = swept()
    for name in ("mesh_force_peak", "mesh_force_minimum"):
        known[name] = known.mesh_force_rms
    for name in ("mesh_force_rms", "mesh_force_peak", "mesh_force_minimum", "contact_open"):
        known[name] = known[name].where(known.mesh != "main/planet-ring/1")
    columns = _forces(known, "3 speeds").columns
    assert columns["largest force [N]"][0] == 2400.0
    assert columns["apart at most [% of the time]"][0] == 20.0
    assert np.isnan(columns["largest force [N]"][1])
    assert np.isnan(columns["apart at most [% of the time]"][1])


def test_speeds_of_a_train_of_several_stages_name_theirs() -> None:
    """Ranges of speed and folds are over the mesh frequency of the first stage, and say so."""
    data = swept().assign(branch_instability=(("direction", "speed"), np.full((2, 3), "", dtype=object)))
    for names, words in ((data.mesh.values, False), (["low/sun-planet/1", "high/planet-ring/1"], True)):
        result = data.assign_coords(mesh=names)
        headings = [heading for table in (_motions(result), *_folds(result)) for heading in table.columns]
        spoken = [heading for heading in headings if "[Hz]" in heading]
        assert len(spoken) == 3
        assert all((" of low" in heading) is words for heading in spoken)
