"""The physics of a job: states of the air, bands, sources, surfaces, omitted terms."""
