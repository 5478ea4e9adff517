"""Several models or results beside each other: what differs in the drawing, and what it does."""
