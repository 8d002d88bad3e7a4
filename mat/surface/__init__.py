"""Surface temperature: the heat balance of a three-layer column under sunlight, sky longwave and weather."""
