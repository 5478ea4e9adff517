"""System -> Dataset: modes, static equilibrium, periodic response, load sharing.

Depends on: system, results.
"""
