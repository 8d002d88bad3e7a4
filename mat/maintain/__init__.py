"""Programs for maintainers: they derive the packaged data, the JSON Schemas and the format pages."""
