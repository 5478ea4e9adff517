"""Rolling bearings: geometry, loads of their elements, rating life.  Numbers alone; no train."""
