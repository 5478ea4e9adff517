"""Published numbers of the ready drives beside ours."""

FIGURES = {"audit": ()}
"""Kind of result -> names of its figures."""
