"""Material textures in the formats of others: OGC CDB, glTF, DIRSIG, indexed PNG."""
