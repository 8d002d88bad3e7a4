"""What a job of `tmm` says: its types, and reading it from a file."""
