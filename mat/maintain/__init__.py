"""Programs for maintainers: packaged data, JSON Schemas, format pages, a package without MT_CKD."""
