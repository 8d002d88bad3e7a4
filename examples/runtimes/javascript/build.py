"""Compiles the C library of mat/kernel as WebAssembly, with the package ziglang: kernel.wasm, in this folder.

Run: python3 build.py; `npm pack` does so.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
KERNEL = HERE.parents[2] / "mat" / "kernel"
sys.path.insert(0, str(KERNEL))

from backend import FLAGS, WARNINGS, zig_folder  # noqa: E402

# 128-bit vectors are in every browser and Node since 2021; the bytes of the results are those without them.
TARGET = "--target=wasm32-freestanding -msimd128 -DLANES=4"
# No import, no start function; callers place their memory behind that of the library.
LINK = "-nostdlib -Wl,--no-entry -Wl,--export-dynamic -Wl,--export=__heap_base -Wl,-z,stack-size=1048576"


def main() -> None:
    flags = [flag for flag in FLAGS.split() if flag != "-fPIC"]
    sources = sorted(str(path) for path in KERNEL.glob("*.c"))
    with tempfile.TemporaryDirectory() as cache:
        command = [zig_folder() / "zig", "cc", *TARGET.split(), *flags, *WARNINGS.split(), *LINK.split(), *sources]
        environment = os.environ | {"ZIG_LOCAL_CACHE_DIR": cache, "ZIG_GLOBAL_CACHE_DIR": cache}
        subprocess.run([*command, "-o", HERE / "kernel.wasm"], env=environment, check=True)


if __name__ == "__main__":
    main()
