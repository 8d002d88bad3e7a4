"""The table builder: atmospheric quantities and surface temperatures for infrared scene runtimes."""


def __getattr__(name: str):
    if name == "open":  # loads numpy and h5py only when a table is opened
        from skyshine.mat.tables.loader import open_table

        return open_table
    raise AttributeError(f"module 'skyshine.mat' has no attribute '{name}'")
