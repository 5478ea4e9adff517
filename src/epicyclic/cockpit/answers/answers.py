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

__all__ = ["full_answers", "live_answers"]

Part = Mapping[str, Any] | None


def live_answers(
    train: Train,
    system: System | None,
    *,
    modes: Part = None,
    sharing: Part = None,
    twin: Part = None,
    sweep: Part = None,
    errors: Part = None,
) -> tuple[Answer, ...]:
    """The five answers while a lever moves, within 3 ms.

    Parameters
    ----------
    system : None where the train cannot be assembled.
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


def full_answers(
    train: Train,
    system: System | None,
    *,
    modes: Part = None,
    sharing: Part = None,
    twin: Part = None,
    sweep: Part = None,
    errors: Part = None,
) -> tuple[Answer, ...]:
    """The same of a state at rest: sharing of the whole hunting period, the map of errors."""
    return live_answers(train, system, modes=modes, sharing=sharing, twin=twin, sweep=sweep, errors=errors)
