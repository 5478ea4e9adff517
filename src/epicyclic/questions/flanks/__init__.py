"""Loaded tooth contact of a pair and of a train, micro-geometry and its optimisation, losses of meshes."""
