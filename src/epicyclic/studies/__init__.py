"""Whole runs: a source in, a Dataset out; many trains at once.

Depends on: files, assemble, analyses, results.
"""
