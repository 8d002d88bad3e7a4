"""Error against run time of each part, and the peers it is compared with."""
