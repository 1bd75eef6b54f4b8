"""Reading: CSG text to a tree of frozen values with a place on every node."""
