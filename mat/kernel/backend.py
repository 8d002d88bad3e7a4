"""The build backend of the project: it compiles the C library, and scikit-build-core packs it with the rest.

The compiler is that of the environment variable CC, else cc, gcc or clang; where none of them makes a library that
this Python loads, it is the one in the package `ziglang`, which pip then puts into the build environment. The library
is linked without any other. An editable installation has it beside the sources; a wheel is built without writing there.

A wheel for another system: pip wheel . --no-deps -C target=win_amd64 (the names are those of `TARGETS`). All of them,
and a source distribution:

    python mat/kernel/backend.py OUT

Modules of this folder are on the path of the build, so none may have the name of a module of the standard library.
"""

from __future__ import annotations

import ctypes
import importlib.util
import os
import platform
import shlex
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sources import sources_digest

SOURCES = Path(__file__).resolve().parent
TRIED = ("freestanding.c", "processor.c")  # need no other source
ONCE = (
    *TRIED,
    "dispatch.c",
    "layouts.c",
    "tables.c",
)  # the others once for each number of lanes
# Flags of x86-64; other processors have 4 and no flag. Those without AVX2 get code that compiles in half the time.
LANES = {"4": ["-msse2", "-O2"], "8": ["-mavx2"]}
ZIG = "ziglang>=0.17"  # 0.14 takes 13 s instead of 0.1 and expects another entry of a Windows library

# Platform tags of wheels, with the target of zig: its system version is the lowest that the tag allows.
TARGETS = {
    "manylinux_2_17_x86_64": "x86_64-linux-gnu.2.17",
    "manylinux_2_17_aarch64": "aarch64-linux-gnu.2.17",
    "macosx_11_0_arm64": "aarch64-macos.11.0",
    "macosx_10_12_x86_64": "x86_64-macos.10.12",
    "win_amd64": "x86_64-windows-gnu",
}
MACOS_LIBRARY = "lib/libc/darwin/libSystem.tbd"  # in the package ziglang: names the system's library and its functions
SUFFIX = {"linux": ".so", "macos": ".dylib", "windows": ".dll"}

# No contraction and no fast mathematics: every compiler and processor gives the same bytes. Distributions switch the
# stack protector on, which calls a function of their C library.
FLAGS = "-std=c11 -O3 -ffp-contract=off -fno-math-errno -ffreestanding -fno-stack-protector -fPIC -fvisibility=hidden"
WARNINGS = "-g0 -Wall -Wextra -Wno-psabi -Wno-unknown-warning-option"


@dataclass(frozen=True)
class Compiler:
    """A C compiler that takes the flags of gcc, the processor and the system that it compiles for."""

    command: tuple[str, ...]
    machine: str
    system: str
    zig: bool = False

    def link(self) -> list[str]:
        if self.system == "macos":  # macOS loads no library that names none of its own
            return ["-shared", *(["-nostdlib", str(zig_folder() / MACOS_LIBRARY)] if self.zig else [])]
        return ["-shared", "-nostdlib"] + ["-Wl,--no-undefined"] * (self.system == "linux")

    def run(self, *arguments: str | Path, folder: Path) -> None:
        environment = os.environ | {"ZIG_LOCAL_CACHE_DIR": str(folder), "ZIG_GLOBAL_CACHE_DIR": str(folder)}
        command = [*self.command, *map(str, arguments)]
        process = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
        if process.returncode:
            raise CompilerError(f"{shlex.join(command)}\n{process.stdout}{process.stderr}")
        if process.stderr:
            print(process.stderr, file=sys.stderr)


class CompilerError(Exception):
    """A compiler that is absent or fails, with its command and what it wrote."""


def compile_library(compiler: Compiler, output: Path, names: list[str] | None = None) -> None:
    """Compile and link the sources of this folder.

    Parameters
    ----------
    output : Path
        The library. It is replaced whole, so that programs that have it loaded go on with theirs.
    names : list of str, optional
        Sources; all by default.
    """
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        digest = f'-DSKYSHINE_SOURCES="{sources_digest(SOURCES)}"'
        jobs = []
        for name in names or sorted(file.name for file in SOURCES.glob("*.c")):
            variants = LANES if compiler.machine == "x86_64" and name not in ONCE else {"4": []}
            jobs += [(name, f"{name}.{lanes}.o", lanes, extra) for lanes, extra in variants.items()]

        def compile_one(job: tuple[str, str, str, list[str]]) -> str:
            name, compiled, lanes, extra = job
            flags = [*FLAGS.split(), *WARNINGS.split(), digest, f"-DLANES={lanes}", *extra]
            compiler.run(*flags, "-c", SOURCES / name, "-o", compiled, folder=folder)
            return compiled

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            objects = list(pool.map(compile_one, jobs))
        linked = f"libskyshine{SUFFIX[compiler.system]}"
        compiler.run(*objects, *compiler.link(), "-o", linked, folder=folder)
        partial = output.with_name(f"{output.name}.{os.getpid()}.part")
        partial.write_bytes((folder / linked).read_bytes())
        partial.replace(output)


