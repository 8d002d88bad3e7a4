"""Atmospheric quantities of a band on a grid: equations (8) to (34) of DSTO-TN-0193."""
