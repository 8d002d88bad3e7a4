"""A runtime's reader of the databases with h5py and numpy alone."""
