"""Extinction, scattering and phase functions of aerosol, cloud and rain."""
