"""What the findings say in words is what the results hold in numbers."""

from __future__ import annotations

import numpy as np
import pytest

import epicyclic
from epicyclic.questions.flanks.views import contact_findings, efficiency_findings
from epicyclic.questions.sharing.views import findings


def test_the_meshes_lose_what_the_efficiency_leaves() -> None:
    result = epicyclic.efficiency("ren2021")
    (found,) = efficiency_findings(result, {})
    assert f"lose {100 * (1 - float(result.train_efficiency)):.2f} % of the power" in found.text
    assert 0 < 1 - float(result.train_efficiency) < 0.1


def test_a_branch_carries_more_than_its_share_by_k_gamma_less_one() -> None:
    result = epicyclic.sharing("ren2021", cycles=2, overrides={"deviations.planet.position.y": "[20, 0, 0] um"})
    most = float(np.nanmax(result.load_sharing.sel(definition="mean-load").values))
    (text,) = [one.text for one in findings(result, {}) if "K_gamma" in one.text]
    assert most > 1.01
    assert f"K_gamma {most:.3f} as drawn" in text
    assert f"carries {100 * (most - 1):.1f} % more" in text


@pytest.mark.parametrize(("overlap", "said"), [(0.0, "No tip edge bears"), (3e-6, "tips overlap by 3.0 µm")])
def test_a_tip_edge_bears_where_tips_overlap(overlap: float, said: str) -> None:
    result = epicyclic.contact("ren2021", mesh="sun-planet", slices=4, samples=8)
    result["corner_overlap"] = overlap * (1 + 0 * result.corner_overlap)
    assert said in contact_findings(result, {})[0].text
