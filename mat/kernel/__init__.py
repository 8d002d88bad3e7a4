"""Computations of a pixel and of light along lines, in C: sources, their compiler, the library that Python loads."""
