"""Absorption data for developers: generated lines, spliced tables, points of broadband fluxes."""
