"""Compiled kernels over plain arrays, one algorithm a file; nothing here knows what a plate is."""
