"""The commands of `mat`, one module each."""
