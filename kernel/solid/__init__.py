"""Evaluating: a CSG tree to a solid whose triangles lead back to analytic surfaces."""
