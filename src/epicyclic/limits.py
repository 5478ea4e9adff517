"""Limits that numbers are held against, and the verdict: the load factor K_gamma, which a rating of gears assumes, the
force of a resonance, and what a relief gains.

    [limits]
    k_gamma = 1.2                  # or the name of a table
    stages.NAME.k_gamma = "IACS UR M56"

A limit given with a command counts before that of the stage, this before that of the file, and this before the table
of the wind standard.  The tables give K_gamma by the number of planets where no analysis shows a smaller one; what is
held against them is the mean-load K_gamma, where tolerances are known at 99 % of the trains.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from .errors import ModelError

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from numpy.typing import NDArray

# By number of planets.  The table of the wind standard ends at seven; the last factor of the ship rule is for as many
# or more.
WIND, SHIP = "IEC 61400-4", "IACS UR M56"
TABLES: dict[str, dict[int, float]] = {
    WIND: {1: 1.00, 2: 1.00, 3: 1.10, 4: 1.25, 5: 1.35, 6: 1.44, 7: 1.47},
    SHIP: {1: 1.00, 2: 1.00, 3: 1.00, 4: 1.20, 5: 1.30, 6: 1.40},
}
_EDITIONS = {WIND: f"{WIND}:2012", SHIP: f"{SHIP}, of the edition that cites ISO 6336:2019"}
# A K_gamma this close to its limit meets it: equal shares are 1 up to rounding.
_ROUNDING = 5e-7
# A resonance this close to operation is told: half-power widths are 2 zeta, at most a tenth for usual damping, and
# natural frequencies of a drawing are known to some 10 %.
RESONANCE_BAND = 0.2
# Amplitude of a mesh force per its mean: a twentieth is less than loads of a train are known to, and at the mean itself
# the force falls to zero once a cycle, teeth part.  A peak of the largest force over speed that rises less than a
# twentieth above its surroundings is no matter either.
NO_MATTER, TEETH_PART = 0.05, 1.0
# Modal assurance from which two shapes are the same mode: half of the kinetic energy and more is in it.
SAME_SHAPE = 0.5
# A relief that takes less than this part off its objective is not worth a grinding: loads and flanks vary more.
RELIEF_GAIN = 0.02
Tone = Literal["good", "caution", "bad"]
# Probability at which K_gamma of toleranced trains is held against its limit.
JUDGED_AT = 0.99


@dataclass(frozen=True, slots=True, kw_only=True)
class KGammaLimit:
    """Largest K_gamma [1] that is accepted.  source : option, path of the model file, or planets and standard."""

    value: float
    source: str


def k_gamma_limit(
    model: Mapping[str, Any], stage: str, planets: int, *, stated: float | str | None = None
) -> KGammaLimit:
    """Limit of K_gamma of a stage.

    Parameters
    ----------
    model : document of a train.  planets : that share the load, 1 or more.  stated : limit, or name of a table, that
        goes before those of the model.

    Raises
    ------
    ModelError : what is stated is no limit.
    """
    limits = model.get("limits", {})
    of_stage = limits.get("stages", {}).get(stage, {})
    given = {
        "limit": stated,
        f"limits.stages.{stage}.k_gamma": of_stage.get("k_gamma"),
        "limits.k_gamma": limits.get("k_gamma"),
    }
    where, value = next(((where, value) for where, value in given.items() if value is not None), ("", WIND))
    number = stated_limit(value, where)
    if isinstance(number, float):
        return KGammaLimit(value=number, source="the option limit" if where == "limit" else where)
    table = TABLES[number]
    last = max(table)
    words = f"{planets} planet{'s' if planets > 1 else ''}, {_EDITIONS[number]}"
    if planets > last and number == WIND:
        words += f", which ends at {last}"
    return KGammaLimit(value=table[min(planets, last)], source=words)


def limit_in_short(source: str) -> tuple[str, str]:
    """Words of the source of a limit, ``4 planets, table``, and the path of the model file that states another one."""
    if source.startswith("limits."):
        return "of the model", source
    return f"{source.partition(',')[0]}, table", "limits.k_gamma"


def limit_columns(dim: str, limits: Sequence[KGammaLimit]) -> dict[str, tuple[str, Any]]:
    """Variables of a result: limits of K_gamma along a dimension, and where they are from."""
    return {
        "k_gamma_limit": (dim, [limit.value for limit in limits]),
        "k_gamma_limit_source": (dim, [limit.source for limit in limits]),
    }


def stated_limit(value: object, path: str) -> float | str:
    """A limit as a person states it: a number from 1 on, or the name of a table.

    Raises
    ------
    ModelError : it is neither.
    """
    if value in TABLES:
        return str(value)
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        number = float("nan")
    if not 1 <= number < float("inf"):
        allowed = f"a load factor of 1 or more, 1.15, or one of {', '.join(TABLES)}"
        raise ModelError("no limit of K_gamma", path=path, given=value, allowed=allowed)
    return number


def passes(value: float, limit: float) -> bool:
    """Whether a K_gamma [1] meets its limit."""
    return value <= limit + _ROUNDING


def nearest_limit(values: Sequence[float], limits: Sequence[float]) -> int | None:
    """Place of the K_gamma whose excess over 1 is the largest part of what its limit leaves, the first of equal ones.

    None where no value is a number.
    """

    def part(i: int) -> float:
        room = limits[i] - 1
        if room > 0:
            return (values[i] - 1) / room
        return 0.0 if passes(values[i], limits[i]) else math.inf

    places = [i for i, value in enumerate(values) if value == value]
    most = max((part(i) for i in places), default=0.0)
    least = most if math.isinf(most) else most - 1e-6 * abs(most)
    return next((i for i in places if part(i) >= least), None)


class KGammaVerdict(NamedTuple):
    """K_gamma [1] held against its limit, of several the one that takes the largest part of what its limit leaves.

    name : of its mesh or pair.  limit [1], source : of the limit.  assumed : whether the model assumes the deviations
    or tolerances that K_gamma follows from.  probability : share of the trains in which K_gamma stays below its value.
    """

    name: str
    value: float
    limit: float
    source: str
    assumed: bool
    probability: float = JUDGED_AT

    @property
    def passes(self) -> bool:
        """Whether the mean-load K_gamma meets its limit; what turns is not held against it."""
        return passes(self.value, self.limit)

    @property
    def tone(self) -> Tone:
        """Tone of the finding that says it; what passes in fewer trains than are judged is open."""
        if not self.passes:
            return "bad"
        return "good" if self.probability >= JUDGED_AT else "caution"

    @property
    def text(self) -> str:
        """``limit 1.25 (4 planets, IEC 61400-4:2012): passes``, and whether it rests on what is assumed."""
        rests_on = ", with assumed deviations" if self.assumed else ""
        verdict = {"good": "passes", "bad": "FAILS", "caution": f"open at {100 * JUDGED_AT:g} %, for more samples"}
        return f"limit {self.limit:g} ({self.source}): {verdict[self.tone]}{rests_on}"


class ResonanceVerdict(NamedTuple):
    """Largest force of a mode per mean force of the same mesh [1] at a resonance near operation, against its limits.

    Derived here, docs/theory/modes.md.
    """

    force_ratio: float

    @property
    def tone(self) -> Tone:
        """Tone of the finding that says it."""
        if self.force_ratio < NO_MATTER:
            return "good"
        return "bad" if self.force_ratio >= TEETH_PART else "caution"

    @property
    def text(self) -> str:
        """``12 % of the mean force of its mesh``, with the limit that counts."""
        share = 100 * self.force_ratio
        words = f"{share:{'.2g' if share < 10 else '.0f'}} % of the mean force of its mesh"
        if self.tone == "good":
            return f"{words} (no matter below {100 * NO_MATTER:g} %)"
        return f"{words}, teeth part from {100 * TEETH_PART:g} %" if self.tone == "bad" else words


def carries_load(load: NDArray[np.float64], stage: Sequence[str]) -> NDArray[np.bool_]:
    """Whether meshes, or pairs of gears, carry more than next to nothing beside the most loaded one of their stage.

    A drag alone is nothing to judge a mesh by.

    load : (n,) mean mesh force [N], not below zero.  stage : (n,) names.
    """
    most = dict.fromkeys(stage, 0.0)
    for one, value in zip(stage, load.tolist(), strict=True):
        most[one] = max(most[one], value)
    return load >= [NO_MATTER * most[one] for one in stage]


def peak_matters(height: NDArray[np.float64], prominence: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether peaks of the largest force over speed rise enough above their surroundings to be named.

    height : (p,) of the peaks [N].  prominence : (p,) height above the higher of the lowest places on both sides, up to
    the next higher peak [N].
    """
    return prominence >= NO_MATTER * (height - prominence)


