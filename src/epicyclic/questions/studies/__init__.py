"""What moves an answer: derivatives, a number of the model over its values, several trains beside each other."""
