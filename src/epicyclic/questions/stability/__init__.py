"""Stability of the periodic motion: Floquet multipliers, boundaries by averaging."""
