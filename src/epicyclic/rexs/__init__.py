"""REXS, the exchange format of gear units: its files as data, read safely and written, and turned into a model file."""
