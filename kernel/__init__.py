"""The numerical core: a chain of pure functions from CSG text to a connected finite element model."""
