"""Coverage-guided fuzzing of the readers: python tests/fuzz/fuzz.py [TARGET ...] --seconds N

Needs the package atheris. Without TARGET all are fuzzed, one after another, each in a process of its own for its share
of the time. Ends with status 1 where a reader raises anything but `InputError` in one line, takes more than 10 s of
processor time, or touches anything beside its input; the input that did it then stands in ``fuzz-TARGET``. Else prints
how many inputs were tried.

The targets ``table``, ``flat``, ``classifier`` and ``database`` change the bytes of files that a build made, in the
folder SKYSHINE_FUZZ_TABLES. The target ``structure`` changes what stands in small databases of its own: arrays,
attributes, dimension scales, storage and links (hostile_random.py); ``fuzz.py structure --seconds 180`` runs it alone.
Of texts a third of the inputs have other numbers, words, fields, lines or values (text_changes.py).
"""

import argparse
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SLOWEST = 10  # s
MUTATIONS = 6
CHANGING = ("os.mkdir", "os.remove", "os.rename", "os.rmdir", "os.link", "os.symlink", "os.truncate", "os.chmod")
ESCAPING = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "socket.connect")


def mutated(seed: bytes, draw: random.Random) -> bytes:
    """A seed with a few bytes or pieces changed, for targets without coverage of their own (HDF5, images)."""
    data = bytearray(seed)
    for _ in range(draw.randint(1, MUTATIONS)):
        at, length = draw.randrange(len(data) + 1), draw.choice([1, 1, 2, 4, 8, 40])
        piece = draw.choice(
            [bytes(draw.randrange(256) for _ in range(length)), b"", b"\xff" * length, b"\0" * length, data[:length]]
        )
        data[at : at + draw.choice([0, length])] = piece
    return bytes(data)


class Watch:
    """What the interpreter changes, runs or connects to outside a folder; `touched` holds the first of it."""

    def __init__(self, folder: Path):
        self.folder, self.touched, self.armed = str(folder), None, False
        sys.addaudithook(self._hear)

    def _hear(self, event: str, arguments: tuple) -> None:
        if not self.armed or self.touched:
            return
        opens = (
            event == "open"
            and isinstance(arguments[2], int)
            and arguments[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC)
        )
        if event in ESCAPING or ((opens or event in CHANGING) and not self._inside(arguments[0])):
            self.touched = f"{event} {arguments[0]!r}"

    def _inside(self, path) -> bool:
        return (
            isinstance(path, int) or path == os.devnull or os.path.realpath(os.fsdecode(path)).startswith(self.folder)
        )


def fuzz(target: str, seconds: float, seed_of_draws: int) -> None:
    """Fuzz a target in this process, which ends here."""
    import atheris

    with atheris.instrument_imports(include=["skyshine"]):
        sys.path.insert(0, str(Path(__file__).parent))
        import readers

        from skyshine.schemas.errors import InputError

    corpus, tried, draw = readers.seeds(target), 0, random.Random(seed_of_draws)
    if not corpus:
        print(f"{target}: no seeds; set SKYSHINE_FUZZ_TABLES to a folder of databases", flush=True)
        return
    began, found = Path.cwd(), None
    # C libraries are not heard by the watch: what they write by a relative name or as a temporary file lands in these
    # folders.
    home = tempfile.TemporaryDirectory(prefix=f"fuzz-{target}-")
    print(f"{target}: should a library end this process, the input stands in {home.name}", file=sys.stderr, flush=True)
    folder, beside = (Path(home.name).resolve() / name for name in ("input", "beside"))
    folder.mkdir()
    beside.mkdir()
    os.chdir(beside)
    tempfile.tempdir = os.environ["TMPDIR"] = str(beside)
    # Temporary folders may come and go; what stays beside the input is found below.
    watch, end = Watch(folder.parent), time.monotonic() + seconds

    def one(data: bytes) -> None:
        nonlocal tried, found
        # Most inputs are bred from good ones, so that they reach what comes after the syntax; a third by coverage.
        if tried % 3:
            seed = draw.choice(corpus)
            data = (readers.changed(target, seed, draw) if tried % 3 == 1 else None) or mutated(seed, draw)
        begin, tried = time.process_time(), tried + 1
        try:
            watch.armed = tried > 1  # the first loads what readers import late
            readers.read(target, data, folder)
            watch.armed = False
        except InputError as error:
            watch.armed = False
            found = "found a message of several lines" if "\n" in str(error) else None
        except BaseException:
            (began / f"fuzz-{target}").write_bytes(data)
            raise
        if time.process_time() - begin > SLOWEST:
            found = "was slow"
        if watch.touched or any(beside.iterdir()) or not all(path.name.startswith("in.") for path in folder.iterdir()):
            found = f"touched {watch.touched or 'a file beside its input'}"
        if found:
            (began / f"fuzz-{target}").write_bytes(data)
            raise AssertionError(f"{target} {found}")
        if time.monotonic() > end:
            print(
                f"{target}: {tried} inputs in {time.process_time():.0f} s of processor time, nothing found", flush=True
            )
            home.cleanup()
            os._exit(0)  # libFuzzer takes any other end for a crash

    start = Path(home.name) / "start"
    start.mkdir()
    for number, seed in enumerate(corpus):
        (start / str(number)).write_bytes(seed)
    longest = 2 * max(map(len, corpus))
    options = ["-verbosity=0", f"-max_len={longest}", f"-timeout={10 * SLOWEST}", f"-artifact_prefix={began}/"]
    atheris.Setup([sys.argv[0], *options, str(start)], one)
    atheris.Fuzz()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("targets", nargs="*", metavar="TARGET")
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--seed", type=int, default=1, help="Of the draws: another gives other inputs.")
    options = parser.parse_args()
    if len(options.targets) == 1:
        fuzz(options.targets[0], options.seconds, options.seed)
        return
    targets = options.targets or _names()
    failed = []
    for target in targets:
        command = [sys.executable, __file__, target, "--seconds", str(options.seconds / len(targets))]
        command += ["--seed", str(options.seed)]
        done = subprocess.run(command, capture_output=True, text=True)
        words = [line for line in (done.stdout + done.stderr).splitlines() if not line.startswith(("INFO", "WARNING"))]
        print(
            done.stdout.strip() if done.returncode == 0 else "\n".join([f"{target} failed", *words[-40:]]), flush=True
        )
        failed += [target] * (done.returncode != 0)
    print(f"{len(targets)} readers, {len(failed)} failed: {', '.join(failed) or 'none'}")
    sys.exit(bool(failed))


def _names() -> list[str]:
    sys.path.insert(0, str(Path(__file__).parent))
    import readers

    return list(readers.READERS)


if __name__ == "__main__":
    main()
