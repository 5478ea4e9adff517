"""Sphinx: the pages of this folder as one site, built without a network by `make docs`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "src")]

import site_docstrings  # noqa: E402  (beside this file)

from epicyclic import __version__  # noqa: E402

project = "epicyclic"
author = "the authors of epicyclic"
project_copyright = "the authors of epicyclic, BSD-3-Clause"
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_copybutton", "sphinx_design"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build"]
templates_path: list[str] = []

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4  # pages link to headings as GitHub names them

autodoc_member_order = "bysource"
python_use_unqualified_type_names = True
nitpicky = True
# Types of other packages and aliases of our own have no page here; everything else in a signature must lead somewhere.
nitpick_ignore_regex = [(r"py:.*", site_docstrings.WITHOUT_PAGE)]

html_theme = "pydata_sphinx_theme"
html_title = "epicyclic"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options: dict[str, Any] = {
    "navbar_align": "left",
    "navigation_with_keys": False,
    "show_prev_next": True,
    "show_toc_level": 2,
    "header_links_before_dropdown": 6,
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True


def setup(app: Any) -> None:
    """Let Sphinx read the docstrings as they are written here."""
    app.connect("autodoc-process-docstring", site_docstrings.as_restructured_text)
    app.connect("autodoc-process-signature", site_docstrings.signature_text)
