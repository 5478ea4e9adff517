"""Words for how a periodic motion is left, by where its largest Floquet multiplier leaves the unit circle.

One vocabulary for all analyses: at +1 a linear system has one word, ``divergence``; with teeth that part the branch of
the motion tells two of its forms apart, a ``fold``, where it turns back, and ``symmetry breaking``, where another one
with less symmetry leaves it.
"""

from __future__ import annotations

__all__ = ["BREAKING", "DIVERGENCE", "DOUBLING", "FOLD", "KINDS", "QUASI_PERIODIC", "STABLE", "outside"]

STABLE = "stable"
DIVERGENCE, DOUBLING, QUASI_PERIODIC = "divergence", "period doubling", "quasi-periodic"
FOLD, BREAKING = "fold", "symmetry breaking"
KINDS = (STABLE, DIVERGENCE, DOUBLING, QUASI_PERIODIC)


def outside(multiplier: complex, *, circle: float, real: float) -> str:
    """The kind of a largest multiplier: stable within 1 + `circle`; on the real axis within `real` of its magnitude.

    Near +1 ``divergence``, growth at mesh orders; near -1 ``period doubling``, at half orders; else
    ``quasi-periodic``, two modes together.
    """
    if abs(multiplier) <= 1 + circle:
        return STABLE
    if abs(multiplier.imag) > real * abs(multiplier):
        return QUASI_PERIODIC
    return DIVERGENCE if multiplier.real > 0 else DOUBLING
