"""The cockpit: a local page on which a gear train answers while its numbers are moved."""
