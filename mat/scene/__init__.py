"""From a job to physics: states of the air, bands, sources, surfaces."""
