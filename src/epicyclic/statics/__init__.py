"""Statics: equilibrium with unilateral meshes and laws, its tangent, records, loads of many samples.

Depends on: system, engine, results.  Below all questions.
"""
