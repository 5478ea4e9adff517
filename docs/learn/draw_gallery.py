"""Draw the figures of the gallery: python docs/learn/draw_gallery.py [EXAMPLE ...]

The figure of each script in examples/, written to docs/learn/gallery/EXAMPLE.svg as those of the pages on the drives.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

HERE = Path(__file__).parent
EXAMPLES = HERE.parents[1] / "examples"


def module_of(path: Path) -> ModuleType:
    """A script as a module, its work done."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def draw(names: list[str]) -> None:
    """Draw the figures of some examples, or of all."""
    make = module_of(HERE.parent / "papers" / "make.py")
    (HERE / "gallery").mkdir(exist_ok=True)
    with make.renderer() as to_svg:
        for path in sorted(EXAMPLES.glob("*.py")):
            if not names or path.stem in names:
                target = HERE / "gallery" / f"{path.stem}.svg"
                target.write_text(to_svg(module_of(path).figure(), f"gallery-{path.stem}"), encoding="utf-8")
                print(target.relative_to(HERE.parents[1]), flush=True)


if __name__ == "__main__":
    draw(sys.argv[1:])
