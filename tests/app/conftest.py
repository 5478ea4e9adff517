"""One browser and one cockpit for the tests of a file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from tests.app.cockpit_driver import Cockpit, launched, running


@pytest.fixture(scope="module")
def cockpit(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cockpit]:
    """The server, with ren2021 open, or the `MODEL` of the module."""
    with running(tmp_path_factory.mktemp("cockpit"), getattr(request.module, "MODEL", "ren2021")) as server:
        yield server


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """A headless Chromium."""
    with launched() as started:
        yield started
