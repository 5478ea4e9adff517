"""The corpus of broken files, for the tests beside it."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest


def load_corpus() -> ModuleType:
    """Return the module of the corpus; test folders are no packages."""
    path = Path(__file__).with_name("corpus.py")
    spec = importlib.util.spec_from_file_location("broken_files_corpus", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


CORPUS = load_corpus()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Parametrise tests that take `case` or `raw`."""
    for name, cases in (
        ("read_case", [c for c in CORPUS.CASES if c.stage == "read"]),
        ("resolve_case", [c for c in CORPUS.CASES if c.stage == "resolve"]),
    ):
        if name in metafunc.fixturenames:
            metafunc.parametrize(name, cases, ids=lambda c: c.name)
    if "raw" in metafunc.fixturenames:
        metafunc.parametrize(("raw", "word"), [(b, w) for _, b, w in CORPUS.BYTES], ids=[n for n, _, _ in CORPUS.BYTES])


@pytest.fixture(scope="session")
def base_text() -> str:
    """The text of the file every broken one is made from."""
    return str(CORPUS.BASE)
