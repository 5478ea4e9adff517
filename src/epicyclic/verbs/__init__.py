"""The verbs: a source in, a Dataset out; one file a verb, a typed function and its record.

A source is the name of a ready drive, a path of a model file, a dict, or what has been loaded or assembled already.
Every verb takes ``overrides``, path -> value, as `load` does.
"""
