"""Dataset -> plotly Figure: one function a chart, with the palette, template and specs of `renderers`.

    from epicyclic.show.charts.mode_shapes import mode_shapes

Every module here imports plotly; what tables read too stands in `show.series`.

Depends on: results (the names of variables).
"""
