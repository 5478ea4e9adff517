"""The verbs: a source in, a Dataset out.  What the command line, notebooks and programs call."""
