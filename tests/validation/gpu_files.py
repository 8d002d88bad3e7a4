"""Reading what `mat export --to gpu` writes, as an engine does."""

import json

import numpy as np

from skyshine.mat.gpu.container import FORMATS, GpuFile, Texture


def read_gpu(path):
    """The content of an export by the path of its header."""
    header = json.loads(path.read_text(encoding="utf-8"))
    stored = (path.parent / header["data"]).read_bytes()

    def texels(entry):
        kind, channels = FORMATS[entry["format"]]
        width, height, depth = entry["size"]
        values = np.frombuffer(stored, kind, width * height * depth * channels, entry["offset"])
        return Texture(entry["format"], values.reshape(depth, height, width, channels), entry["what"])

    textures = {name: texels(entry) for name, entry in header["textures"].items()}
    return GpuFile(header["kind"], header["source"], textures, header["numbers"], header["stated_error"])
