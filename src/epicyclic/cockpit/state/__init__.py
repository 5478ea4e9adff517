"""What the page stands for: a model text with overrides, its history, its links."""
