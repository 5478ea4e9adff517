"""What many points of a model are computed with: sources, samples, worker processes, run folders, blocks and studies.

Depends on: document, train, system, results.  Workers and run folders, which analyses use, know no Train.
"""
