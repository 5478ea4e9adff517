"""The validated document -> the frozen Train: everything that follows from what the file says."""
