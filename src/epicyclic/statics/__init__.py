"""Statics: equilibrium with unilateral meshes and laws, its tangent, records, loads of many samples.

Depends on: system, engine, results.  Below all questions.  Options of its verb.
"""

from dataclasses import dataclass

from ..options import Cycles, Of, Samples, Turns

FIGURES = {"static": ("static-forces", "static-errors", "sensors", "ring-bending", "load-zones")}
"""Kind of result -> names of its figures."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StaticOptions:
    """Options of the static equilibrium: its record, as of `record.record_of`."""

    cycles: Cycles = None
    turns: Turns = None
    of: Of = None
    samples: Samples = None
