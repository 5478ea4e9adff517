"""Made-up Datasets for the figures: a herringbone train (`ren`) and a planar one of N planets (`lin`)."""

from __future__ import annotations

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest
import xarray as xr


def _load() -> ModuleType:
    name = "epicyclic_synthetic_datasets"
    if name not in sys.modules:
        spec = spec_from_file_location(name, Path(__file__).with_name("synthetic.py"))
        assert spec is not None
        assert spec.loader is not None
        sys.modules[name] = module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])
    return sys.modules[name]


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
