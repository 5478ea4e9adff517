"""One browser and one cockpit of each model for the tests of the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import cache
from typing import Any

import pytest
from tests.app.canvas_page import loaded, opened
from tests.app.cockpit_driver import Cockpit, launched, running


@pytest.fixture(scope="package")
def cockpits(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[str], Cockpit]]:
    """The server that has a model open, a ready drive or a file; started for the first who asks."""
    with ExitStack() as servers:

        @cache
        def serving(model: str) -> Cockpit:
            return servers.enter_context(running(tmp_path_factory.mktemp("cockpit"), model))

        yield serving


@pytest.fixture(scope="module")
def cockpit(request: pytest.FixtureRequest, cockpits: Callable[[str], Cockpit]) -> Cockpit:
    """The server, with ren2021 open, or the `MODEL` of the module."""
    return cockpits(str(getattr(request.module, "MODEL", "ren2021")))


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
