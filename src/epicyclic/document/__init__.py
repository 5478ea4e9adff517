"""Text to document: the model file, its units, overrides, schema and checks.  Knows no Train."""
