"""Absorption data for developers: generated lines, points of broadband fluxes."""
