"""Writing: the model as a text for a solver, one file a format."""
