"""Stability of the periodic motion: Floquet multipliers, and instability boundaries by averaging."""
