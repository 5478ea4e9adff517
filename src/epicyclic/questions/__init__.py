"""Questions of a train, one folder each: analysis, options and record."""
