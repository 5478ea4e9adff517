"""Bodies that bend: the thin ring."""
