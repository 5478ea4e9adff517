"""Epicyclic gear trains: from a model file to modes, load sharing and response.

    import epicyclic
    train = epicyclic.load("ren2021", overrides={"stages.main.sun.mass": "700 kg"})
    system = epicyclic.assemble(train)
    epicyclic.modes(system).frequency

The names are those of the stub `__init__.pyi`.  They are imported when they are first used, so that
``import epicyclic`` is quick.
"""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

_STUB = Path(__file__).with_name("__init__.pyi").read_text(encoding="utf-8")
# name -> module that defines it
_HOME = {name: home for home, name in re.findall(r"^from (\S+) import (\w+) as \2$", _STUB, re.MULTILINE)}
_HOME |= dict(re.findall(r"^def (\w+)\(  # (\S+)$", _STUB, re.MULTILINE))

__all__ = sorted(_HOME)


def __getattr__(name: str) -> object:
    if name == "__version__":
        from .results.files import package_version

        return package_version()
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOME[name], __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
