"""The answer on tip relief: the usual first estimate from the deflection of the teeth, until the job has searched."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...document.tables import leaves
from ...document.units import factor
from ...document.written_numbers import written
from ...system.tooth_pairs import mean_force
from ...train.bodies import Mesh
from ...train.train import Train
from .answer import Answer, Level, answer, number

__all__ = ["ReliefEstimate", "drawn_relief", "estimates_of", "relief_answer"]

# A drawn relief within this part of the estimate needs no word: the estimate is no better.
_WITHIN = 0.4
# A deflection below this needs no relief [m]: grinding does not hold it.
_LITTLE = 2e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class ReliefEstimate:
    """First estimate of the tip relief of one pair of gears.

    pair : path in the model file.  amount : deflection of a single pair of teeth at the operating load [m].
    module : normal, of the pair [m].  counted : whether the stiffness of the pair knows its relief.
    """

    pair: str
    amount: float
    module: float
    counted: bool


def estimates_of(train: Train) -> list[ReliefEstimate]:
    """The deflection F/(c' b) of a single pair of teeth under the mean mesh force, for every pair of gears with teeth.

    c' b follows from the mean mesh stiffness of the model by c_gamma = c' (0.75 eps_alpha + 0.25) [iso6336].
    """
    found: dict[str, ReliefEstimate] = {}
    gear = {body.name: body.gear for body in train.bodies}
    for mesh in train.meshes:
        first = gear[mesh.a]
        if mesh.pair in found or mesh.teeth is None or first is None:
            continue
        amount = _deflection(train, mesh)
        if math.isfinite(amount) and amount > 0:
            counted = mesh.table is not None
            found[mesh.pair] = ReliefEstimate(pair=mesh.pair, amount=amount, module=first.module, counted=counted)
    return list(found.values())


def _deflection(train: Train, mesh: Mesh) -> float:
    ratio = mesh.contact_ratio
    if ratio is None or not mesh.stiffness > 0:
        return math.nan
    single = mesh.stiffness / (0.75 * float(ratio) + 0.25)
    return mean_force(train, mesh) / single


def drawn_relief(train: Train) -> float:
    """Largest tip relief of the model file [m]; 0 without one."""
    amounts = [value for path, value in leaves(dict(train.document)) if path.endswith("tip_relief.amount")]
    return max((_metres(value) for value in amounts), default=0.0)


def _metres(value: object) -> float:
    """A length of the file [m], a bare one is SI; the largest of a list; 0 of anything else."""
    number = written(value)
    if number is None:
        return 0.0
    scale = factor(number.unit, "m") if number.unit else 1.0
    return max(number.values) * (scale or 0.0)


def relief_answer(train: Train) -> Answer:
    """The estimate of the pair that bends most, beside what is drawn; the job searches for the least error."""
    if not any(mesh.teeth is not None for mesh in train.meshes):
        text = "Not known: no gear has a face width, so no flank can be relieved (stages.STAGE.face_width)."
        return answer("relief", text)
    estimates = estimates_of(train)
    if not estimates:
        return answer("relief", "Not known: no torque loads the teeth (operation.torque).")
    largest = max(estimates, key=lambda one: one.amount)
    drawn, um = drawn_relief(train), 1e6 * largest.amount
    pair = largest.pair.rpartition(".")[2]
    figure = f"≈ {number(um, 2)} µm"
    text = f"About {number(um, 2)} µm at the tips of {pair}: first estimate F/(c' b) at operating load"
    counts = "" if largest.counted else f' Forces and K_v count it with {largest.pair}.stiffness = "contact" alone.'
    if not drawn:
        level: Level = "warn" if largest.amount > _LITTLE else "good"
        text = f"{text}; none is drawn.{counts if level == 'warn' else ''}"
        return answer("relief", text, figure=figure, level=level, evidence="relief", job="relief")
    level = "good" if abs(drawn / largest.amount - 1) <= _WITHIN else "warn"
    figure = f"{number(1e6 * drawn)} µm"
    text = f"is drawn; a first estimate F/(c' b) at operating load is {number(um, 2)} µm at the tips of {pair}.{counts}"
    return answer("relief", text, figure=figure, level=level, evidence="relief", job="relief")
