"""The report: one self-contained page about a meshed model, with pictures of our own drawing."""
