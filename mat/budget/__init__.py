"""The error budget of built databases, by source of error."""
