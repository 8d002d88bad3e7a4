"""The commands of `tmm`, one module each."""
