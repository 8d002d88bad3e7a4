"""Mapping of a job's textures to materials, and writing of their databases."""
