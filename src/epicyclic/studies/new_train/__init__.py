"""A new train from the first numbers of a drawing: teeth or ratio, power and speed to a model file that runs."""
