"""What the bits of a result depend on, beside its job: packages, and the kind of CPU."""

from __future__ import annotations

import platform

import numpy as np
import scipy

from ...results.files import package_version

__all__ = ["machine", "versions"]


def versions() -> dict[str, str]:
    """Versions of the packages that the bits of a result depend on."""
    return {"epicyclic": package_version(), "numpy": np.__version__, "scipy": scipy.__version__}


def machine() -> str:
    """Kind of CPU that this process computes on: between kinds results may differ in their last bits."""
    name = ""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            name = next((line.partition(":")[2].strip() for line in file if line.startswith("model name")), "")
    except OSError:
        pass
    return f"{platform.machine()} {name or platform.processor()}".strip()
