"""Laws of gaps: what force a gap, or a group of gaps, gives."""
