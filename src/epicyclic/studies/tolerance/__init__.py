"""Tolerances of the drawing: columns, sampling, statistics of K_gamma, and the cheapest grades that meet a target."""
