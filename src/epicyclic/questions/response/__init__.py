"""Steady response to mesh and shaft orders by matrix-free harmonic balance, linear contact."""
