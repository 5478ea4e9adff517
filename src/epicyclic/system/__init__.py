"""The waist: matrices, gaps, laws, exact lines.  Analyses see this and never a gear.

Depends on: numpy and scipy only.
"""
