"""The job of `tmm`: typed models and the reader of job files."""
