"""Training of classifiers on the seeds of one texture or of a library of textures."""
