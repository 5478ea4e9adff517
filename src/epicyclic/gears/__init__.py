"""Geometry, micro-geometry, phasing, deviations and ISO stiffness of one gear or of one pair of gears.

Depends on: nothing of the package but errors.
"""
