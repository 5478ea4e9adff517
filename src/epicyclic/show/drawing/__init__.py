"""The train to scale, from the front and in an axial section: Dataset of `check` -> plotly Figure."""
