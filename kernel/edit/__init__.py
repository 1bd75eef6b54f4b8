"""Editing finished meshes by hand: merging, connecting, adding, moving and deleting."""
