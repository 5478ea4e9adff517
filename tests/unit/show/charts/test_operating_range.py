"""The range of speeds: names keep apart, the strongest are named, trains share one figure."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from epicyclic.questions.modes.views import modes_findings
from epicyclic.questions.response.views import sweep_findings
from epicyclic.show.charts.over_speed import operating_range


def modes(speed: list[float], ratio: list[float]) -> xr.Dataset:
    """Resonances at these speeds [1], forces per mean of 200 N, of mode 1, 2, ... with the first order."""
    count = len(speed)
    along = "resonance"
    return xr.Dataset(
        {
            "resonance_speed": (along, speed),
            "resonance_near": (along, np.abs(np.array(speed) - 1) <= 0.2),
            "resonance_order": (along, np.ones(count)),
            "resonance_stage": (along, ["main"] * count),
            "resonance_mode": (along, np.arange(count) + 1),
            "resonance_multiplicity": (along, np.ones(count, dtype=int)),
            "resonance_kind": (along, ["rotational"] * count),
            "resonance_frequency": (along, 100 * np.array(speed)),
            "resonance_force_ratio": (along, ratio),
            "resonance_own_force": (along, 200 * np.array(ratio)),
            "resonance_connection": (along, ["main/sun/support"] * count),
            "resonance_connection_share": (along, [0.7] * count),
            "connection": ("connection", ["main/sun/support"]),
        },
        attrs={"verb": "modes", "options": "{}"},
    )


def sweep(factor: list[float]) -> xr.Dataset:
    speed = np.linspace(0.5, 1.3, len(factor))
    values = {"dynamic_factor": (("mesh", "speed"), np.array([factor, np.ones(len(factor))]))}
    least = np.where(np.array(factor) > 2, -1.0, 1.0)
    values["mesh_force_minimum"] = (("mesh", "speed"), np.array([least, np.ones(len(factor))]))
    coords = {"speed": speed, "mesh": ["main/sun-planet/1", "main/planet-ring/1"]}
    return xr.Dataset(values, coords=coords, attrs={"verb": "sweep", "options": '{"speed_range": "operation"}'})


def test_names_keep_apart_and_the_strongest_are_named() -> None:
    speed = [0.5, 0.9, 0.905, 0.91, 1.0, 1.3]
    drawn = operating_range({"": (modes(speed, [1.0, 2.0, 9.0, 3.0, 4.0, 5.0]), sweep([1.0, 3.0, 1.5]))})
    assert drawn is not None
    named = {round(note.x, 6): note.text for note in drawn.layout.annotations if note.yref == "y2"}
    assert named == {
        50.0: "1× mesh, mode 1",
        90.5: "1× mesh, mode 3",
        100.0: "1× mesh, mode 5",
        130.0: "1× mesh, mode 6",
    }
    strokes = next(trace for trace in drawn.data if trace.yaxis == "y2")
    assert list(strokes.x) == pytest.approx([100 * one for one in speed])
    curve = next(trace for trace in drawn.data if trace.yaxis != "y2")
    assert max(curve.y) == 3.0  # the largest of all meshes
    assert "K_v 2" in {note.text for note in drawn.layout.annotations}


def test_trains_share_the_figure_each_in_its_colour() -> None:
    pairs = {"soft": (modes([0.9], [1.0]), sweep([1.0, 1.2])), "stiff": (modes([1.1], [1.0]), sweep([1.0, 1.1]))}
    drawn = operating_range(pairs)
    assert drawn is not None
    assert [trace.name for trace in drawn.data][::2] == ["soft", "stiff"]
    assert drawn.data[0].line.color == drawn.data[1].marker.color != drawn.data[2].line.color
    heights = [trace.y[0] for trace in drawn.data if trace.yaxis == "y2"]
    assert heights[0] != heights[1]


def test_nothing_known_is_no_figure() -> None:
    assert operating_range({"": (None, None)}) is None


@pytest.mark.parametrize(
    ("ratio", "tone", "words"),
    [
        (0.04, "good", "of up to 0.008 kN is 4 % of the mean force of its mesh (no matter below 5 %)"),
        (0.06, "caution", "of up to 0.012 kN is 6 % of the mean force of its mesh."),
        (1.01, "bad", "of up to 0.202 kN is 101 % of the mean force of its mesh, teeth part from 100 %"),
    ],
)
def test_a_resonance_is_judged_by_its_force_over_the_mean(ratio: float, tone: str, words: str) -> None:
    (found,) = modes_findings(modes([0.5, 0.95, 1.05], [1e4, 0.01, ratio]), {})
    assert found.tone == tone
    assert words in found.text
    assert (found.value, found.limit) == (ratio, 1.0)
    assert "at 105 % of the operating speed" in found.text
    assert found.text.startswith("2 resonances within 20 %")
    assert ("sun support 70 %" in found.change) == (tone != "good")


def test_the_nearest_strong_resonance_stands_beside_the_strongest() -> None:
    (found,) = modes_findings(modes([0.9, 0.97, 0.995, 1.1], [0.5, 0.2, 0.01, 0.3]), {})
    assert "the strongest is where 1x mesh meets mode 1 " in found.text
    assert found.text.endswith("is 50 % of the mean force of its mesh; nearest 1x mesh and mode 2 at 97 %, 20 %.")
    assert "(epicyclic detune --mode 1), or keep away from 90 %" in found.change
    (on_it,) = modes_findings(modes([0.9, 0.995], [0.3, 0.5]), {})
    assert "nearest" not in on_it.text
    assert on_it.change.endswith("(epicyclic detune --mode 2): operation stands on it.")


def test_ranges_in_which_teeth_part_are_named() -> None:
    (found,) = sweep_findings(sweep([1.0, 3.0, 3.0, 1.0, 1.0, 1.0, 4.0, 1.0, 1.0]), {})
    assert "60 to 70 %, 110 %" in found.text
    assert "largest K_v 4.000 at 110 %" in found.text
    assert found.tone == "caution"  # not at the operating speed
    (calm,) = sweep_findings(sweep([1.0, 1.5, 1.0]), {})
    assert calm.tone == "good"
