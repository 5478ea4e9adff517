"""One browser and one cockpit for the tests of the page: a server and its processes take nine seconds to start."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from tests.app.canvas_page import loaded, opened
from tests.app.cockpit_driver import Cockpit, launched, running

from epicyclic.cockpit.state.state import fragment_of
from epicyclic.cockpit.state.state import opened as state_of


@pytest.fixture(scope="package")
def serving(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cockpit]:
    """The server, with ren2021 open."""
    with running(tmp_path_factory.mktemp("cockpit")) as server:
        yield server


@pytest.fixture(scope="module")
def cockpit(request: pytest.FixtureRequest, serving: Cockpit) -> Cockpit:
    """The server; its address opens the `MODEL` of the module by a link: a ready drive, a file or a state."""
    model = getattr(request.module, "MODEL", None)
    if model is None:
        return serving
    state = state_of(model) if isinstance(model, str | Path) else model
    return replace(serving, address=f"{serving.address}#{fragment_of(state)}")


@pytest.fixture(scope="package")
def browser() -> Iterator[Any]:
    """A headless Chromium."""
    with launched() as started:
        yield started


@pytest.fixture(scope="module")
def one_page(browser: Any) -> Iterator[Any]:
    """The page of the panes alone."""
    found = opened(browser)
    yield found
    found.context.close()


@pytest.fixture
def page(one_page: Any) -> Iterator[Any]:
    """The page as it is loaded, for every test anew."""
    one_page.problems.clear()
    loaded(one_page)
    yield one_page
    assert one_page.problems == []
