"""Gears in mesh as the kinematics of a train takes them, for tests of power and of its losses."""

from __future__ import annotations

from epicyclic.train.kinematics import Gearing

__all__ = ["pair"]


def pair(stage: str, a: str, b: str, za: int, zb: int, *, internal: bool = False, carrier: bool = True) -> Gearing:
    """Gears `a` and `b` of a stage with their tooth counts; without `carrier` their centres are at rest."""
    return Gearing(
        pair=f"stages.{stage}.meshes.{a}-{b}",
        stage=stage,
        a=f"{stage}.{a}",
        b=f"{stage}.{b}",
        teeth_a=za,
        teeth_b=zb,
        internal=internal,
        carrier=f"{stage}.carrier" if carrier else None,
    )
