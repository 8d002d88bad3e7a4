"""Atmospheric quantities as monochromatic channels on three axes: no range axis whose cells straddle the ground."""
