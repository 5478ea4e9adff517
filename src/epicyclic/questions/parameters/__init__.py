"""What a parameter of the model file moves: loci of frequencies, map of instability, any quantity."""
