"""Laws of gaps: force of one gap, or of a group of gaps, as a function of its stretch."""
