"""Ladders of single parts, for developers: error against run time of surfaces, batches, omissions."""
