"""The verdict on K_gamma: the mean-load one of a result against the limits that stand in it, in one sentence.

Terminal, report and page say the same of it (`limits`).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from ..limits import nearest_limit, passes
from .series import numbers, texts

if TYPE_CHECKING:
    import xarray as xr


class KGammaVerdict(NamedTuple):
    """K_gamma [1] of the mesh or pair that is farthest beyond its limit, or nearest to it.

    name : of it.  turning : the same while turning, nan where it is not known.  source, basis : of the limit.
    rests_on : ``assumed`` where the model assumes deviations or tolerances, else ``given``.
    """

    name: str
    value: float
    turning: float
    limit: float
    source: str
    rests_on: Literal["given", "assumed"]

    @property
    def passes(self) -> bool:
        """Whether the mean-load K_gamma meets its limit."""
        return passes(self.value, self.limit)

    @property
    def judged(self) -> dict[str, Any]:
        """Fields of the finding that says it."""
        tone = "good" if self.passes else "bad"
        return {"tone": tone, "value": self.value, "limit": self.limit, "rests_on": self.rests_on}

    @property
    def text(self) -> str:
        """``limit 1.25 (4 planets, IEC 61400-4:2012): passes``; what turns is not held against it."""
        return f"limit {self.limit:g} ({self.source}): {'passes' if self.passes else 'FAILS'}"


def k_gamma_verdict(
    result: xr.Dataset, dim: str, mean: Sequence[float], turning: Sequence[float]
) -> KGammaVerdict | None:
    """Verdict on mean-load K_gamma along a dimension that has limits; None where the result has none, or no value.

    mean, turning : (n,) [1], nan where unknown.
    """
    if "k_gamma_limit" not in result.variables:
        return None
    limits = numbers(result, "k_gamma_limit", dim)
    at = nearest_limit(list(mean), limits.tolist())
    if at is None:
        return None
    assumed = json.loads(str(result.attrs.get("assumed", "{}")))
    return KGammaVerdict(
        name=texts(result, dim)[at],
        value=float(mean[at]),
        turning=float(np.asarray(turning)[at]),
        limit=float(limits[at]),
        source=texts(result, "k_gamma_limit_source", dim)[at],
        rests_on="assumed" if any(path.startswith(("deviations.", "tolerance.")) for path in assumed) else "given",
    )