def nearest_verdict(
    names: Sequence[str],
    values: Sequence[float],
    limits: Sequence[KGammaLimit],
    *,
    assumed: Iterable[str],
    probability: float = JUDGED_AT,
) -> KGammaVerdict | None:
    """Verdict on the K_gamma that is nearest to its limit; None where no value is a number.

    Parameters
    ----------
    names : of n meshes or pairs.  values : (n,) mean-load K_gamma [1], nan where unknown.  limits : n of them.
    assumed : paths that the model assumes.  probability : share of the trains in which K_gamma stays below the values.
    """
    at = nearest_limit(values, [limit.value for limit in limits])
    if at is None:
        return None
    return KGammaVerdict(
        name=names[at],
        value=float(values[at]),
        limit=limits[at].value,
        source=limits[at].source,
        assumed=any(path.startswith(("deviations.", "tolerance.")) for path in assumed),
        probability=probability,
    )


def k_gamma_verdict(
    result: xr.Dataset, dim: str, mean: Sequence[float], *, probability: float = JUDGED_AT
) -> KGammaVerdict | None:
    """The same of a result along a dimension that has limits; None where the result has none."""
    if "k_gamma_limit" not in result.variables:
        return None
    columns = (result[f"k_gamma_limit{name}"].values.tolist() for name in ("", "_source"))
    limits = [KGammaLimit(value=value, source=str(source)) for value, source in zip(*columns, strict=True)]
    # the whole table of tolerances may be assumed: the drawing as it is does not rest on it
    tables = ("deviations", "tolerance") if result.attrs.get("verb") == "tolerance" else ("deviations",)
    paths = json.loads(str(result.attrs.get("assumed", "{}")))
    assumed = [f"{path}." if path in tables else path for path in paths]
    names = result[dim].values.tolist()
    return nearest_verdict(names, mean, limits, assumed=assumed, probability=probability)
