"""Studies: answers that need the Train, its teeth or many trains, where an analysis needs one System.

Depends on: model, resolve, train, teeth, assemble, system, analyses, results.
"""
