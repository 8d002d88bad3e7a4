"""Every module of the package imports on a system without the modules of POSIX, such as Windows."""

import subprocess
import sys

WITHOUT_POSIX = """
import sys, pkgutil, importlib
for name in ("resource", "fcntl", "pwd", "grp", "termios", "tty", "pty"):
    sys.modules[name] = None
import skyshine
NO_MODULES = ("skyshine.mat.kernel.backend", "skyshine.mat.kernel.libskyshine")  # pip's; the library, loaded by ctypes
names = [module.name for module in pkgutil.walk_packages(skyshine.__path__, "skyshine.")]
for name in names:
    if name not in NO_MODULES and not name.endswith("__main__") and not name.startswith("skyshine.examples."):
        try:
            importlib.import_module(name)
        except ImportError as error:
            print(name, error)
from skyshine.schemas.process_memory import peak_memory
assert peak_memory() is None
print(len(names), "modules")
"""


def test_every_module_imports_without_the_modules_of_posix():
    result = subprocess.run([sys.executable, "-c", WITHOUT_POSIX], capture_output=True, text=True)
    *failed, count = result.stdout.splitlines()
    assert not failed and int(count.split()[0]) > 300, result.stdout + result.stderr
