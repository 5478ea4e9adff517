"""A verb over many points of a model: a job file, its points, and their results as one Dataset."""
