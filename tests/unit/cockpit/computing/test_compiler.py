"""The compiled solver beside the work: loaded when a process of its own has compiled, left alone where that failed."""

from __future__ import annotations

import threading

import pytest

from epicyclic.cockpit.computing import compute


@pytest.fixture(autouse=True)
def fresh(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compute, "_ready", threading.Event())
    monkeypatch.setattr(compute, "_started", threading.Event())


def test_it_is_loaded_after_it_was_compiled() -> None:
    loaded: list[bool] = []
    compute._compile("pass", lambda: loaded.append(compute.compiler_ready()))
    assert loaded == [False]
    assert compute.compiler_ready()


def test_where_compiling_fails_numpy_does_the_work() -> None:
    compute._compile("raise SystemExit(3)", lambda: pytest.fail("nothing to load"))
    assert not compute.compiler_ready()


def test_it_is_begun_once(monkeypatch: pytest.MonkeyPatch) -> None:
    codes: list[str] = []
    monkeypatch.setattr(compute, "numba_available", lambda: True)
    monkeypatch.setattr(compute, "_compile", lambda code, load: codes.append(code))
    module = "epicyclic.cockpit.computing.compute"
    __import__(module)
    threads = [compute.compile_aside(module, "compile_all") for _ in range(2)]
    assert threads[1] is None
    assert threads[0] is not None
    threads[0].join()
    assert codes == [f"from {module} import compile_all; compile_all()"]


def test_without_numba_nothing_is_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compute, "numba_available", lambda: False)
    assert compute.compile_aside("epicyclic.cockpit.computing.compute", "compile_all") is None
    assert not compute.compiler_ready()
