"""What `sharing` says where a coefficient has no value."""

from __future__ import annotations

import json

import numpy as np

import epicyclic
from epicyclic.show.figures.series import unbroken
from epicyclic.show.figures.summaries import largest_coefficients
from epicyclic.show.views.sharing import key_figures, tables


def test_an_infinite_coefficient_is_told_as_undefined() -> None:
    """A spur set near a resonance, pulled open by the linear model: the forces of the ring mesh sum to less than 0."""
    model: dict[str, object] = {
        "format": 1,
        "title": "spur",
        "damping": {"modal": 0.03},
        "stages": {
            "main": {
                "planets": 3,
                "module": "4 mm",
                "face_width": "50 mm",
                "sun": {"teeth": 24, "support": {"radial": "5e7 N/m"}},
                "planet": {"teeth": 30, "bore": "60 mm", "bearing": {"radial": "4e8 N/m"}},
                "ring": {"teeth": 84, "rim": "25 mm"},
                "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
            }
        },
        "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": "800 N m"}},
        "deviations": {"planet": {"run_out": "15 um", "position": {"y": "[20, 0, 0] um"}}},
    }
    result = epicyclic.sharing(model, cycles=4, samples=32)
    assert np.isinf(result.system_load_sharing.sel(definition="simultaneous").item())
    (said,) = (text for text in json.loads(result.attrs["warnings"]) if "undefined" in text)
    assert "simultaneous of main/planet-ring/1, main/planet-ring/2, main/planet-ring/3" in said
    assert said.endswith("with method static the teeth part [load-sharing-undefined]")
    (table, *_) = tables(result)
    assert table.columns["simultaneous"][-1] == "undefined"
    assert ("undefined", f"load sharing, simultaneous: {unbroken('main/planet-ring/1')}") in key_figures(result)
    static = epicyclic.sharing(model, method="static", cycles=4)
    assert np.isfinite(static.system_load_sharing.values).all()


def test_a_planet_that_carries_too_little_leads_no_headline() -> None:
    """One pin out of place so that its planet carries least: cycle-peak counts what it lacks, the headline does not."""
    model: dict[str, object] = {
        "format": 2,
        "title": "spur",
        "damping": {"modal": 0.05},
        "stages": {
            "main": {
                "planets": 3,
                "module": "4 mm",
                "face_width": "50 mm",
                "sun": {"teeth": 24, "support": {"radial": "5e9 N/m"}},
                "planet": {"teeth": 30, "bore": "60 mm", "bearing": {"radial": "4e8 N/m"}},
                "ring": {"teeth": 84, "rim": "25 mm", "addendum": 0.9},
                "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
            }
        },
        "operation": {"held": ["ring"], "speed": {"sun": "300 rpm"}, "torque": {"sun": "800 N m"}},
        "deviations": {"planet": {"position": {"y": "[20, 0, 0] um"}}},
    }
    result = epicyclic.sharing(model, cycles=4, samples=32)
    sizes = result.load_sharing.sel(definition="cycle-peak")
    signed = result.load_sharing.sel(definition="signed-overload")
    least = str(result.mesh.values[int(np.argmax(sizes.values))])
    assert float(signed.sel(mesh=least)) < 0.99  # the largest deviation is of a planet that carries too little
    for _, value, mesh in largest_coefficients(result):
        assert float(signed.sel(mesh=mesh)) > 1, (value, mesh)
