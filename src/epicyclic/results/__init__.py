"""Labelled Datasets: the variables they may hold, how they are made, written and read."""
