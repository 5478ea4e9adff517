"""Results for people in a terminal: tables with units, warnings first.

Depends on: results (as Datasets only).
"""

from .show import key_figures, show, show_pairs, stdout_console, warnings_of

__all__ = ["key_figures", "show", "show_pairs", "stdout_console", "warnings_of"]
