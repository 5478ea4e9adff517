"""docs/theory/laws.md: its example of a law runs and does what the page says."""

from __future__ import annotations

import json
import re
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import epicyclic

PAGE = Path(__file__).parents[3].joinpath("docs", "theory", "laws.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def example(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    code = "\n".join(re.findall(r"```python\n(.*?)```", PAGE.partition("## Tables of your own")[0], re.DOTALL))
    file = tmp_path_factory.mktemp("page") / "laws_page.py"
    file.write_text(code, encoding="utf-8")
    return runpy.run_path(str(file), run_name="laws_page")


def test_the_law_of_the_page_is_one(example: dict[str, Any]) -> None:
    law = example["law"].at(np.zeros((4, 1)))
    meet = (example["law"].load / example["law"].stiffness)[None]
    force, tangent = law.evaluate(np.tile(meet, (4, 1)))
    np.testing.assert_allclose(force, 48e3, rtol=1e-12)
    np.testing.assert_allclose(tangent, np.tile(example["law"].stiffness, (4, 1)), rtol=1e-12)
    delta, step = np.linspace(-2, 3, 41)[:, None, None] * np.tile(meet, (4, 1)), 1e-10
    ahead, back = law.evaluate(delta + step), law.evaluate(delta - step)
    energy = (law.energy(delta + step) - law.energy(delta - step)) / (2 * step)
    np.testing.assert_allclose(energy, law.evaluate(delta)[0], atol=1e-6 * 48e3)
    slope = (ahead[0] - back[0]) / (2 * step)
    pressed = np.abs(delta - law.touch) > 2 * step
    np.testing.assert_allclose(slope[pressed], law.evaluate(delta)[1][pressed], atol=1e-4 * float(tangent.max()))
    np.testing.assert_array_equal(law.rows([0, 2]).instants([1]).touch, law.touch[1:2][:, [0, 2]])
    assert law.constant(*np.array([[-2.0], [-1.0]]) * meet[0]).all()


def test_the_warning_of_the_page_is_that_of_its_law(example: dict[str, Any]) -> None:
    (text,) = (text for text in json.loads(example["vibrating"].attrs["warnings"]) if "law of its gaps" in text)
    assert "8.1 % below" in text
    assert "8.1 % below, since 0.5 / (2/3)^1.5 - 1 = -0.081" in PAGE
    meet = 0.5 * 48e3 / float(example["meshes"].stiffness[0]) * 1e6
    assert f"teeth touch {meet:.2g} µm before" in text
    # the torque of the sun needs the same forces whatever the law; it is 48.2 kN, and at 48 kN both deflect alike
    plain = epicyclic.static(example["system"], cycles=1)
    own = [mesh for mesh in plain.mesh.values if "sun-planet" in mesh]
    total = [float(one.mesh_force.sel(mesh=own).mean()) for one in (example["at_rest"], plain)]
    assert total[0] == pytest.approx(total[1], rel=1e-6)
    turn = [float(one.displacement.sel(dof="main/sun/rz").mean()) for one in (example["at_rest"], plain)]
    assert turn[0] == pytest.approx(turn[1], rel=1e-3)
    assert turn[0] != pytest.approx(turn[1], rel=1e-9)


def test_the_worked_example_is_what_the_drive_gives() -> None:
    overrides = {"stages.main.meshes.sun-planet.stiffness": "contact", "stages.main.sun.flank.crown": "40 um"}
    result = epicyclic.modes("ren2021", overrides=overrides)
    (text,) = (text for text in json.loads(result.attrs["warnings"]) if "law of its gaps" in text)
    assert text in re.sub(r"\s+", " ", PAGE)
    assert "48.2 kN" in text
