"""Epicyclic gear trains: from a model file to modes, load sharing and response.

    import epicyclic
    train = epicyclic.load("ren2021", overrides={"stages.main.sun.mass": "700 kg"})
    system = epicyclic.assemble(train)
    epicyclic.modes(system).frequency

Names are imported when they are first used, so that ``import epicyclic`` is quick.

Depends on: nothing at import; every room when used.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

from .errors import ConvergenceError, ModelError

if TYPE_CHECKING:
    from .assemble import assemble
    from .audits.audit import audit
    from .resolve import load
    from .results.dataset import load_result, save_result, to_json
    from .show.report import write_report
    from .studies.curves import vary
    from .system.system import System
    from .train.train import Train
    from .verbs.verbs import (
        campbell,
        check,
        contact,
        modes,
        modulation,
        relief,
        sensitivity,
        sharing,
        stability,
        static,
        steady,
        stiffness,
        sweep,
        track,
        train_contact,
        transient,
    )

__all__ = [
    "ConvergenceError",
    "ModelError",
    "System",
    "Train",
    "assemble",
    "audit",
    "campbell",
    "check",
    "contact",
    "load",
    "load_result",
    "modes",
    "modulation",
    "relief",
    "save_result",
    "sensitivity",
    "sharing",
    "stability",
    "static",
    "steady",
    "stiffness",
    "sweep",
    "to_json",
    "track",
    "train_contact",
    "transient",
    "vary",
    "write_report",
]

_HOME = {
    "System": "system.system",
    "Train": "train.train",
    "assemble": "assemble",
    "audit": "audits.audit",
    "load": "resolve",
    "load_result": "results.dataset",
    "save_result": "results.dataset",
    "to_json": "results.dataset",
    "vary": "studies.curves",
    "write_report": "show.report",
    **dict.fromkeys(
        (
            "campbell",
            "check",
            "contact",
            "modes",
            "modulation",
            "sensitivity",
            "relief",
            "sharing",
            "stability",
            "static",
            "steady",
            "stiffness",
            "sweep",
            "track",
            "transient",
            "train_contact",
        ),
        "verbs.verbs",
    ),
}


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import PackageNotFoundError, version

        try:
            return version(__name__)
        except PackageNotFoundError:  # run from a source tree that is not installed
            return "unknown"
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOME[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


class _Package(ModuleType):
    """The package; its `assemble` stays the function when the module of the same name is imported."""

    def __setattr__(self, name: str, value: object) -> None:
        if name == "assemble" and isinstance(value, ModuleType):
            value = value.assemble
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
