"""The error budget of built databases, source by source."""
