"""The C library: how it is compiled, found and checked against its sources."""

import ctypes
import importlib
import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from skyshine.mat.kernel import library as kernel
from skyshine.schemas.errors import InputError

CHECKOUT = Path(__file__).parents[2]
SOURCES = CHECKOUT / "mat" / "kernel"
# First bytes of a library, with the machine at its place: ELF, Mach-O and PE.
X86_64, AARCH64 = b"\x3e\x00", b"\xb7\x00"
ELF, MACHO = b"\x7fELF", b"\xcf\xfa\xed\xfe"
WIDTH = """
#include "export.h"
#ifdef __AVX2__
#define INSTRUCTIONS 1000
#else
#define INSTRUCTIONS 0
#endif
SKYSHINE_EXPORT int SKYSHINE_NAME(width)(int x) { return LANES * x + INSTRUCTIONS; }
"""


@pytest.fixture(scope="module")
def backend():
    """The module that pip calls, imported as pip does."""
    sys.path.insert(0, str(SOURCES))
    try:
        return importlib.import_module("backend")
    finally:
        sys.path.remove(str(SOURCES))


@pytest.fixture(scope="module")
def compiler(backend):
    found = backend.machine_compiler()
    if found is None:
        pytest.skip("no C compiler works here")
    return found


@pytest.fixture(scope="module")
def tree(backend, compiler, tmp_path_factory):
    """A folder as that of an editable installation: the sources and the library that was compiled from them."""
    folder = tmp_path_factory.mktemp("kernel")
    for file in backend.SOURCES.iterdir():
        if file.suffix in (".c", ".h", ".py"):
            shutil.copy(file, folder)
    shutil.copy(kernel.library()._name, folder)
    try:
        kernel._load(folder)
    except InputError:  # installed from other sources than those of the checkout
        backend.compile_library(compiler, folder / kernel.NAME)
    return folder


def test_the_library_is_that_of_its_sources_in_an_editable_tree(tree):
    assert kernel._load(tree).skyshine_lanes() == kernel.library().skyshine_lanes()


@pytest.mark.parametrize("name", ["processor.c", "export.h", "backend.py"])
def test_a_library_of_other_sources_is_refused(tree, tmp_path, name):
    shutil.copytree(tree, tmp_path / "tree")
    with (tmp_path / "tree" / name).open("a", encoding="utf-8") as file:
        file.write("\n")
    with pytest.raises(InputError, match=r"compiled from other sources; compile it with `pip install -e \.`"):
        kernel._load(tmp_path / "tree")


def test_a_library_without_sources_beside_it_is_that_of_a_wheel(tree, tmp_path):
    shutil.copy(tree / kernel.NAME, tmp_path)
    assert kernel._load(tmp_path).skyshine_lanes() in (4, 8)


def test_a_missing_library_and_a_damaged_one_say_what_to_do(tmp_path):
    with pytest.raises(InputError, match=r"library is missing; install it with `pip install \.`"):
        kernel._load(tmp_path)
    (tmp_path / kernel.NAME).write_bytes(b"no library")
    with pytest.raises(InputError, match=r"does not load the library \(.*; install it"):
        kernel._load(tmp_path)


def test_the_environment_states_the_lanes(monkeypatch):
    monkeypatch.delenv(kernel.VARIABLE, raising=False)
    most = kernel.lanes.__wrapped__()
    if sys.platform == "linux" and os.uname().machine == "x86_64":
        assert most == (8 if re.search(r"\bavx2\b", Path("/proc/cpuinfo").read_text()) else 4)
    for number in {4, most}:
        monkeypatch.setenv(kernel.VARIABLE, str(number))
        assert kernel.lanes.__wrapped__() == number
    monkeypatch.setenv(kernel.VARIABLE, "6")
    with pytest.raises(InputError, match=r"SKYSHINE_LANES=6: allowed on this processor: 4.*; unset it"):
        kernel.lanes.__wrapped__()


def test_a_function_has_the_name_of_its_lanes(backend, compiler, tmp_path, monkeypatch):
    """Each source is compiled once for each number of lanes."""
    sources = tmp_path / "sources"
    sources.mkdir()
    once = ("freestanding.c", "processor.c")  # what a library of one function needs
    for name in (*once, "export.h"):
        shutil.copy(SOURCES / name, sources)
    monkeypatch.setattr(backend, "ONCE", once)
    (sources / "width.c").write_text(WIDTH, encoding="utf-8")
    monkeypatch.setattr(backend, "SOURCES", sources)
    backend.compile_library(compiler, tmp_path / kernel.NAME)
    loaded = ctypes.CDLL(str(tmp_path / kernel.NAME))
    monkeypatch.setattr(kernel, "library", lambda: loaded)
    monkeypatch.setattr(kernel, "lanes", kernel.lanes.__wrapped__)
    for number in {4, loaded.skyshine_lanes()}:
        monkeypatch.setenv(kernel.VARIABLE, str(number))
        assert kernel.function("width", [ctypes.c_int], ctypes.c_int)(3) == 3 * number + 1000 * (number == 8)
    with pytest.raises(AttributeError):
        kernel.function("height", [], None)


