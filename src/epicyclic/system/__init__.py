"""The System: matrices, gaps with laws, exact excitation lines.  Analyses depend on it and on no gear.

Depends on: numpy and scipy only.
"""
