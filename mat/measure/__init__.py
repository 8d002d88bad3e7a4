"""Errors that every build measures: random probes, error scales, axis profiles, nodes placed by tolerance."""
