"""Random changes to the structure of a database file, by seed: what the named corpus did not think of.

Usage: python tests/fuzz/hostile_random.py NUMBER [FIRST_SEED]

reads so many files with the C library, under sanitizers, and with the package: neither may crash, hang or complain in
more than one line, and where both read a file, they must read the same from it. Ends with status 1 where one does not,
and names the seeds.
"""

from __future__ import annotations

import contextlib
import json
import multiprocessing
import random
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import hdf5_changes as change
from good_databases import READ_BY_RUNTIMES, scene, write_all

MOST_CHANGES = 3
TEXTS = ("", "linear", "exact", "linear_periodic", "linear_folded", "clamp", "error", "4.0.0", "x" * 300, "\n", "µ\0ß")
NUMBERS = (0, -1, 1, 360, 24.0, 1e308, -1e-300, float("nan"), float("inf"), 2**62)
KINDS = ("f2", "<f4", ">f4", "f8", ">f8", "i1", "<i4", ">i4", "i8", "u2", "u4", "u8", "c8", "S3", "?", "V7")
REFUSALS = (OSError, KeyError, ValueError, TypeError, RuntimeError, AttributeError, IndexError, OverflowError)
LENGTHS = (0, 1, 2, 3, 4, 37, 2701)
Change = Callable[[h5py.File, random.Random], None]


def mutate(path: Path, draw: random.Random) -> None:
    """Change a file in place; a change that the library refuses to make is left out."""
    with h5py.File(path, "r+") as file:
        for _ in range(draw.randint(1, MOST_CHANGES)):
            with contextlib.suppress(
                OSError, KeyError, ValueError, TypeError, RuntimeError, AttributeError, IndexError
            ):
                draw.choice(CHANGES)(file, draw)


def _some_array(file: h5py.File, draw: random.Random) -> str:
    return draw.choice([name for name, item in file.items() if isinstance(item, h5py.Dataset)])


def _value(draw: random.Random) -> Any:
    plain = draw.choice([*TEXTS, *NUMBERS])
    return draw.choice(
        [
            plain,
            plain,
            [plain] * draw.choice([1, 2, 70, 2000]),
            h5py.Empty("f8"),
            h5py.Empty(h5py.string_dtype()),
            np.bytes_(bytes(draw.randrange(1, 256) for _ in range(draw.choice([1, 6, 90])))),
            np.zeros((2, 3), draw.choice(KINDS)),
        ]
    )


def _set_attribute(file: h5py.File, draw: random.Random) -> None:
    item = draw.choice(["/", *file])
    key = draw.choice([*file[item].attrs, "period", "interpolation", "out_of_range"])
    change.set_attribute(file, item, key, _value(draw))


def _drop_attribute(file: h5py.File, draw: random.Random) -> None:
    item = file[draw.choice(["/", *file])]
    del item.attrs[draw.choice([*item.attrs])]


def _replace(file: h5py.File, draw: random.Random) -> None:
    """Another type, shape, chunking or byte order, keeping as many values as fit."""
    name = _some_array(file, draw)
    old, kind = file[name], draw.choice([*KINDS, file[name].dtype])
    shape = list(old.shape)
    if shape and draw.random() < 0.5:
        shape[draw.randrange(len(shape))] = draw.choice(LENGTHS)
    if draw.random() < 0.2:
        draw.shuffle(shape)
    if draw.random() < 0.1:
        shape = draw.choice([[*shape, 1], shape[:-1], [1, *shape]])
    values = np.resize(old[()], shape).astype(kind)
    how = {} if not shape or 0 in shape or draw.random() < 0.5 else {"chunks": True, "compression": "gzip"}
    change.replace(file, name, values, **how)


def _unwritten(file: h5py.File, draw: random.Random) -> None:
    name = _some_array(file, draw)
    rank = file[name].ndim
    shape = tuple(draw.choice([*LENGTHS, 1 << 20, 1 << 40, (1 << 62) + 1]) for _ in range(rank))
    change.replace(file, name, shape=shape, dtype=file[name].dtype, chunks=(1,) * (rank - 1) + (64,))


def _poke(file: h5py.File, draw: random.Random) -> None:
    name = _some_array(file, draw)
    values = file[name][()]
    values.flat[draw.randrange(values.size)] = draw.choice([*NUMBERS, 0.5, 7, 300])
    file[name][...] = values


def _move(file: h5py.File, draw: random.Random) -> None:
    """Exchange two arrays' names, or put a copy in the place of one."""
    one, other = _some_array(file, draw), _some_array(file, draw)
    if draw.random() < 0.5:
        file.move(one, "between")
        file.move(other, one)
        file.move("between", other)
    else:
        del file[other]
        file.copy(one, other)


def _link(file: h5py.File, draw: random.Random) -> None:
    name, target = _some_array(file, draw), _some_array(file, draw)
    hard = file[target]
    del file[name]
    file[name] = draw.choice([h5py.SoftLink(f"/{target}"), h5py.ExternalLink("/dev/zero", "/x"), hard, file["/"]])


