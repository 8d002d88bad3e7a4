"""Export and import of material textures: OGC CDB, glTF, DIRSIG, indexed PNG."""
