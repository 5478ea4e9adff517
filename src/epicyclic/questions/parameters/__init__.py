"""What a parameter of the model file moves: frequencies, a map of instability, any quantity over its values."""
