"""Datasets for people: charts, drawings of the train, views (tables and report section of each kind of result), report.

Computes nothing.  Depends on: results.
"""
