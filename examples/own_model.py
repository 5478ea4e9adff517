"""A model of one's own, as a dict: what follows, and what a pin position error does to three and to four planets."""

from typing import Any

import epicyclic

MODEL: dict[str, Any] = {
    "format": 2,
    "title": "A planetary reducer with a floating sun",
    "damping": {"modal": 0.03},
    "stages": {
        "main": {
            "planets": 3,
            "module": "4 mm",
            "face_width": "50 mm",
            "sun": {"teeth": 24, "support": {"radial": 0}},
            "planet": {"teeth": 30, "bore": "60 mm", "bearing": {"radial": "4e8 N/m"}},
            "ring": {"teeth": 84, "rim": "25 mm"},
            "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": "800 N m"}},
    "deviations": {"planet": {"position": {"y": "[20, 0, 0] um"}}},
}

derived = epicyclic.check(MODEL)
three = epicyclic.sharing(MODEL, method="static")
four = epicyclic.sharing(
    MODEL,
    overrides={"stages.main.planets": 4, "deviations.planet.position.y": "[20, 0, 0, 0] um"},
    method="static",
)
SHARING = {
    planets: float(result.system_load_sharing.sel(definition="simultaneous"))
    for planets, result in (("3 planets", three), ("4 planets", four))
}
PINNED = SHARING["3 planets"]  # a floating sun shares equally among three planets, whatever the errors

if __name__ == "__main__":
    print(derived[["speed", "torque", "power"]].to_dataframe().to_string())
    for planets, value in SHARING.items():
        print(f"{planets}: largest share of a planet {value:.3f}")
