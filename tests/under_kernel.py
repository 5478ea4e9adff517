"""Pytest under one kernel of OpenBLAS: ``python tests/under_kernel.py KERNEL [ARGUMENTS OF PYTEST]``.

A kernel that this processor cannot run, or that this OpenBLAS does not have, is named as not tried.
"""

from __future__ import annotations

import os
import subprocess
import sys

# names of NumPy 2.4; another version warns of names that it does not know
WIDE = "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"
# tables of one kernel that OpenBLAS builds once for 64 bits, by the name that it gives
SAME = {"Prescott": "Katmai"}
PROBE = """
import numpy, threadpoolctl
numpy.linalg.inv(numpy.eye(200) + 1)
print(*{one["architecture"] for one in threadpoolctl.threadpool_info() if one["internal_api"] == "openblas"})
"""


def main(name: str, *arguments: str) -> int:
    """Exit status of pytest; 0 where the kernel is not tried."""
    core = "Nehalem" if name == "NoAVX2" else name
    changed = {"OPENBLAS_CORETYPE": core, "OPENBLAS_NUM_THREADS": "1"}
    if name == "NoAVX2":
        changed["NPY_DISABLE_CPU_FEATURES"] = WIDE
    environment = os.environ | changed
    probe = subprocess.run([sys.executable, "-c", PROBE], env=environment, capture_output=True, text=True)
    if probe.returncode or probe.stdout.split() not in ([core], [SAME.get(core)]):
        given = probe.stdout.strip() or f"status {probe.returncode}"
        print(f"kernel {name}: not tried, this processor and this OpenBLAS give {given}")
        return 0
    print(f"kernel {name}", flush=True)
    return subprocess.run([sys.executable, "-m", "pytest", *arguments], env=environment).returncode


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
