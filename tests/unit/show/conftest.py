"""Made-up Datasets for the figures: a herringbone train (`ren`) and a planar one of N planets (`lin`)."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest
import xarray as xr


def _load() -> ModuleType:
    """The folder `synthetic` as a package: tests have none, and relative imports need one."""
    name = "epicyclic_synthetic"
    if name not in sys.modules:
        package = ModuleType(name)
        package.__path__ = [str(Path(__file__).with_name("synthetic"))]
        sys.modules[name] = package
    return import_module(f"{name}.results")


@pytest.fixture(scope="session")
def synthetic() -> ModuleType:
    return _load()


@pytest.fixture(scope="session")
def ren(synthetic: ModuleType) -> dict[str, xr.Dataset]:
    datasets: dict[str, xr.Dataset] = synthetic.everything(synthetic.REN)
    return datasets


@pytest.fixture(scope="session")
def lin(synthetic: ModuleType) -> dict[str, xr.Dataset]:
    datasets: dict[str, xr.Dataset] = synthetic.everything(synthetic.lin_gears(4))
    return datasets
