"""The products of a build, one module per file type: dependencies and computation of each."""
