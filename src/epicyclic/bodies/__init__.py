"""One body that bends: its coordinates, matrices and shape; the thin ring, bodies reduced by other programs."""
