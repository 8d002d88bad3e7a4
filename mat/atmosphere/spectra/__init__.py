"""Spectra and fluxes of one state: a line of sight point by point, broadband fluxes on the ground."""
