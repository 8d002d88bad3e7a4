"""Tables as textures for graphics processors: their files, the shader that reads them, a viewer."""
