"""Measurements for developers: EnergyPlus's run time, omissions, a batch on a simulated cluster."""
