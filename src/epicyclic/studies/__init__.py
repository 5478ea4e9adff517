"""Studies: answers that need the Train, its teeth or many trains, where an analysis needs one System.

Depends on: document, train, teeth, system, engine, statics, analyses, results.
"""
