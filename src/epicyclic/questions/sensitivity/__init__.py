"""Derivatives of natural frequencies (closed form) and of mesh forces (adjoint of the harmonic balance)."""
