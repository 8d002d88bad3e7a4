"""What every build measures: probes, error scales, profiles along axes, nodes placed by tolerance."""