def this_system() -> str:
    return {"win32": "windows", "darwin": "macos"}.get(sys.platform, "linux")


def this_machine() -> str:
    name = platform.machine().lower()
    return {"amd64": "x86_64", "arm64": "aarch64"}.get(name, name)


def works(compiler: Compiler) -> bool:
    """Whether the compiler makes a library that this Python loads."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        library = Path(folder) / f"tried{SUFFIX[compiler.system]}"
        try:
            compile_library(compiler, library, list(TRIED))
            return ctypes.CDLL(str(library)).skyshine_lanes() in (4, 8)
        except (CompilerError, OSError):
            return False


def machine_compiler() -> Compiler | None:
    """The first of CC, cc, gcc and clang that works here."""
    for text in filter(None, (os.environ.get("CC"), "cc", "gcc", "clang")):
        compiler = Compiler(tuple(shlex.split(text)), this_machine(), this_system())
        if works(compiler):
            return compiler
    return None


def zig_folder() -> Path:
    """Folder of the package ziglang."""
    spec = importlib.util.find_spec("ziglang")
    if spec is None or spec.origin is None:
        raise SystemExit("no C compiler works here (CC, cc, gcc, clang); install one, or the package ziglang with pip")
    return Path(spec.origin).parent


def zig_compiler(target: str) -> Compiler:
    """The compiler of the package ziglang, for a target such as `x86_64-linux-gnu`."""
    zig_folder()
    machine, system = target.split("-")[:2]
    command = (sys.executable, "-m", "ziglang", "cc", "-target", target)
    return Compiler(command, machine, system.split(".")[0], zig=True)


def zig_target() -> str:
    """The target of zig for this system."""
    end = {"linux": "linux-gnu", "macos": "macos", "windows": "windows-gnu"}[this_system()]
    return f"{this_machine()}-{end}"


def asked_target(config_settings: dict[str, Any] | None) -> str | None:
    target = (config_settings or {}).get("target")
    if target is not None and target not in TARGETS:
        raise SystemExit(f"-C target={target}: allowed: {', '.join(TARGETS)}")
    return target


def compiler_for(target: str | None) -> Compiler:
    if target:
        return zig_compiler(TARGETS[target])
    return machine_compiler() or zig_compiler(zig_target())


def compiled(compiler: Compiler, output: Path) -> None:
    try:
        compile_library(compiler, output)
    except CompilerError as error:
        raise SystemExit(f"the C library does not compile: {error}") from None


# ---- The hooks of PEP 517 and PEP 660


def get_requires_for_build_wheel(config_settings: dict[str, Any] | None = None) -> list[str]:
    return [ZIG] if asked_target(config_settings) or machine_compiler() is None else []


def get_requires_for_build_editable(config_settings: dict[str, Any] | None = None) -> list[str]:
    if asked_target(config_settings):
        raise SystemExit("-C target: an editable installation is of this system; build a wheel for others")
    return get_requires_for_build_wheel()


def get_requires_for_build_sdist(config_settings: dict[str, Any] | None = None) -> list[str]:
    return []


def build_sdist(sdist_directory: str, config_settings: dict[str, Any] | None = None) -> str:
    from scikit_build_core import build

    filename: str = build.build_sdist(sdist_directory, config_settings)
    return filename


def build_wheel(
    wheel_directory: str, config_settings: dict[str, Any] | None = None, metadata_directory: str | None = None
) -> str:
    from scikit_build_core import build

    settings, target = dict(config_settings or {}), asked_target(config_settings)
    compiler = compiler_for(settings.pop("target", None))
    if target:
        settings["wheel.tags"] = f"py3-none-{target}"
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder).resolve() / f"libskyshine{SUFFIX[compiler.system]}"
        compiled(compiler, library)
        settings[f"wheel.force-include.{library}"] = f"skyshine/mat/kernel/{library.name}"
        filename: str = build.build_wheel(wheel_directory, settings, metadata_directory)
    return filename


def build_editable(
    wheel_directory: str, config_settings: dict[str, Any] | None = None, metadata_directory: str | None = None
) -> str:
    from scikit_build_core import build

    compiler = compiler_for(None)
    compiled(compiler, SOURCES / f"libskyshine{SUFFIX[compiler.system]}")
    filename: str = build.build_editable(wheel_directory, config_settings, metadata_directory)
    return filename


def main() -> None:
    """Build a source distribution and the wheels of all targets into the folder that is named."""
    from build import ProjectBuilder
    from build.env import DefaultIsolatedEnv

    if len(sys.argv) != 2:
        raise SystemExit("usage: python mat/kernel/backend.py OUT")
    with DefaultIsolatedEnv() as environment:
        builder = ProjectBuilder.from_isolated_env(environment, SOURCES.parents[1])
        environment.install({*builder.build_system_requires, ZIG})
        builder.build("sdist", sys.argv[1])
        for target in TARGETS:
            builder.build("wheel", sys.argv[1], {"target": target})


if __name__ == "__main__":
    main()
