"""Words explained: paths of the model file, variables of results, codes of warnings, verbs and figures."""
