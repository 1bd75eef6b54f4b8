"""Idealising: each segment as axis and section, mid-surface, or solid; joined on shared curves."""
