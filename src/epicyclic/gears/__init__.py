"""One gear, one tooth pair: geometry, phasing, deviations, stiffness.  Knows no train.

Depends on: nothing of the package but errors.
"""
