"""Tolerances of the drawing to distributions of the mesh-load factor: sampling, statistics, what each entry buys."""
