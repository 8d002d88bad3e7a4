"""Benchmarks: error against run time of each part of `mat`, beside other codes, and stability tests."""
