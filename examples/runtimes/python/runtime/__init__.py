"""A runtime's reader of the databases, atmospheres of format 2 and of format 3, with h5py and numpy alone."""
