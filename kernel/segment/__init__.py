"""Splitting: a solid into disjoint segments, as the conclusions say."""
