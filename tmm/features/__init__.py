"""What a classifier sees of a texel."""
