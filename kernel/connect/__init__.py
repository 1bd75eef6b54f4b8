"""Connecting: couplings where dimensions change, and the checks that prove the model."""
