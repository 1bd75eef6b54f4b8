"""The HTTP service, version 1: the same pipeline behind models, overrides, jobs, meshes and rule bases."""
