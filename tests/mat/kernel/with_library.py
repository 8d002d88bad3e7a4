"""Run tests with another compiled library than the one beside the package, each call with memory of its own size.

python tests/mat/kernel/with_library.py LIBRARY [ARGUMENTS OF PYTEST ...]
"""

import ctypes
import sys

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer import kernel_arrays
from skyshine.mat.kernel import library

if __name__ == "__main__":
    loaded = ctypes.CDLL(sys.argv[1])
    library.library = lambda: loaded

    def exactly(scratch, size):
        scratch._memory = np.empty(size, np.uint8)
        return scratch._memory.ctypes.data

    kernel_arrays.Scratch.of = exactly
    sys.exit(pytest.main(sys.argv[2:]))
