"""Datasets for people: figures, views (tables and report section of each kind of result), terminal, report.

Computes nothing.  Depends on: results.
"""
