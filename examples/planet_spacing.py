"""A train whose planets cannot be equally spaced: the nearest buildable angles, and what they cost in load sharing."""

import json

import epicyclic

BUILDABLE = "[0, 121.5, 238.5] deg"
NO_ERRORS = {"deviations": None}

warnings = json.loads(epicyclic.check("ren2021").attrs["warnings"])
equal = epicyclic.sharing("ren2021", overrides=NO_ERRORS)
buildable = epicyclic.sharing("ren2021", overrides={**NO_ERRORS, "stages.main.planet_angles": BUILDABLE})

PINNED = float(buildable.system_load_sharing.sel(definition="simultaneous"))

if __name__ == "__main__":
    for warning in warnings:
        print("warning:", warning)
    for name, result in (("equal spacing", equal), (f"at {BUILDABLE}", buildable)):
        print(f"{name}: {float(result.system_load_sharing.sel(definition='simultaneous')):.4f} without any error")
