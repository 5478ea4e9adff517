"""Figures of the pages on the ready drives are plain SVG: renderers of SVG 1.1 show what a browser shows."""

from __future__ import annotations

import importlib.util
import io
import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import minimum_filter

PAGES = Path(__file__).parents[2] / "docs" / "papers"
DRAWN = sorted((PAGES / "figures").glob("*.svg"))
RAISED = '10\u200b<tspan style="font-size:70%" dy="-0.6em">−12</tspan><tspan dy="0.42em">\u200b</tspan>'


def identifier(path: Path) -> str:
    return path.stem


@cache
def make() -> Any:
    spec = importlib.util.spec_from_file_location("drives_make_plain", PAGES / "make.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_exponents_become_characters() -> None:
    assert make().plain_superscripts(f"<text>{RAISED}</text>") == "<text>10⁻¹²</text>"
    assert make().plain_superscripts("<text>10<tspan>3</tspan></text>") == "<text>10<tspan>3</tspan></text>"


@pytest.mark.parametrize("path", DRAWN, ids=identifier)
def test_no_text_has_a_relative_size_or_shift(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert not re.search(r"font-size:\s*[\d.]+(%|em)", text)
    assert "baseline-shift" not in text
    assert not re.search(r'<tspan[^>]* dy="-', text)


def inked(svg: str, size: int = 11) -> bool:
    """Whether a square of so many pixels at half the size is all dark text: no letter, line or symbol is as large."""
    try:
        import cairosvg
        from PIL import Image
    except (ImportError, OSError) as missing:  # the package, or the library below it
        pytest.skip(f"CairoSVG does not run here: {missing}")
    picture = io.BytesIO(cairosvg.svg2png(bytestring=svg.encode(), background_color="white", scale=0.5))
    grey = np.asarray(Image.open(picture).convert("L"))
    assert (grey < 250).mean() > 0.005  # something is drawn
    return bool(minimum_filter(grey < 60, size=size).any())


def test_a_blown_up_exponent_is_noticed() -> None:
    frame = '<svg xmlns="http://www.w3.org/2000/svg" width="900" height="500"><text x="99" y="470">{}</text></svg>'
    shown = '<rect width="900" height="9" y="200" fill="#888"/></svg>'
    assert inked(frame.format(RAISED).replace("</svg>", shown))
    assert not inked(frame.format(make().plain_superscripts(RAISED)).replace("</svg>", shown))


@pytest.mark.parametrize("path", DRAWN, ids=identifier)
def test_cairo_draws_what_a_browser_draws(path: Path) -> None:
    assert not inked(path.read_text(encoding="utf-8"))


def test_no_drawing_of_yue2014_names_a_speed() -> None:
    """The source prints none; the front view has the senses of rotation alone."""
    named = [path.stem for path in DRAWN if path.stem.startswith("yue2014") and "rpm" in path.read_text("utf-8")]
    assert named == []
