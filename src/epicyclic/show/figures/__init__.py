"""Dataset -> plotly Figure: one file a figure, named by its function; one palette and one template (`style`).

    from epicyclic.show.figures.mode_shapes import mode_shapes

Files without a function of their own name are what figures share; of these `series` and `summaries` do not import
plotly.

Depends on: results (the names of variables).
"""
