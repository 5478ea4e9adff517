"""What all verbs share: their record, types of keywords, texts of a person to numbers; and all verbs in one report.

A source is the name of a ready drive, a path of a model file, a dict, or what has been loaded or assembled already.
Every verb takes ``overrides``, path -> value, as `load` does.
"""
