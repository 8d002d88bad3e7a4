"""What a job names, read: images, seed polygons and seed texels."""