def _rescale(file: h5py.File, draw: random.Random) -> None:
    name = _some_array(file, draw)
    scales = change.scales_of(file, name)
    draw.shuffle(scales)
    change.replace(file, name, file[name][()], scales=scales)


def _store(file: h5py.File, draw: random.Random) -> None:
    name = _some_array(file, draw)
    draw.choice(
        [
            lambda: change.as_virtual(file, name, own=draw.random() < 0.5),
            lambda: change.as_external(file, name),
            lambda: change.with_filter(file, name, claimed=draw.random() < 0.5),
            lambda: change.damaged_chunk(file, name),
        ]
    )()


def _drop(file: h5py.File, draw: random.Random) -> None:
    del file[draw.choice([*file])]


def _texts(file: h5py.File, draw: random.Random) -> None:
    names = [draw.choice(TEXTS).encode() * draw.choice([1, 40]) for _ in range(draw.choice(LENGTHS[:5]))]
    data = np.array([name.replace(b"\0", b"") for name in names], object)
    change.replace(file, draw.choice(["material_name", _some_array(file, draw)]), data, dtype=h5py.string_dtype())


def _flatten(file: h5py.File, draw: random.Random) -> None:
    change.flatten_dimension_list(file, _some_array(file, draw), _value(draw))


CHANGES: list[Change] = [
    _set_attribute,
    _set_attribute,
    _drop_attribute,
    _replace,
    _replace,
    _unwritten,
    _poke,
    _move,
    _link,
    _rescale,
    _store,
    _drop,
    _texts,
    _flatten,
]


def random_file(good: dict[str, Path], folder: Path, seed: int) -> tuple[str, Path]:
    """The file of a seed, and which of the good ones it was; unchanged where the change ends the library's process."""
    draw = random.Random(seed)
    kind = draw.choice(READ_BY_RUNTIMES)
    path = folder / f"random-{seed}.h5"
    path.write_bytes(good[kind].read_bytes())
    mutate_apart(path, draw)
    return kind, path


def mutate_apart(path: Path, draw: random.Random) -> None:
    """`mutate` in a process of its own, for some changes end it; the file is then as it was."""
    before = path.read_bytes()
    writer = multiprocessing.get_context("fork").Process(target=mutate, args=(path, draw))
    writer.start()
    writer.join()
    if writer.exitcode:
        path.write_bytes(before)


def agree(one: str, other: str) -> bool:
    """Whether two loaders show the same pixels, to rounding."""
    first, second = (_by_term(json.loads(shown)) for shown in (one, other))
    shared = first.keys() & second.keys()
    return bool(shared) and all(np.allclose(first[key], second[key], rtol=1e-9, atol=1e-12) for key in shared)


def _by_term(shown: dict[str, Any]) -> dict[str, Any]:
    """Values of all pixels by term: as the library shows them, or from a list of pixels."""
    pixels = shown.get("pixels")
    return shown if pixels is None else {key: [pixel[key] for pixel in pixels] for key in pixels[0]}


def compare(number: int, first: int, loaders: dict[str, Any], folder: Path) -> tuple[Counter[str], list[str]]:
    """Read the files of so many seeds; returns how many were read and refused, and the findings."""
    from runtime_loaders import Answer, judge

    good = write_all(folder)
    counts: Counter[str] = Counter()
    findings = []
    for seed in range(first, first + number):
        kind, path = random_file(good, folder, seed)
        where = folder / "scene.json"
        where.write_text(json.dumps(scene(good | {kind: path})), encoding="utf-8")
        answers: dict[str, Answer] = {name: load(where) for name, load in loaders.items()}
        verdicts = {name: judge(answer, answer) for name, answer in answers.items()}
        for beside in folder.glob("random-*"):
            beside.unlink()
        read = [answer.shown for name, answer in answers.items() if verdicts[name] == "equal"]
        if set(verdicts.values()) == {"refused"}:
            counts["refused"] += 1
        elif set(verdicts.values()) == {"equal"} and agree(*read):
            counts["read alike"] += 1
        elif set(verdicts.values()) == {"equal", "refused"}:
            counts["refused by one"] += 1  # that reads more of the file
        else:
            complaints = {name: answer.complaint.strip()[:160] for name, answer in answers.items()}
            findings.append(f"seed {seed}, {kind}: {verdicts} {complaints}")
    return counts, findings


def main(number: int, first: int) -> None:
    import runtime_loaders as loaders

    with tempfile.TemporaryDirectory() as folder:
        c = loaders.program(loaders.prepared(Path(folder), loaders.SANITIZED), loaders.SANITIZERS)
        counts, findings = compare(number, first, {"c": c, "library": loaders.library()}, Path(folder))
    print("\n".join(findings))
    print(f"{number} files: {dict(counts)}, {len(findings)} findings")
    sys.exit(bool(findings))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0)
