"""The tables of `static`: forces of links against the forces of a helical pair by hand."""

from __future__ import annotations

from math import cos, hypot, radians, tan
from typing import Any

import pytest

import epicyclic
from epicyclic.statics import views as static_view

PAIR: dict[str, Any] = {
    "format": 2,
    "title": "Helical pair",
    "stages": {
        "fast": {
            "module": "8 mm",
            "helix_angle": "14 deg",
            "face_width": "220 mm",
            "wheel": {"teeth": 89, "support": {"radial": "2e9 N/m", "z": "1e9 N/m", "tilt": "1e8 N m/rad"}},
            "pinion": {"teeth": 25, "support": {"radial": "1e9 N/m", "z": "1e9 N/m", "tilt": "1e8 N m/rad"}},
        }
    },
    "operation": {"torque": {"pinion": "1 kN m", "wheel": "balance"}, "speed": {"pinion": "100 rpm"}},
}


def test_forces_of_supports_across_and_along_the_axis() -> None:
    """F_t = 2 T / d at the reference circle, F_a = F_t tan beta, F_r = F_t tan alpha_n / cos beta; no other force."""
    result = epicyclic.static(PAIR, cycles=1)
    (found,) = [table for table in static_view.tables(result) if table.title.startswith("Forces of supports")]
    tangential = 2 * 1000 / (0.008 * 25 / cos(radians(14)))
    across = hypot(tangential, tangential * tan(radians(20)) / cos(radians(14)))
    along = tangential * tan(radians(14))
    assert found.columns["link"] == ["fast/wheel/support", "fast/pinion/support"]
    assert found.columns["mean across [N]"] == pytest.approx([across] * 2, rel=1e-6)
    assert [abs(one) for one in found.columns["mean along z [N]"]] == pytest.approx([along] * 2, rel=1e-6)
    assert sum(found.columns["mean along z [N]"]) == pytest.approx(0, abs=1e-6 * along)
    spur = epicyclic.static(PAIR, cycles=1, overrides={"stages.fast.helix_angle": "0 deg"})
    (found,) = [table for table in static_view.tables(spur) if table.title.startswith("Forces of supports")]
    assert not any("along" in heading for heading in found.columns)
