"""What a parameter of the model file moves: loci of natural frequencies, map of instability, any quantity over values."""
