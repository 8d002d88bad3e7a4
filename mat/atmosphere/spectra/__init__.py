"""Spectra of one line of sight and broadband fluxes on the ground, for one atmospheric state."""
