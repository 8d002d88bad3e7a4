"""Computations of a scene runtime with the tables: the radiance error of a wrong material."""
