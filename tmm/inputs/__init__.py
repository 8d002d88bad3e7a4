"""Readers of the inputs of a job: images, seed polygons and seed texels."""