@pytest.mark.parametrize("processor", [[], ["-U__x86_64__"]])
def test_the_functions_that_compilers_call_do_what_those_of_c_do(backend, compiler, tmp_path, processor):
    flags = [flag for flag in backend.FLAGS.split() if "visibility" not in flag] + processor
    flags += ["-Wl,-Bsymbolic"] if sys.platform == "linux" else []  # they call each other, not those of the C library
    file = tmp_path / f"memory{Path(kernel.NAME).suffix}"
    compiler.run(*flags, *compiler.link(), SOURCES / "freestanding.c", "-o", file, folder=tmp_path)
    made = ctypes.CDLL(str(file))
    start = bytes(range(1, 41))
    for count in (0, 1, 7, 8, 9, 19):
        for to, source in ((0, 0), (0, 3), (3, 0), (8, 0), (18, 0), (1, 20), (20, 1)):
            expected = bytearray(start)
            expected[to : to + count] = start[source : source + count]
            memory = ctypes.create_string_buffer(start, len(start))
            address = ctypes.addressof(memory)
            made.memmove(ctypes.c_void_p(address + to), ctypes.c_void_p(address + source), ctypes.c_size_t(count))
            assert memory.raw == bytes(expected), (count, to, source)
        memory = ctypes.create_string_buffer(start, len(start))
        made.memcpy(ctypes.byref(memory, 20), start, ctypes.c_size_t(count))
        made.memset(ctypes.byref(memory, 1), 0x1FE, ctypes.c_size_t(count))
        expected = start[:20] + start[:count] + start[20 + count :]
        assert memory.raw == expected[:1] + b"\xfe" * count + expected[1 + count :]
    pairs = ((b"abc", b"abd"), (b"abc", b"abc"), (b"\xffbc", b"abc"))
    assert [made.memcmp(*pair, ctypes.c_size_t(3)) for pair in pairs] == [-1, 0, 1]


def test_zig_is_asked_for_where_no_compiler_works(backend, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    assert backend.get_requires_for_build_wheel() == [backend.ZIG] == backend.get_requires_for_build_editable({})
    assert backend.get_requires_for_build_sdist() == []


def test_a_compiler_named_by_the_environment_comes_first(backend, compiler, monkeypatch, tmp_path):
    path = shutil.which(compiler.command[0])
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("CC", f"{path} -B{Path(path).parent}")
    assert backend.machine_compiler().command == (path, f"-B{Path(path).parent}")
    assert backend.get_requires_for_build_wheel() == []
    monkeypatch.setenv("CC", "/bin/false")
    assert backend.machine_compiler() is None


def test_an_unknown_target_and_one_of_an_editable_installation_are_refused(backend):
    with pytest.raises(SystemExit, match="-C target=win32: allowed: manylinux_2_17_x86_64, "):
        backend.get_requires_for_build_wheel({"target": "win32"})
    with pytest.raises(SystemExit, match="editable installation is of this system"):
        backend.get_requires_for_build_editable({"target": "win_amd64"})
    assert backend.get_requires_for_build_wheel({"target": "win_amd64"}) == [backend.ZIG]


def test_wrong_c_shows_what_the_compiler_says(backend, compiler, monkeypatch, tmp_path):
    (tmp_path / "wrong.c").write_text("int f(void) { return absent; }\n")
    monkeypatch.setattr(backend, "SOURCES", tmp_path)
    with pytest.raises(SystemExit, match=r"(?s)the C library does not compile: .*wrong\.c:1.*absent"):
        backend.compiled(compiler, tmp_path / kernel.NAME)


def test_no_module_of_the_build_hides_one_of_the_standard_library():
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))
    (folder,) = project["build-system"]["backend-path"]
    assert not {file.stem for file in (CHECKOUT / folder).glob("*.py")} & sys.stdlib_module_names


@pytest.mark.validation
def test_one_command_builds_the_wheels_of_all_systems(backend, tmp_path):
    done = subprocess.run([sys.executable, SOURCES / "backend.py", tmp_path], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    machine = {}
    for target in backend.TARGETS:
        (wheel,) = tmp_path.glob(f"skyshine-*-py3-none-{target}.whl")
        with zipfile.ZipFile(wheel) as archive:
            (name,) = [name for name in archive.namelist() if "libskyshine" in name]
            content = archive.read(name)
        place = {ELF: 18, MACHO: 4}.get(content[:4]) or int.from_bytes(content[60:64], "little") + 4
        machine[target] = name.rpartition(".")[2], content[place : place + 2]
    assert machine == {
        "manylinux_2_17_x86_64": ("so", X86_64),
        "manylinux_2_17_aarch64": ("so", AARCH64),
        "macosx_11_0_arm64": ("dylib", b"\x0c\x00"),
        "macosx_10_12_x86_64": ("dylib", b"\x07\x00"),
        "win_amd64": ("dll", b"\x64\x86"),
    }
    assert len(list(tmp_path.glob("skyshine-*.tar.gz"))) == 1
