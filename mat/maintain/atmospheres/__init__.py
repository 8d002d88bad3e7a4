"""Programs that derive the packaged atmospheric data from their published sources."""
