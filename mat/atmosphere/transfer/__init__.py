"""Radiative transfer: refracted lines of sight, optical depths, source functions, scattering."""
