"""Datasets for people: figures, tables, and the report.  Computes nothing."""
