"""Controls of the page that open, change, compare and take away a model: one file each."""
