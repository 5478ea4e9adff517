"""A user who visits one control of the page."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from nicegui.testing.user import User
from nicegui.testing.user_simulation import user_simulation
from tests.unit.cockpit.dialog_session import FakeSession

from epicyclic.cockpit.state.state import opened

Talk = Callable[[User, FakeSession], Awaitable[None]]


def visit(build: Callable[[Any], None], talk: Talk, session: FakeSession | None = None) -> FakeSession:
    """Build a control for a session, of ren2021 unless given, and have a user talk to it."""
    shown = session or FakeSession(opened("ren2021"))

    async def run() -> None:
        async with user_simulation(root=lambda: build(shown)) as user:
            await user.open("/")
            await talk(user, shown)

    asyncio.run(run())
    return shown


def put(user: User, marker: str, value: object) -> None:
    """Type into the field with a marker."""
    with user:
        for element in user.find(marker=marker).elements:
            element.value = value  # type: ignore[attr-defined]
