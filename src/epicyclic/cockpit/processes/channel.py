"""A pipe to another process, driven by two threads: the event loop neither waits for a full pipe nor for an answer."""

from __future__ import annotations

import asyncio
import queue
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

__all__ = ["Channel"]


class Channel:
    """Messages of a process as calls in the event loop, and messages to it.

    arrived : called in the event loop with each message.  ended : called there once, when the process has closed its
        end.
    """

    def __init__(
        self, connection: Connection, *, arrived: Callable[[Any], None], ended: Callable[[], None] | None = None
    ) -> None:
        self._connection = connection
        self._loop = asyncio.get_running_loop()
        self._arrived, self._ended = arrived, ended
        self._out: queue.SimpleQueue[Any] = queue.SimpleQueue()
        threading.Thread(target=self._receive, daemon=True).start()
        threading.Thread(target=self._send, daemon=True).start()

    def send(self, message: Any) -> None:
        """Send a message, later where the pipe is full."""
        self._out.put(message)

    def close(self) -> None:
        """Send what waits, and close."""
        self._ended = None
        self._out.put(None)

    def _send(self) -> None:
        while (message := self._out.get()) is not None:
            try:
                self._connection.send(message)
            except Exception:  # the process is gone, which the other thread tells, or nobody can pickle that
                self._tell_end()
                break
        # the other thread still reads until the process closes its end

    def _receive(self) -> None:
        while True:
            try:
                message = self._connection.recv()
            except Exception:  # closed, or a message that nobody can read
                break
            self._call(self._arrived, message)
        self._connection.close()
        self._out.put(None)
        self._tell_end()

    def _tell_end(self) -> None:
        ended, self._ended = self._ended, None
        if ended is not None:
            self._call(ended)

    def _call(self, function: Callable[..., None], *arguments: Any) -> None:
        try:
            self._loop.call_soon_threadsafe(function, *arguments)
        except RuntimeError:
            pass  # the loop is closed: nobody listens any more
