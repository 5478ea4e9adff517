"""A train as a REXS file: geometry, stiffnesses, masses, loads, K_gamma and mesh stiffness."""
