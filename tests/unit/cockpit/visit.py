"""A user who visits one control of the page."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from typing import Any

from nicegui.testing.user import User
from nicegui.testing.user_simulation import user_simulation
from tests.unit.cockpit.dialog_session import FakeSession

from epicyclic.cockpit.state.state import opened

Talk = Callable[[User, FakeSession], Awaitable[None]]


def visit(build: Callable[[Any], object], talk: Talk, session: FakeSession | None = None) -> FakeSession:
    """Build a control for a session, of ren2021 unless given, and have a user talk to it."""
    shown = session or FakeSession(opened("ren2021"))

    failures: list[BaseException] = []

    async def run() -> None:
        async with user_simulation(root=lambda: build(shown)) as user:
            await user.open("/")
            try:
                await talk(user, shown)
            except Exception as error:  # raised below: the simulation ends by itself only where nothing is raised in it
                failures.append(error)

    asyncio.run(run())
    if failures:
        raise failures[0]
    return shown


def put(user: User, marker: str, value: object) -> None:
    """Type into the field with a marker."""
    with user:
        for element in user.find(marker=marker).elements:
            element.value = value  # type: ignore[attr-defined]


async def until(holds: Callable[[], Any]) -> None:
    """Wait until something holds, on a busy machine too. Fails where it does not within a minute."""
    end = time.monotonic() + 60
    while not holds():
        assert time.monotonic() < end, "it never came"
        await asyncio.sleep(0.02)


async def seen(user: User, text: str | None = None, *, marker: str | None = None) -> None:
    """Wait until the page shows a text or a marked element."""
    if text is not None:
        await user.should_see(text, retries=80)
    else:
        await user.should_see(marker=marker, retries=80)
