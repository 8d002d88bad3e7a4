"""Example jobs and a texture, packaged, and example runtimes that read the databases."""
