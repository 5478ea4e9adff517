"""Bodies that bend, from finite elements: read, checked, reduced.  Matrices alone; no train."""
