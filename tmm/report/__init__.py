"""Scores, radiance costs and previews of texture databases, and the benchmark of the classifiers."""
