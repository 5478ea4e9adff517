"""Stability of the periodic motion: Floquet multipliers, boundaries by averaging, map over two parameters."""
