"""The compiled solver beside the work: loaded when a process of its own has compiled, left alone where that failed."""

from __future__ import annotations

import threading

import pytest

from epicyclic.cockpit.computing import compiler


@pytest.fixture(autouse=True)
def fresh(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiler, "_ready", threading.Event())
    monkeypatch.setattr(compiler, "_started", threading.Event())


def test_it_is_loaded_after_it_was_compiled() -> None:
    loaded: list[bool] = []
    compiler._compile("pass", lambda: loaded.append(compiler.compiler_ready()))
    assert loaded == [False]
    assert compiler.compiler_ready()


def test_where_compiling_fails_numpy_does_the_work() -> None:
    compiler._compile("raise SystemExit(3)", lambda: pytest.fail("nothing to load"))
    assert not compiler.compiler_ready()


def test_it_is_begun_once(monkeypatch: pytest.MonkeyPatch) -> None:
    codes: list[str] = []
    monkeypatch.setattr(compiler, "numba_available", lambda: True)
    monkeypatch.setattr(compiler, "_compile", lambda code, load: codes.append(code))
    module = "epicyclic.cockpit.computing.compute"
    __import__(module)
    threads = [compiler.compile_aside(module, "compile_all") for _ in range(2)]
    assert threads[1] is None
    assert threads[0] is not None
    threads[0].join()
    assert codes == [f"from {module} import compile_all; compile_all()"]


def test_without_numba_nothing_is_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiler, "numba_available", lambda: False)
    assert compiler.compile_aside("epicyclic.cockpit.computing.compute", "compile_all") is None
    assert not compiler.compiler_ready()
