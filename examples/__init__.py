"""Jobs and textures that run as they are."""
