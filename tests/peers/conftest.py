"""The peers as a package: tests have none, and relative imports need one."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest


@pytest.fixture(scope="session")
def plane() -> ModuleType:
    """Spur gears in plane strain by finite elements."""
    return _module("pair")


@pytest.fixture(scope="session")
def face() -> ModuleType:
    """Teeth on their bodies in three dimensions by finite elements."""
    return _module("tabulate_face")


@pytest.fixture(scope="session")
def root() -> ModuleType:
    """Stress in the tooth roots of spur gears in plane strain by finite elements."""
    return _module("tabulate_root")


def _module(module: str) -> ModuleType:
    name = "epicyclic_peers_plane"
    if name not in sys.modules:
        package = ModuleType(name)
        package.__path__ = [str(Path(__file__).with_name("plane"))]
        sys.modules[name] = package
    return import_module(f"{name}.{module}")
