"""Optimisation of micro-geometry: design variables, objectives, genetic search and the Dataset of a result."""
