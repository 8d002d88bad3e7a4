"""The texture database ``.tmm.h5``: its layout, its mip levels, reading it."""
