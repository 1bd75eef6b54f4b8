"""Meshing: curves, then faces, then volumes, so that what shares a curve shares its nodes."""
