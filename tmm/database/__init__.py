"""The texture database ``.tmm.h5``: layout, mip levels, reader, checks, shares of materials."""
