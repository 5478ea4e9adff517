"""Equilibrium with unilateral meshes and laws, instant by instant or as a record with memory."""
