"""Coverage-guided fuzzing of a reader: python tests/fuzz/fuzz.py TARGET --seconds N

Needs the package atheris. Ends with status 1 and the input that did it where a reader raises anything but `InputError`, takes
more than 10 s, or leaves a file beside its input; else prints how many inputs were tried.
"""

import argparse
import os
import random
import sys
import tempfile
import time
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["skyshine"]):
    sys.path.insert(0, str(Path(__file__).parent))
    import readers
    from skyshine.schemas.errors import InputError

SLOWEST = 10  # s


def mutated(seed: bytes, draw: random.Random) -> bytes:
    """A seed with a few bytes or pieces changed, for targets without coverage of their own (HDF5, images)."""
    data = bytearray(seed)
    for _ in range(draw.randint(1, 6)):
        at, length = draw.randrange(len(data) + 1), draw.choice([1, 1, 2, 4, 8, 40])
        piece = draw.choice([bytes(draw.randrange(256) for _ in range(length)), b"", b"\xff" * length, b"\0" * length, data[:length]])
        data[at : at + draw.choice([0, length])] = piece
    return bytes(data)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("target", choices=readers.READERS)
    parser.add_argument("--seconds", type=float, default=60)
    options = parser.parse_args()
    corpus, tried, draw = readers.seeds(options.target), 0, random.Random(1)
    if not corpus:
        sys.exit("no seeds: set SKYSHINE_FUZZ_TABLES to a folder of databases")
    folder = tempfile.TemporaryDirectory()
    end = time.monotonic() + options.seconds

    def one(data: bytes) -> None:
        nonlocal tried
        # Half of the inputs are bred from good ones, so that they reach what stands behind the syntax.
        data = mutated(draw.choice(corpus), draw) if tried % 2 else data
        begin, tried = time.monotonic(), tried + 1
        try:
            readers.read(options.target, data, Path(folder.name))
        except InputError as error:
            assert "\n" not in str(error)
        except BaseException:
            Path("fuzz-crash").write_bytes(data)
            raise
        if time.monotonic() - begin > SLOWEST or len(list(Path(folder.name).iterdir())) != 1:
            Path("fuzz-crash").write_bytes(data)
            raise AssertionError("slow, or wrote a file")
        if time.monotonic() > end:
            print(f"{options.target}: {tried} inputs, nothing found", flush=True)
            folder.cleanup()
            os._exit(0)  # libFuzzer takes any other end for a crash

    with tempfile.TemporaryDirectory() as start:
        for number, seed in enumerate(corpus):
            (Path(start) / str(number)).write_bytes(seed)
        atheris.Setup([sys.argv[0], "-verbosity=0", "-max_len=20000", f"-timeout={10 * SLOWEST}", start], one)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
