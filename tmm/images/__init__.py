"""Image files: texels, colours, labels, and where they lie on the ground."""
