"""Measured and modelled columns of air as people have them: CSV, University of Wyoming, IGRA, netCDF."""
