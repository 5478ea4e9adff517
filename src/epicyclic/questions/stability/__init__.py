"""Stability of the periodic motion: Floquet multipliers, instability boundaries by averaging, map over two parameters."""
