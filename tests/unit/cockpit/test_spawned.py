"""Processes of the cockpit while they start."""

from __future__ import annotations

import os
import signal
import time
from multiprocessing.connection import Connection

import pytest

from epicyclic.cockpit.processes.worker import spawned


def echo(connection: Connection) -> None:
    """Send one word."""
    connection.send("ready")


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals of POSIX")
def test_ctrl_c_does_not_reach_a_process_that_is_being_started() -> None:
    """Sent at once, while the interpreter of the process has not come to its first line."""
    process, connection = spawned(echo)
    assert process.pid is not None
    for _ in range(20):
        os.kill(process.pid, signal.SIGINT)
        time.sleep(0.005)
    assert connection.poll(20)
    assert connection.recv() == "ready"
    process.join(10)
    assert process.exitcode == 0
