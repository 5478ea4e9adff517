"""The five answers of the page, from what a frame of results holds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...system.system import System
from ...train.train import Train
from .answer import Answer
from .relief_answer import relief_answer
from .resonance import resonance_answer
from .sharing_answers import error_answer, float_answer, planet_answer

__all__ = ["answers_of"]

Part = Mapping[str, Any] | None


def answers_of(
    train: Train,
    system: System,
    *,
    modes: Part = None,
    sharing: Part = None,
    twin: Part = None,
    sweep: Part = None,
    errors: Part = None,
) -> tuple[Answer, ...]:
    """The five answers, within 3 ms.

    Parameters
    ----------
    modes, sharing, twin, sweep, errors : parts of a frame as `computing.compute` makes them, heads with their arrays
        beside by short names; None where there are none.
    """
    return (
        resonance_answer(train, system, modes, sweep),
        planet_answer(train, sharing, errors),
        float_answer(train, sharing, twin),
        error_answer(train, sharing, errors),
        relief_answer(train),
    )
