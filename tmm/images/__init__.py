"""Image files: texels, colours, labels and georeferences."""
